"""Lifting of heads in a surveillance picture to the ground plane: self-calibration, or a homography, and smoothing."""
