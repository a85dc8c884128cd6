"""The published facts about a dataset: ``dataset.json``."""

import hashlib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

from vbbench.camera import Camera, camera_from_dict, camera_to_dict
from vbbench.errors import FileError, VbbenchError, quoted
from vbbench.files.dataset_checks import Known, find_fault
from vbbench.files.generate_command import generate_command
from vbbench.files.tables import file_sha256
from vbbench.folders.work_folder import WorkFolder, finish_swaps
from vbbench.paper import the_paper
from vbbench.parsing.json_text import canonical_digest, read_object
from vbbench.solver import Carrier

FORMAT_VERSION = 2
"""Since 2 every sequence has its own world (``truth/frames``), and tracks are not numbered like people."""
INFO_FILE = "dataset.json"


def _digests(facts: Any) -> Iterator[str]:
    """Every SHA-256 in lists and tables of files."""
    if isinstance(facts, str) and re.fullmatch("[0-9a-f]{64}", facts):
        yield facts
    elif isinstance(facts, Mapping | list | tuple):
        for value in facts.values() if isinstance(facts, Mapping) else facts:
            yield from _digests(value)


@dataclass(frozen=True, kw_only=True)
class Pictures:
    """Paths of the pictures of a sequence: ``pattern`` with the number ``first + t·step`` for frame t.

    Parameters
    ----------
    pattern : a path in the form of `str.format`, such as ``/data/image_02/0019/{:06d}.png``.
    first, step : number of frame 0's picture, and difference from a frame to the next.
    """

    pattern: str
    first: int
    step: int

    def path(self, frame: int) -> Path:
        """The picture of a frame; it may be missing."""
        return Path(self.pattern.format(self.first + frame * self.step))


@dataclass(frozen=True, kw_only=True)
class DatasetInfo:
    """Everything published about a dataset.

    ``definition`` determines the content (generator, recipe and hashes of sources). The id is a hash of it and of the
    parameters: the same command gives the same id on every machine. ``seed`` is ``None`` if it is withheld with the
    truth; ``withheld_id`` is then the id, which cannot be computed without the seed.

    ``calibration`` describes the camera that recorded the scenes, with its uncertainty, if metres depend on it; it
    follows from the definition, up to rounding, and is not part of the id.

    Solvers are given ``pixel_std``, ``box_std``, ``tilt_std`` and ``mount_height_std``, the errors of boxes and camera
    (`vbbench.solver.Problem`), and ``carried_by`` and ``box_edge`` if the owner of a recording states them.

    Footage may have several ``cameras`` (``camera`` is the first), ``pictures`` of sequences, and partial ``truth``.
    """

    split: str
    title: str
    camera: Camera
    tier: str
    seed: int | None
    dt: float
    height_mean: float
    height_std: float
    pixel_std: float
    scenes: tuple[str, ...]
    definition: dict[str, Any]
    box_std: float = 0.0
    tilt_std: float = 0.0
    mount_height_std: float = 0.0
    carried_by: Carrier = "unknown"
    box_edge: float | None = None
    caution: str | None = None
    calibration: dict[str, Any] | None = None
    cameras: tuple[Camera, ...] = ()
    truth: Known = "whole"
    pictures: tuple[Pictures | None, ...] = ()
    counts: dict[str, float] = field(default_factory=dict)
    tables: dict[str, dict[str, Any]] = field(default_factory=dict)
    package_version: str = ""
    format_version: int = FORMAT_VERSION
    withheld_id: str | None = None

    @property
    def id(self) -> str:
        """Hash that a submission names: 16 hex digits of SHA-256 over the definition and all parameters."""
        if self.withheld_id is not None:
            return self.withheld_id
        facts = {name: value for name, value in self._json().items() if name not in _NOT_IN_ID}
        return hashlib.sha256(json.dumps(facts, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def known_seed(self) -> int:
        """The seed; raises VbbenchError if it is withheld."""
        if self.seed is None:
            raise VbbenchError(f"the seed of dataset {self.id} is withheld with its truth")
        return self.seed

    @property
    def spoken_seed(self) -> str:
        """The seed as text; or that it is withheld."""
        return "withheld" if self.seed is None else str(self.seed)

    @property
    def sources(self) -> frozenset[str]:
        """SHA-256 of every file that the dataset was made from; none where it was simulated."""
        return frozenset(_digests(self.definition.get("files")))

    @property
    def truth_tables(self) -> dict[str, dict[str, Any]]:
        """Size, rows and SHA-256 of each truth table, by file name."""
        tables = {Path(name): facts for name, facts in sorted(self.tables.items())}
        return {f"{name.name}.parquet": facts for name, facts in tables.items() if name.parent.name == "truth"}

    @property
    def truth_sha256(self) -> str:
        """One hash of all truth tables; see `vbbench.files.dataset_info.truth_sha256`."""
        return truth_sha256({name: facts["sha256"] for name, facts in self.tables.items()})

    def to_json(self) -> str:
        """The text of ``dataset.json``, with a digest of its values; raises ValueError if a number is not finite."""
        values = {"id": self.id, **self._json()}
        return json.dumps({**values, "digest": canonical_digest(values)}, indent=2, ensure_ascii=False) + "\n"

    def _json(self) -> dict[str, Any]:
        facts = {**asdict(self), "camera": camera_to_dict(self.camera), "scenes": list(self.scenes)}
        del facts["withheld_id"]
        facts["cameras"] = [camera_to_dict(camera) for camera in self.cameras]
        facts["pictures"] = [pictures and asdict(pictures) for pictures in self.pictures]
        unsaid: dict[str, Any] = {"calibration": None, "cameras": [], "pictures": [], "truth": "whole"}
        unsaid |= dict.fromkeys(("box_std", "tilt_std", "mount_height_std"), 0.0)
        unsaid |= {"carried_by": "unknown", "box_edge": None}
        return {name: value for name, value in facts.items() if name not in unsaid or value != unsaid[name]}

    @staticmethod
    def read(folder: Path) -> "DatasetInfo":
        """Read ``dataset.json`` of a dataset folder.

        Raises FileError if it is missing, damaged, of another format version, or edited by hand; the key is named.
        """
        finish_swaps(folder)
        path = folder / INFO_FILE
        if not path.is_file():
            if (folder / "submission.json").is_file():
                raise FileError(folder, "no dataset here, but a submission; name the folder of its dataset")
            raise FileError(path, "no dataset here; make one with 'vbbench generate SPLIT --out DIR'")
        values = _checked(path)
        digest, written_id = values.pop("digest", None), values["id"]
        fresh = canonical_digest(values)
        del values["id"]
        try:
            values["camera"] = camera_from_dict(values["camera"])
            values["cameras"] = tuple(map(camera_from_dict, values.get("cameras", ())))
        except VbbenchError as error:
            raise FileError(path, f"key 'camera': {error}; generate the dataset again") from error
        values["pictures"] = tuple(entry and Pictures(**entry) for entry in values.get("pictures", ()))
        withheld = written_id if values["seed"] is None else None
        info = DatasetInfo(**{**values, "scenes": tuple(values["scenes"]), "withheld_id": withheld})
        if info.id != written_id:
            raise FileError(path, f"its parameters do not belong to its id {written_id}; generate the dataset again")
        if digest not in (None, fresh):
            raise FileError(path, "was changed by hand: its digest is of something else; generate the dataset again")
        return info


def _checked(path: Path) -> dict[str, Any]:
    """The values in a ``dataset.json``, every key checked."""
    values = read_object(path, "generate the dataset again")
    version = values.get("format_version")
    if version != FORMAT_VERSION:
        problem = f"format version {quoted(version)}, this vbbench reads {FORMAT_VERSION}"
        raise FileError(
            path, f"{problem}; make it again with '{generate_command(values, str(path.parent))} --overwrite'"
        )
    fault = find_fault(values)
    if fault is not None:
        raise FileError(path, f"{fault}; generate the dataset again")
    return values


def truth_sha256(tables: Mapping[str, str]) -> str:
    """SHA-256 of the output of ``sha256sum *.parquet`` for the truth tables among ``tables`` (name → SHA-256)."""
    truth = {Path(name).name: digest for name, digest in sorted(tables.items()) if name.startswith("truth/")}
    lines = "".join(f"{digest}  {name}.parquet\n" for name, digest in truth.items())
    return hashlib.sha256(lines.encode()).hexdigest()


_NOT_IN_ID = ("counts", "tables", "package_version", "title", "caution", "calibration", "pictures")


def summary(info: DatasetInfo) -> dict[str, Any]:
    """The row of the paper's Table 1, and the identity of the dataset.

    Only frames with observed people count. A recipe states whether the people of Table 1 include the observer.
    """
    counts, extra = info.counts, int(info.definition.get("count_observer", False))
    return {
        "split": info.split,
        "camera": info.camera.kind,
        "tier": info.tier,
        "sequences": counts["sequences"],
        "mean_frames": counts["frames"] / counts["sequences"],
        "people_min": counts["people_min"] + extra,
        "people_mean": counts["observations"] / max(counts["frames"], 1) + extra,
        "people_max": counts["people_max"] + extra,
        "observations": counts["observations"],
        "id": info.id,
    }


def summary_json(info: DatasetInfo) -> str:
    """The summary as JSON, with caution, calibration, the paper's row and the hash of withheld truth if they exist."""
    paper = the_paper().table1.get(info.split)
    extras = {
        "caution": info.caution,
        "calibration": info.calibration,
        "paper": None if paper is None else asdict(paper),
        "truth_sha256": info.truth_sha256 if info.seed is None else None,
    }
    known = {name: value for name, value in extras.items() if value is not None}
    return json.dumps({**summary(info), **known}, indent=2, ensure_ascii=False)


def describe(info: DatasetInfo) -> str:
    """The summary and parameters as text."""
    s = summary(info)
    included = "observer included" if info.definition.get("count_observer") else "besides the observer"
    lines = [
        f"{info.split}: {info.title}",
        f"  {s['sequences']} sequences, mean {s['mean_frames']:.2f} frames, people ({included}) "
        f"{s['people_min']} / {s['people_mean']:.2f} / {s['people_max']} (min / mean / max)",
        f"  {s['observations']} observations; camera {s['camera']}, tier {s['tier']} ({given_noise(info)}), "
        f"dt {info.dt:g} s",
        f"  heights N({info.height_mean:.2f}, {info.height_std:g}²) m, seed {info.spoken_seed}, id {s['id']}",
    ]
    paper = the_paper().table1.get(info.split)
    if paper is not None:
        row = f"  the paper: {paper.sequences} sequences, mean {paper.frames} frames, people {paper.people}"
        lines.insert(2, row)
    if info.calibration is not None:
        lines.append(f"  calibration: {info.calibration['summary']}")
    if info.seed is None:
        lines.append(f"  truth withheld, SHA-256 {info.truth_sha256}")
    if info.caution is not None:
        lines.append(f"  caution: {info.caution}")
    return "\n".join(lines)


def given_noise(info: DatasetInfo) -> str:
    """The errors that solvers are given, of boxes and camera, as text."""
    parts = [
        (True, f"{info.pixel_std:g} px"),
        (info.box_std, f"{info.box_std:.2%} of a box"),
        (info.tilt_std, f"tilt ± {info.tilt_std:.3g} rad"),
        (info.mount_height_std, f"mount ± {info.mount_height_std:g} m"),
        (info.box_edge is not None, f"near edge {info.box_edge} m"),
        (info.carried_by != "unknown", f"carried by a {info.carried_by}"),
    ]
    return ", ".join(text for said, text in parts if said)


def table_paths(names: Iterable[str], work: WorkFolder, withhold_truth: bool) -> dict[str, Path]:
    """Paths to write the tables of a dataset to; those of withheld truth are in another folder."""
    apart = {name for name in names if withhold_truth and name.startswith("truth/")}
    folders = {name: work.new_truth if name in apart else work.new for name in names}
    return {name: folder / f"{Path(name).name if name in apart else name}.parquet" for name, folder in folders.items()}


def describe_tables(paths: dict[str, Path]) -> dict[str, dict[str, Any]]:
    """Size and SHA-256 of every table of a dataset, by name."""
    return {
        name: {"bytes": path.stat().st_size, "rows": pq.read_metadata(path).num_rows, "sha256": file_sha256(path)}
        for name, path in sorted(paths.items())
    }
