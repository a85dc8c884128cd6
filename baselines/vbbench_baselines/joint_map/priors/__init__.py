"""Fitted motion priors as TOML, and how they are fitted."""
