"""Films of a sequence: what the observer sees, next to the map of truth and estimate."""
