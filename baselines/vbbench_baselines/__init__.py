"""Solvers bundled with vbbench: extrapolation baselines and the view birdification reference."""
