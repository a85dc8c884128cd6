"""The file ``field.toml`` as frozen dataclasses: what a real camera and real boxes are like."""

from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated

from vbbench.camera import Camera, PerspectiveCamera
from vbbench.generation.tier import Heights
from vbbench.parsing.numbers import Share, Within, check_ranges
from vbbench.parsing.toml_text import read_bundled
from vbbench_generators.tiers.tracking.settings import DetectorModel, TrackingSettings, get_tracking

Seconds = Annotated[float, Within(1e-3, 1e4, "s")]
Angle = Annotated[float, Within(0.0, 0.5, "rad")]
Metres = Annotated[float, Within(0.0, 10.0, "m")]


class _Checked:
    def __post_init__(self) -> None:
        check_ranges(self)


@dataclass(frozen=True, kw_only=True)
class TiltModel(_Checked):
    """How the camera is tilted, unknown to solvers.

    Parameters
    ----------
    pitch_std, roll_std : standard deviations in rad of what stays the same throughout a sequence.
    sway_pitch_std, sway_roll_std : of what changes, with the correlation time ``sway_time`` in s.
    """

    pitch_std: Angle
    roll_std: Angle
    sway_pitch_std: Angle
    sway_roll_std: Angle
    sway_time: Seconds


@dataclass(frozen=True, kw_only=True)
class MountModel(_Checked):
    """How high the camera is.

    Parameters
    ----------
    std : standard deviation in m about the height that solvers are given, constant throughout a sequence.
    bob : m by which a walker carries it up and down, at ``bob_pace`` in m/s and faster; in proportion below.
    step_rate : steps a second.
    """

    std: Metres
    bob: Metres
    bob_pace: Annotated[float, Within(0.01, 10.0, "m/s")]
    step_rate: Annotated[float, Within(0.1, 10.0, "Hz")]


@dataclass(frozen=True, kw_only=True)
class GroundModel(_Checked):
    """How uneven the ground is: ``waves`` waves ``shortest`` to ``longest`` m long, of ``std`` m in all."""

    std: Metres
    shortest: Annotated[float, Within(0.1, 1e4, "m")]
    longest: Annotated[float, Within(0.1, 1e4, "m")]
    waves: Annotated[int, Within(1, 1000)]


@dataclass(frozen=True, kw_only=True)
class BodyModel(_Checked):
    """What of a body its box is about.

    Parameters
    ----------
    nearest_edge, farthest_edge : m by which the edge that decides a box is nearer than the body's middle, least and
        most; a sequence has one length.
    aspect : width of a box over its height.
    """

    nearest_edge: Metres
    farthest_edge: Metres
    aspect: Annotated[float, Within(0.05, 5.0)]


@dataclass(frozen=True, kw_only=True)
class AnnotatorModel(_Checked):
    """How boxes that people draw are off, as shares of the box's height.

    Parameters
    ----------
    bottom_person_std, column_person_std : of the lower edge and the centre column; the same for all boxes of a person.
    bottom_std, column_std : of what changes, with the correlation times ``bottom_time`` and ``column_time`` in s.
    top_std : of the upper edge, from frame to frame.
    least_visible : who shows less than this share of what is inside the picture has no box.
    least_inside : nor has who shows less than this share of the box inside the picture.
    pixel_std : what solvers are given, in px at the focal length of the recipe's camera.
    """

    bottom_person_std: Share
    bottom_std: Share
    bottom_time: Seconds
    top_std: Share
    column_person_std: Share
    column_std: Share
    column_time: Seconds
    least_visible: Share
    least_inside: Share
    pixel_std: Annotated[float, Within(0.0, 100.0, "px")]

    @property
    def box_std(self) -> float:
        """Root mean square of the errors of column, top and bottom, as a share of the box's height."""
        column = self.column_person_std**2 + self.column_std**2
        bottom = self.bottom_person_std**2 + self.bottom_std**2
        return float(((column + bottom + self.top_std**2) / 3.0) ** 0.5)


@dataclass(frozen=True, kw_only=True)
class DetectorNoise(_Checked):
    """The noise of found boxes that solvers are given, in px, in pictures with borders and in panoramas."""

    perspective_std: Annotated[float, Within(0.0, 100.0, "px")]
    panorama_std: Annotated[float, Within(0.0, 100.0, "px")]


@dataclass(frozen=True, kw_only=True)
class FieldRecipe:
    """Everything that the tier is made by; one table of the file each."""

    camera: PerspectiveCamera
    tilt: TiltModel
    mount: MountModel
    ground: GroundModel
    body: BodyModel
    heights: Heights
    annotator: AnnotatorModel
    detector: DetectorModel
    told_of_detector: DetectorNoise

    def pixel_std(self, camera: Camera, detects: bool) -> float:
        """What solvers are given of boxes that were found, or drawn, on the pictures of a camera, in px."""
        if detects:
            return self.tracking(camera).pixel_std(camera)
        return self.annotator.pixel_std * camera.focal / self.camera.focal

    def tracking(self, camera: Camera) -> TrackingSettings:
        """The detector on the pictures of a camera, and the tracker of the tier `tracked` behind it.

        A lidar sees people by their distance, so that heights in px at which it misses them grow with the focal length.
        """
        small = self.detector.score_small * camera.focal / self.camera.focal
        told = vars(self.told_of_detector)
        return replace(get_tracking(), detector=replace(self.detector, score_small=small), **told)


@cache
def get_field() -> FieldRecipe:
    """The recipe that comes with this package."""
    return read_bundled("vbbench_generators", "tiers/field/field.toml", FieldRecipe, "top level")
