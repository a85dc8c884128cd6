"""The figure of errors over the number of people, for several spreads of their heights."""
