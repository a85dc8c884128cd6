"""What the joint solvers see: boxes as places with their noise, and the frames that are solved together."""
