"""The site of the boards: pages from templates, tables for papers, and the player of sequences."""
