"""Lifting of heads in a surveillance picture to the ground plane: self-calibration, or a homography, and smoothing."""

from vbbench_generators.lifting.calibration import Calibration, Estimate
from vbbench_generators.lifting.lift import Lifted, lift
from vbbench_generators.lifting.settings import LiftingSettings

__all__ = ["Calibration", "Estimate", "Lifted", "LiftingSettings", "lift"]
