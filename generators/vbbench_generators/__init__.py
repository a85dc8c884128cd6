"""Scenes and sequences: readers of recorded trajectories, reprojection, corruption, and split recipes."""
