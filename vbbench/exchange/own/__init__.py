"""Recordings of the user's own camera as footage: camera file, boxes, and optional odometry, poses and people."""
