"""What is said of a dataset's truth and boxes: a text for ``vbbench info``, and the numbers for programs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from vbbench_generators.footage.kitti.recording import KittiRecording, Way
from vbbench_generators.footage.tracks import FoundTracks

SPOKEN = {"oxts": "oxts", "poses": "--poses"}
LONGEST = 900
"""Characters of the text; with more sequences, it says less of each."""


def summarise(recordings: Mapping[str, KittiRecording]) -> dict[str, Any]:
    """The figures of all recordings, with a ``summary`` in words."""
    values, words = {}, []
    for name, one in recordings.items():
        found = one.found
        values[name] = {**one.way.values(), **({} if found is None else {"boxes": _values(found)})}
        words.append(f"{name}: {_of_way(one.way)}" + ("" if found is None else f"; {_of_boxes(found)}"))
    text = ". ".join(words)
    return {"summary": text if len(text) <= LONGEST else _of_all(recordings), "sequences": values}


def _of_way(way: Way) -> str:
    others = [f"{cars.typical:.2f} m by {SPOKEN[name]}" for name, cars in way.parked.items() if name != way.source]
    cars = way.parked[way.source]
    if not len(cars.moved):
        return f"poses from {SPOKEN[way.source]}, no parked car to check them by"
    moved = f"{cars.typical:.2f} m ({_ends(cars.moved, '.2f')}) in {_ends(cars.driven, '.0f')} m of driving"
    text = f"poses from {SPOKEN[way.source]}: parked cars ({len(cars.moved)}) move {moved}"
    return ", ".join([text, *others])


def _of_boxes(found: FoundTracks) -> str:
    return (
        f"boxes found: {found.detected}; after tracking {found.tracked}, {len(found.tracks)} tracks, "
        f"{found.dropped} boxes of tracks of nobody removed"
    )


def _of_all(recordings: Mapping[str, KittiRecording]) -> str:
    checked = [one.way.parked[one.way.source].typical for one in recordings.values()]
    known = [value for value in checked if not np.isnan(value)]
    text = f"poses of {len(recordings)} sequences"
    if known:
        text += f"; in {len(known)} parked cars check them, and move {_ends(np.array(known), '.2f')} m"
    shares = [one.found.tracked.values() for one in recordings.values() if one.found is not None]
    for name in ("recall", "precision") if shares else ():
        text += f"; {name} of tracked boxes {_ends(np.array([share[name] for share in shares]), '.2f')}"
    return f"{text}; each in `vbbench info --json`"


def _ends(values: Any, form: str) -> str:
    least, most = format(values.min(), form), format(values.max(), form)
    return least if least == most else f"{least} to {most}"


def _values(found: FoundTracks) -> dict[str, Any]:
    return {"detected": found.detected.values(), "tracked": found.tracked.values(), "dropped": found.dropped}
