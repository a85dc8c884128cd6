"""What solvers share: measurements on the ground, motion and its history, drift, cold starts, and facts about them.

Facts are what a bundled solver declares of itself, for its submissions and its rows on boards. ``tuned_on`` names the
recordings whose figures were looked at when numbers were chosen by hand, ``trained_on`` those that parameters were
fitted to. Boards mark and rank apart the rows that name a recording of theirs (`vbbench_leaderboards.results.boards`),
so the two name what was used and nothing else.
"""

from collections.abc import Mapping

_AUTHORS = "the authors of vbbench"
_KITTI = "KITTI 0015, 0017 and 0019"

UNTUNED: Mapping[str, str] = {"authors": _AUTHORS, "trained_on": "nothing", "tuned_on": "nothing"}

TUNED: Mapping[str, str] = {**UNTUNED, "tuned_on": "Hotel, ETH, Students"}

CASCADE: Mapping[str, str] = {**UNTUNED, "tuned_on": f"Hotel, ETH, Students; for cold starts also {_KITTI}"}

DEVELOPED: Mapping[str, str] = {
    **UNTUNED,
    "trained_on": "nothing",
    "tuned_on": f"Hotel, ETH, Students, {_KITTI}, JRDB, 2 logs of Argoverse 2, 4 scenes of nuScenes",
}

SIMULATED: Mapping[str, str] = {
    "authors": _AUTHORS,
    "trained_on": "simulated crowds of vbbench alone; no recording",
    "tuned_on": f"Hotel, ETH, {_KITTI}",
}
