"""Recorded crowds: recipes of splits, and readers of their files."""
