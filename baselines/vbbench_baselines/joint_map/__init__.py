"""All people and frames at once: joint maximum a posteriori solvers, beyond the paper (docs/map-solver.md)."""
