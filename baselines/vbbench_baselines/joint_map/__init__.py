"""Everybody and every frame at once: joint maximum a posteriori solvers, beyond the paper (docs/map-solver.md)."""
