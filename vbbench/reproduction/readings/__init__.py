"""Table 2 under every reading of the paper."""
