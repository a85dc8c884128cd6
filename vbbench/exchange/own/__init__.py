"""Recordings of the user's own camera: camera file, boxes, and whatever else was measured, as footage."""
