"""Readers of recorded trajectories: every one is a function from a file to a validated ``vbbench.scene.Scene``."""
