"""Boxes to and from MOTChallenge text: a dataset's out, and any tracker's in."""

from vbbench.mot.export import export_mot
from vbbench.mot.file import MotRows, read_mot, write_mot
from vbbench.mot.importing import import_mot

__all__ = ["MotRows", "export_mot", "import_mot", "read_mot", "write_mot"]
