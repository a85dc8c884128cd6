"""How people walk in a crowd, in figures, so that simulated crowds can be compared with recorded ones."""
