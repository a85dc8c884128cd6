"""Training of `vb-former`, on simulated crowds alone, which are generated when first needed."""
