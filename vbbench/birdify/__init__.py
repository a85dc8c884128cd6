"""Boxes in, map out: from somebody's own recording to poses, positions, pictures and a report of how sure they are."""
