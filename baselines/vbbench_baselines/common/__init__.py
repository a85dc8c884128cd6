"""What solvers share: measurements on the ground, motion and its history, drift, cold starts."""
