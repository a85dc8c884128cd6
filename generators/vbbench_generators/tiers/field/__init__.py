"""The tier `field`: a simulated camera with the errors of real footage; its recipe has a source for each value."""
