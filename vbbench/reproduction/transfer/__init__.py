"""Whether tier `field` ranks solvers as a real camera does."""
