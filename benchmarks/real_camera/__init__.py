"""How solvers do on a real camera and beside it, against the figures that are wanted; see ``__main__``."""
