"""Recordings of a sequence for the rerun viewer: the world, the map, the ego view and errors, frame by frame.

Rerun (extra ``viewer``) is imported when a recording is made, not before.
"""

from vbbench.pictures.viewer.marks import Opened, how_to_open, open_viewer
from vbbench.pictures.viewer.recording import record_to_file

__all__ = ["Opened", "how_to_open", "open_viewer", "record_to_file"]
