"""Prints how many kernels `map-causal` loads or compiles when a session is made, and which ones while it is stepped.

The camera looks lower than the session is told, by as many px as the first argument says.

Run by `tests.test_session_protocol` in a process of its own.
"""

import json
import sys

import numpy as np

from tests.late_loading import loaded, watch_dispatchers
from tests.made_sequence import made_sequence
from vbbench import Session


def main() -> None:
    """Step through a crowd with gaps, with frames of few people and of nobody, and with odometry now and then."""
    watch_dispatchers()
    made = made_sequence(people=12, frames=60)
    session = Session("map-causal", made.camera, 0.4, pixel_std=1.0, people=16)
    before, higher = len(loaded), np.array([0.0, float(sys.argv[1]), 0.0])
    for frame, boxes in enumerate(made.sequence.observations - higher):
        shown = [
            column for column in np.flatnonzero(made.sequence.observed[frame]) if column % (1 + frame // 8 % 6) == 0
        ]
        odometry = (np.array([0.1, 0.0, 0.0]), 1e-4 * np.eye(3)) if frame > 20 and frame % 5 else None
        session.step_observations({int(column) + frame // 15 * 12: boxes[column] for column in shown}, odometry)
        if frame % 9 == 0:
            session.step_observations({}, odometry)
    sys.stdout.write(json.dumps([before, loaded[before:]]))


if __name__ == "__main__":
    main()
