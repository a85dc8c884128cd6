"""Pictures of a sequence: the bird's-eye view beside what the camera saw. Nothing here touches pyplot."""

from vbbench.pictures.plotting.figure import plot_sequence, plot_to_file
from vbbench.pictures.plotting.posterior import plot_posterior, plot_posterior_to_file
from vbbench.pictures.plotting.saving import save_picture

__all__ = ["plot_posterior", "plot_posterior_to_file", "plot_sequence", "plot_to_file", "save_picture"]
