"""Simulated crowds: scenarios, and the splits made of them."""
