"""Films of a sequence: what the observer sees beside the map of what is so and what was estimated."""
