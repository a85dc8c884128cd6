"""Pictures of a sequence: the bird's-eye view next to what the camera saw. Nothing here touches pyplot."""

from vbbench.pictures.plotting.figure import plot_sequence, plot_to_file
from vbbench.pictures.plotting.style import save_picture

__all__ = ["plot_sequence", "plot_to_file", "save_picture"]
