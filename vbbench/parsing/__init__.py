"""Strict reading of what strangers write: numbers, ranges, JSON."""
