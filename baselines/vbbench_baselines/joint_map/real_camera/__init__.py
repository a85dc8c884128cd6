"""The joint problem seen by a real camera, whose tilt, height, noise and bearer are known only roughly."""
