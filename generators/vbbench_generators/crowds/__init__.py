"""Simulated crowds: scenarios, the social force that walks them, and the splits made of them."""
