"""What every solver stands on: measurements on the ground, the past, the pose of least energy and its uncertainty."""
