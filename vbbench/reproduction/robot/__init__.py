"""The experiment of a robot whose motion nobody tells: its map, what it sees, and drift over the distance driven."""
