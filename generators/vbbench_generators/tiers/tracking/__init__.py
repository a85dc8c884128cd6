"""The settings of tier `tracked`: errors of a simulated detector and a real tracker's, of a file in ``detectors/``."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated

from vbbench.camera import Camera
from vbbench.parsing.numbers import Checked, Share, Within, check_ranges
from vbbench.parsing.toml_text import read_bundled

Positive = Annotated[float, Within(1e-9, 1e9)]
Spread = Annotated[float, Within(0.0, 1e9)]
LogOdds = Annotated[float, Within(-1e3, 1e3)]


@dataclass(frozen=True, kw_only=True)
class DetectorModel(Checked):
    """Errors of a detector of people.

    The log-odds of a score are ``score_best`` − ``score_small``/l − ``score_hidden``·(1 − visible) + noise.

    Parameters
    ----------
    aspect : width of a box over its height l.
    score_best, score_small, score_hidden, score_std : see above; noise is normal, ``score_small`` in px.
    least_visible : least visible fraction of a person who can be detected.
    top_std, bottom_std, side_std : jitter of top, of bottom, and of left and right edges, in heights.
    edge_std : additional jitter of every edge, in px.
    score_memory, jitter_memory : correlation times in s of scores, and of jitter and ``pull``.
    pull, pull_std : mean and deviation of the share, 0 to 1, by which a hidden edge moves to that of the visible part.
    merge_overlap, merge_rate : two people whose boxes overlap by this IoU are merged into one box at this rate.
    suppress_overlap : IoU above which non-maximum suppression removes the detection of lower score.
    false_alarms, false_alarm_memory, false_alarm_score : mean number per frame, mean duration in s, and mean log-odds
        of the scores.
    """

    aspect: Positive
    score_best: LogOdds
    score_small: Spread
    score_hidden: Spread
    score_std: Positive
    least_visible: Share
    top_std: Spread
    bottom_std: Spread
    side_std: Spread
    edge_std: Spread
    score_memory: Positive
    jitter_memory: Positive
    pull: Share
    pull_std: Spread
    merge_overlap: Share
    merge_rate: Share
    suppress_overlap: Share
    false_alarms: Spread
    false_alarm_memory: Positive
    false_alarm_score: LogOdds

    @property
    def box_std(self) -> float:
        """Root mean square of the errors of column, top and bottom, as a share of the box's height."""
        return float(((0.5 * self.side_std**2 + self.top_std**2 + self.bottom_std**2) / 3.0) ** 0.5)


@dataclass(frozen=True, kw_only=True)
class TrackerSettings:
    """Settings of the tracker.

    Parameters
    ----------
    high, low : least scores of detections in the first and in the second association.
    birth : least score of a detection that begins a track.
    first_overlap, confirm_overlap : least overlap (intersection over union) times score in the first association, and
        of a new track with its second detection.
    second_overlap : least overlap in the second association.
    lost_time : time in s for which a track is kept without a detection.
    measurement : standard deviation of a detection's centre, width and height, in heights.
    wander, acceleration : process noise of these and of their speeds, in heights / s^½ and heights / s^1½.
    start_speed : standard deviation of a new track's speeds, in heights / s.
    turn_std : error in px of the compensation of the camera's rotation between frames.
    least_boxes : tracks with fewer boxes are dropped.
    """

    high: Share
    low: Share
    birth: Share
    first_overlap: Share
    second_overlap: Share
    confirm_overlap: Share
    lost_time: Positive
    measurement: Positive
    wander: Positive
    acceleration: Positive
    start_speed: Positive
    turn_std: Spread
    least_boxes: Annotated[int, Within(1, 10**6)]

    def __post_init__(self) -> None:
        check_ranges(self)
        if not self.low <= self.high <= self.birth:
            raise ValueError(f"low = {self.low}, high = {self.high} and birth = {self.birth} must not fall")


@dataclass(frozen=True, kw_only=True)
class TrackingSettings(Checked):
    """Detector, tracker, and the noise in px that solvers are given.

    Parameters
    ----------
    perspective_std : noise in a picture with borders, which cut off the feet of people who are near.
    panorama_std : noise in a panorama.
    detector, tracker : their settings.
    """

    perspective_std: Positive
    panorama_std: Positive
    detector: DetectorModel
    tracker: TrackerSettings

    def pixel_std(self, camera: Camera) -> float:
        """Standard deviation in px of column, top and bottom of tracked boxes."""
        return self.perspective_std if camera.period is None else self.panorama_std

    def lasting(self, frames: int | None) -> "TrackingSettings":
        """The settings with ``frames`` as `TrackerSettings.least_boxes`; unchanged if that is ``None``."""
        return self if frames is None else replace(self, tracker=replace(self.tracker, least_boxes=frames))


@cache
def get_tracking() -> TrackingSettings:
    """The settings that come with this package."""
    return read_bundled("vbbench_generators", "detectors/model.toml", TrackingSettings, "top level")
