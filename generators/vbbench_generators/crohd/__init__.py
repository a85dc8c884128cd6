"""Recordings of people's heads by a surveillance camera, in the layout of CroHD (MOTChallenge Head Tracking 21)."""

from vbbench_generators.lifting.heads import HeadBoxes

__all__ = ["HeadBoxes"]
