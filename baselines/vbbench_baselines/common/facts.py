"""What the bundled solvers say of themselves, for their submissions and their rows on boards.

``tuned_on`` names what was looked at when numbers were chosen by hand: on the boards of those splits a row flatters its
solver.
"""

from collections.abc import Mapping

_AUTHORS = "the authors of vbbench"

UNTUNED: Mapping[str, str] = {"authors": _AUTHORS, "trained_on": "nothing", "tuned_on": "nothing"}

TUNED: Mapping[str, str] = {**UNTUNED, "tuned_on": "Hotel, ETH, Students"}

FITTED: Mapping[str, str] = {**TUNED, "trained_on": "Hotel and ETH; on their own boards a variant that never saw them"}

SIMULATED: Mapping[str, str] = {
    "authors": _AUTHORS,
    "trained_on": "simulated crowds of vbbench alone; no recording",
    "tuned_on": "Hotel, ETH, KITTI",
}
