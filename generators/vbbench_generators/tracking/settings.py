"""A file in ``detectors/`` as frozen dataclasses: how a detector errs, and how a tracker links what it finds."""

from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any

from vbbench.camera import Camera, PanoramaCamera
from vbbench_generators.strict import build, read_toml


@dataclass(frozen=True, kw_only=True)
class DetectorModel:
    """How a detector of people errs.

    The log-odds of a score are ``score_best`` − ``score_small``/l − ``score_hidden``·(1 − visible) + noise.

    Parameters
    ----------
    aspect : width of a box over its height l.
    score_best, score_small, score_hidden, score_std : see above; noise is normal, ``score_small`` in px.
    least_visible : who shows less than this share is never detected.
    top_std, side_std : jitter of top and bottom, and of left and right edges, in heights.
    edge_std : jitter of every edge besides, in px.
    memory : correlation time in s of scores and jitter.
    pull, pull_std : how much of the way a hidden edge is drawn to the edge of what shows, normal, cut to 0 … 1.
    merge_overlap, merge_rate : of two people whose boxes overlap so much, so many detections are one box about both.
    suppress_overlap : of two detections that overlap so much only the one of higher score is kept.
    false_alarms, false_alarm_memory, false_alarm_score : how many stand in a frame on average, for how many s, and
        the mean log-odds of their scores.
    """

    aspect: float
    score_best: float
    score_small: float
    score_hidden: float
    score_std: float
    least_visible: float
    top_std: float
    side_std: float
    edge_std: float
    memory: float
    pull: float
    pull_std: float
    merge_overlap: float
    merge_rate: float
    suppress_overlap: float
    false_alarms: float
    false_alarm_memory: float
    false_alarm_score: float

    def __post_init__(self) -> None:
        _require_positive(self, "aspect", "score_std", "memory", "false_alarm_memory")
        shares = ("least_visible", "pull", "merge_overlap", "merge_rate", "suppress_overlap")
        _require_shares(self, *shares)
        spreads = ("score_small", "score_hidden", "top_std", "side_std", "edge_std", "pull_std", "false_alarms")
        if bad := [name for name in spreads if getattr(self, name) < 0.0]:
            raise ValueError(f"{bad[0]} must be 0 or more, not {getattr(self, bad[0])}")


@dataclass(frozen=True, kw_only=True)
class TrackerSettings:
    """How detections are linked.

    Parameters
    ----------
    high, low : scores that take part in the first association, and those that do in the second.
    birth : least score of a detection that begins a track.
    first_overlap, confirm_overlap : least overlap (intersection over union) times score in the first association, and
        of a new track with its second detection.
    second_overlap : least overlap in the second association.
    lost_time : s that a track is kept without a detection.
    measurement : standard deviation of a detection's centre, width and height, in heights.
    wander, acceleration : random steps of these four and of their speeds, in heights / s^½ and heights / s^1½.
    start_speed : standard deviation of a new track's speeds, in heights / s.
    least_boxes : tracks with fewer boxes are dropped.
    """

    high: float
    low: float
    birth: float
    first_overlap: float
    second_overlap: float
    confirm_overlap: float
    lost_time: float
    measurement: float
    wander: float
    acceleration: float
    start_speed: float
    least_boxes: int

    def __post_init__(self) -> None:
        _require_shares(self, "high", "low", "birth", "first_overlap", "second_overlap", "confirm_overlap")
        _require_positive(self, "lost_time", "measurement", "wander", "acceleration", "start_speed", "least_boxes")
        if not self.low <= self.high <= self.birth:
            raise ValueError(f"low = {self.low}, high = {self.high} and birth = {self.birth} must not fall")


@dataclass(frozen=True, kw_only=True)
class TrackingSettings:
    """Detector, tracker, and what solvers are told of their noise in px, by kind of camera."""

    perspective_std: float
    panorama_std: float
    detector: DetectorModel
    tracker: TrackerSettings

    def __post_init__(self) -> None:
        _require_positive(self, "perspective_std", "panorama_std")

    def pixel_std(self, camera: Camera) -> float:
        """Standard deviation in px of column, top and bottom of tracked boxes."""
        return self.panorama_std if isinstance(camera, PanoramaCamera) else self.perspective_std


def get_tracking(name: str = "model") -> TrackingSettings:
    """The settings in the file of that name."""
    with as_file(files("vbbench_generators") / "detectors" / f"{name}.toml") as path:
        return read_tracking(path)


def read_tracking(path: Path) -> TrackingSettings:
    """Read a settings file.

    Raises
    ------
    FileError
        If it is missing, no TOML, or a key is unknown, missing or cannot be.
    """

    def made(table: dict[str, Any]) -> TrackingSettings:
        kinds: dict[str, type[Any]] = {"detector": DetectorModel, "tracker": TrackerSettings}
        parts = {name: build(kind, table.pop(name, {}), path, f"[{name}]") for name, kind in kinds.items()}
        return build(TrackingSettings, {**table, **parts}, path, "top level")

    return read_toml(path, made)


def _require_positive(settings: object, *names: str) -> None:
    if bad := [name for name in names if not getattr(settings, name) > 0.0]:
        raise ValueError(f"{bad[0]} must be above 0, not {getattr(settings, bad[0])}")


def _require_shares(settings: object, *names: str) -> None:
    if bad := [name for name in names if not 0.0 <= getattr(settings, name) <= 1.0]:
        raise ValueError(f"{bad[0]} must be 0 to 1, not {getattr(settings, bad[0])}")
