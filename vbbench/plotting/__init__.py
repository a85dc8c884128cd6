"""Pictures of a sequence: the bird's-eye view beside what the camera saw. Nothing here touches pyplot."""

from vbbench.plotting.figure import plot_sequence, plot_to_file, save_png

__all__ = ["plot_sequence", "plot_to_file", "save_png"]
