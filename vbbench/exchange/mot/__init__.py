"""Boxes to and from MOTChallenge text: a dataset's out, and any tracker's in."""

from vbbench.exchange.box_rows import BoxRows
from vbbench.exchange.mot.export import export_mot
from vbbench.exchange.mot.importing import import_mot
from vbbench.exchange.mot.text import read_mot, write_mot

__all__ = ["BoxRows", "export_mot", "import_mot", "read_mot", "write_mot"]
