"""Recordings of a sequence for the rerun viewer: the world, the map, the ego view and errors, frame by frame.

Rerun (extra ``viewer``) is imported when a recording is made, not before.
"""

from vbbench.pictures.viewer.recording import record_to_file
from vbbench.pictures.viewer.rerun_sdk import Opened, how_to_open, open_viewer

__all__ = ["Opened", "how_to_open", "open_viewer", "record_to_file"]
