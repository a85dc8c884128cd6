"""One example of every split: where people and observer walked, and where a solver says that they did."""
