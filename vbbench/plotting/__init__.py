"""Pictures of a sequence: the bird's-eye view beside what the camera saw. Nothing here touches pyplot."""

from vbbench.plotting.figure import plot_sequence, save_png
from vbbench.plotting.submitted import plot_to_file, read_estimate

__all__ = ["plot_sequence", "plot_to_file", "read_estimate", "save_png"]
