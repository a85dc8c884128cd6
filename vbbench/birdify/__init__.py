"""Boxes in, map out: from a user's recording to poses, positions, pictures and a report of how sure they are."""
