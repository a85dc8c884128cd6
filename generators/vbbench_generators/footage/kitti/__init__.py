"""KITTI tracking: people seen by the camera of a car, in the layout of the official download."""
