"""Datasets and submissions on disk: their tables, their facts, and what is checked when they are read."""
