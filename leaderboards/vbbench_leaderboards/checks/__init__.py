"""Whether committed results still hold: counted again, scored again, made again from the start."""
