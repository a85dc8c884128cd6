"""The paper's figure of the five-point method: static points at a distance, and from where on people tell more."""
