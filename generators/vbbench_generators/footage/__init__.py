"""Footage: recordings of real cameras as datasets."""
