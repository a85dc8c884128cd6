"""The split ``kitti``: recordings of KITTI's tracking benchmark as footage."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Card, Options, bundled_card
from vbbench_generators.footage.kitti.labels import CYCLISTS, WALKERS
from vbbench_generators.footage.kitti.recording import KittiRecording, Way, find_folder, read_recording
from vbbench_generators.footage.sequences import RunRules
from vbbench_generators.footage.split import READ_BY_ALL, FootageSplit, Recordings
from vbbench_generators.footage.tracks import FOUND_PIXEL_STD, LEAST_OVERLAP, LEAST_SCORE, FoundTracks

SPOKEN = {"oxts": "oxts", "poses": "your files"}
LONGEST = 900
"""Characters of the text; with more sequences, it says less of each."""


def summarise(recordings: Mapping[str, KittiRecording]) -> dict[str, Any]:
    """The figures of all recordings, with a ``summary`` in words."""
    values, words = {}, []
    for name, one in recordings.items():
        found = one.found
        values[name] = {
            **one.way.values(),
            **({} if found is None else {"boxes": {**found.agreements, "dropped": found.dropped}}),
        }
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


CARD = bundled_card("vbbench_generators", "kitti")


@dataclass(frozen=True, kw_only=True)
class KittiSplit(FootageSplit):
    """See `FootageSplit`.

    Boxes are projections of labelled cuboids, whose near edge makes them about 3 % higher than a person's axis would
    be. Solvers are given this as heights of N(1.77, .09²) m, which is 1.03 × 1.72.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL | {"poses", "boxes", "person_class", "cyclists"}

    card: Card = CARD
    every: int = 4
    rules: RunRules = field(default_factory=lambda: RunRules(shortest=10))
    height_mean: float = 1.77
    classes: tuple[str, ...] = WALKERS

    def recordings(self, options: Options) -> Recordings:
        """See `FootageSplit.recordings`."""
        asked = options.footage or FootageOptions()
        folder = find_folder(options.source)
        names = folder.chosen(asked.sequences)
        classes = (*self.classes, *(CYCLISTS if asked.cyclists else ()))
        read = {name: read_recording(folder, name, asked, classes, several=len(names) > 1) for name in names}
        matching = {"least_score": LEAST_SCORE, "least_overlap": LEAST_OVERLAP} if asked.boxes else {}
        return Recordings(
            footage=tuple(one.footage for one in read.values()),
            definition={
                "files": [file for one in read.values() for file in one.sums],
                "classes": list(classes),
                "poses": {name: one.way.source for name, one in read.items()},
                **matching,
                **asked.classes,
            },
            calibration=summarise(read),
            pixel_std=None if asked.boxes is None else FOUND_PIXEL_STD,
        )


kitti = KittiSplit()
