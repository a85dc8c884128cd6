"""The datasets of the families, made once in a folder."""

from dataclasses import dataclass
from pathlib import Path

from benchmarks.families.robot import Drive, write
from vbbench.errors import SourceMissingError
from vbbench.files.dataset import Dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Observer, Options
from vbbench.registry import load
from vbbench.reproduction.grid import Making
from vbbench_generators.footage.kitti.split import KittiSplit

STRIDES = {"hotel": 24, "eth-15fps": 24, "students-resampled": 64}
"""Of the sequences of a recording, every how many-th is taken; a quarter of it in tier `field`, which has fewer."""
CROWDS = 12
"""Simulated crowds."""
KITTI = ("0015", "0017", "0019")
WALKS = {
    "mot17-05": ("mot17/MOT17-05.txt", "width = 640\nheight = 480\nfocal = 500\nmount_height = 1.0\nfps = 14\n"),
    "bahnhof": ("eth_mobile/bahnhof/boxes.csv", ""),
}
"""Boxes of platforms that somebody pushes along a street, and their camera where no file describes it."""


@dataclass(frozen=True, kw_only=True)
class Places:
    """Makes datasets and keeps them.

    Parameters
    ----------
    data : folder of the recordings; ``None`` where there are none.
    cache : folder for the datasets.
    jobs : processes.
    smoke : whether everything is as small as can be.
    """

    data: Path | None
    cache: Path
    jobs: int = 1
    smoke: bool = False

    def board(self, split: str, tier: str) -> Dataset:
        """Some sequences of a split; in tier `field` a vehicle watches, as on the boards."""
        observer: Observer = "vehicle" if tier == "field" else "walker"
        stride = STRIDES.get(split)
        if stride is not None and tier == "field":
            stride //= 4 if split != "students-resampled" else 8
        limit = None if stride else 2 if self.smoke else CROWDS
        source = None if split == "sim" else self.data
        options = Options(tier=tier, observer=observer, stride=stride, limit=limit, source=source)
        return self._making.dataset(split, self.cache / f"{split}-{tier}{'-smoke' * self.smoke}", options)

    def kitti(self, every: int, *, found: bool) -> Dataset:
        """The recordings of KITTI, labels or a detector's boxes."""
        folder = self.folder("kitti")
        boxes = folder / "detections" if found else None
        asked = FootageOptions(sequences=KITTI, every=every, poses=folder / "poses", boxes=boxes)
        plan = KittiSplit(classes=("Pedestrian",)).plan(Options(source=folder, footage=asked))
        return self._making.planned(plan, self.cache / f"kitti-{every}{'-found' * found}")

    def own(self, name: str, folder: Path, every: int | None = None) -> Dataset:
        """Recordings in the form of split ``own``."""
        plan = load("generator", "own").plan(Options(source=folder, footage=FootageOptions(every=every)))
        return self._making.planned(plan, self.cache / name)

    def jrdb(self) -> Dataset:
        """A tracker's boxes around a robot, with places by lidar."""
        options = Options(source=self.folder("jrdb_tracks"))
        return self._making.dataset("jrdb", self.cache / "jrdb", options)

    def robot(self, drive: Drive, seeds: int) -> Dataset:
        """Drives of the robot simulator, with odometry."""
        name = f"robot-{drive.people}-{drive.rate:g}Hz-{drive.seconds:g}s"
        folder = self.cache / "drives" / name
        for seed in range(seeds):
            if not (folder / f"drive{seed}" / "odometry.txt").is_file():  # the last that is written
                write(folder / f"drive{seed}", drive, seed)
        return self.own(name, folder)

    def walk(self, name: str) -> Dataset:
        """Boxes of a platform that is pushed along a street; where it was is not known."""
        (file, camera), folder = WALKS[name], self.cache / "walks" / name
        source = self.folder(file)
        folder.mkdir(parents=True, exist_ok=True)
        written = camera or source.with_name("camera.toml").read_text("utf-8")
        (folder / "camera.toml").write_text(written, encoding="utf-8")
        (folder / ("boxes.csv" if source.suffix == ".csv" else "gt.txt")).write_bytes(source.read_bytes())
        return self.own(name, folder)

    def folder(self, name: str) -> Path:
        """A file or folder of the recordings; SourceMissingError if it is not there."""
        if self.data is None or not (self.data / name).exists():
            raise SourceMissingError(f"{name} is not in {self.data or 'a folder of recordings (--data)'}")
        return self.data / name

    @property
    def _making(self) -> Making:
        return Making(jobs=self.jobs)
