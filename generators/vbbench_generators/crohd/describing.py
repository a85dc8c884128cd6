"""What a dataset says of the camera that recorded its people."""

import math
from typing import Any

from vbbench_generators.lifting import Calibration, Estimate

_METHODS = {
    "motion": "self-calibrated from head sizes and from how people walk",
    "prior": "self-calibrated from head sizes, the lens by its prior",
    "vanishing-point": "self-calibrated from head sizes and a vertical vanishing point",
    "homography": "by the user's homography",
}


def describe_calibration(calibration: Calibration) -> dict[str, Any]:
    """The calibration for ``dataset.json``, and a line for people, its ``summary``."""
    c = calibration
    degrees = math.degrees(1.0)
    parts = [
        f"camera height {_interval(c.camera_height, ' m', 2)}",
        f"tilt {_interval(c.tilt, '°', 1, degrees)}",
        f"horizon at row {_interval(c.horizon, ' px', 0)}",
        f"focal length {_interval(c.focal, ' px', 0)}",
        f"smoothing took off {c.smoothing_residual_m:.3f} m",
    ]
    kind = "pseudo-metric, " if c.pseudo_metric else ""
    return {"summary": f"{kind}{_METHODS[c.method]}: {'; '.join(parts)}", **c.to_dict()}


def _interval(estimate: Estimate, unit: str, digits: int, factor: float = 1.0) -> str:
    """A figure with its 95 % interval, where it has one."""
    value, low, high = (f"{factor * x:.{digits}f}" for x in (estimate.value, estimate.low, estimate.high))
    return f"{value}{unit}" + ("" if estimate.low == estimate.high else f" ({low} to {high})")
