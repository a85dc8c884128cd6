"""The split ``kitti``: recordings of KITTI's tracking benchmark as footage."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Card, Options
from vbbench_generators.footage.found_boxes import LEAST_SCORE
from vbbench_generators.footage.kitti.folder import WANTED, find_folder
from vbbench_generators.footage.kitti.labels import CYCLISTS, WALKERS
from vbbench_generators.footage.kitti.recording import read_recording
from vbbench_generators.footage.kitti.summary import summarise
from vbbench_generators.footage.runs import RunRules
from vbbench_generators.footage.sequences import FootageSequences
from vbbench_generators.footage.split import READ_BY_ALL, FootageSplit, Recordings
from vbbench_generators.footage.tracks import LEAST_OVERLAP

CARD = Card(
    name="kitti",
    title="KITTI tracking: a car among people, with boxes and places by hand",
    licence="CC BY-NC-SA 3.0: for research, not for commerce; nothing of it comes with vbbench. "
    f"Made from your own download: --source the folder with {WANTED}",
    citation="Geiger, Lenz, Urtasun: Are we ready for autonomous driving? The KITTI vision benchmark suite, CVPR 2012",
    sources=(),
    own_files=True,
    caution="poses have errors of their own, about as large as parked cars seem to move (see calibration), and finer "
    "scores mean nothing; heights told are of people who stand, and those who sit are about 1.2 m high",
)


@dataclass(frozen=True, kw_only=True)
class KittiSplit(FootageSplit):
    """See `FootageSplit`.

    Boxes are projections of labelled bodies, whose near edge is nearer than their middle: they are about 3 % higher
    than people's height says. Solvers are given that: heights of N(1.77, .09²) m, which is 1.03 × 1.72.
    """

    reads: ClassVar[frozenset[str]] = READ_BY_ALL | {"poses", "boxes", "person_class", "cyclists"}

    card: Card = CARD
    every: int = 4
    rules: RunRules = field(default_factory=lambda: RunRules(shortest=10))
    height_mean: float = 1.77
    classes: tuple[str, ...] = WALKERS
    found_pixel_std: float = 5.0

    def plan(self, options: Options) -> FootageSequences:
        """See `FootageSplit.plan`; solvers are given the larger noise of found boxes, rougher than labelled ones."""
        found = options.footage is not None and options.footage.boxes is not None
        split = replace(self, pixel_std=self.found_pixel_std) if found else self
        return FootageSplit.plan(split, options)

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
        )


kitti = KittiSplit()
