"""Datasets and submissions on disk: their tables, their facts, and the checks of both."""
