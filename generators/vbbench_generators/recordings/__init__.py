"""Recorded crowds: recipes of splits, readers of their files, and who may observe whom in them."""
