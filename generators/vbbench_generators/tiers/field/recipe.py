"""The file ``field.toml`` as frozen dataclasses: statistics of real cameras and boxes."""

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
    """Tilt of the camera, which solvers are not given.

    Parameters
    ----------
    pitch_std, roll_std : standard deviations in rad of the part that is constant throughout a sequence.
    sway_pitch_std, sway_roll_std : standard deviations in rad of the sway, whose correlation time is ``sway_time`` s.
    """

    pitch_std: Angle
    roll_std: Angle
    sway_pitch_std: Angle
    sway_roll_std: Angle
    sway_time: Seconds


@dataclass(frozen=True, kw_only=True)
class MountModel(_Checked):
    """Height of the camera.

    Parameters
    ----------
    std : standard deviation in m about the height that solvers are given, constant throughout a sequence.
    bob : amplitude in m of a walker's vertical motion at the speed ``bob_pace`` in m/s and above; proportional below.
    step_rate : steps per second.
    """

    std: Metres
    bob: Metres
    bob_pace: Annotated[float, Within(0.01, 10.0, "m/s")]
    step_rate: Annotated[float, Within(0.1, 10.0, "Hz")]


@dataclass(frozen=True, kw_only=True)
class GroundModel(_Checked):
    """Uneven ground: ``waves`` waves with lengths from ``shortest`` to ``longest`` m, and ``std`` m in all."""

    std: Metres
    shortest: Annotated[float, Within(0.1, 1e4, "m")]
    longest: Annotated[float, Within(0.1, 1e4, "m")]
    waves: Annotated[int, Within(1, 1000)]


@dataclass(frozen=True, kw_only=True)
class BodyModel(_Checked):
    """Extent of a body in its box.

    Parameters
    ----------
    nearest_edge, farthest_edge : least and greatest near edge δ in m: the distance by which the edge that bounds a box
        is nearer than the body's axis; constant throughout a sequence.
    aspect : width of a box over its height.
    """

    nearest_edge: Metres
    farthest_edge: Metres
    aspect: Annotated[float, Within(0.05, 5.0)]


@dataclass(frozen=True, kw_only=True)
class AnnotatorModel(_Checked):
    """Errors of annotators' boxes, as standard deviations in box heights.

    Parameters
    ----------
    bottom_person_std, column_person_std : of the lower edge and the centre column, constant for each person.
    bottom_std, column_std : of these in time, with the correlation times ``bottom_time`` and ``column_time`` in s.
    top_std : of the upper edge, independent in each frame.
    least_visible : least visible share of the part inside the picture, of a person who has a box.
    least_inside : least share inside the picture of such a box.
    pixel_std : the noise that solvers are given, in px at the focal length of the recipe's camera.
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
    """The noise in px of a detector's boxes that solvers are given, in pictures with borders and in panoramas."""

    perspective_std: Annotated[float, Within(0.0, 100.0, "px")]
    panorama_std: Annotated[float, Within(0.0, 100.0, "px")]


@dataclass(frozen=True, kw_only=True)
class FieldRecipe:
    """All models of the tier, each a table of the file."""

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
        """The noise in px that solvers are given, of a detector's or an annotator's boxes in a ``camera``."""
        if detects:
            return self.tracking(camera).pixel_std(camera)
        return self.annotator.pixel_std * camera.focal / self.camera.focal

    def tracking(self, camera: Camera) -> TrackingSettings:
        """The detector for the pictures of ``camera``, with the tracker of the tier `tracked`.

        A lidar detects people by their distance: heights in px at which it misses them scale with the focal length.
        """
        small = self.detector.score_small * camera.focal / self.camera.focal
        told = vars(self.told_of_detector)
        return replace(get_tracking(), detector=replace(self.detector, score_small=small), **told)


@cache
def get_field() -> FieldRecipe:
    """The recipe that comes with this package."""
    return read_bundled("vbbench_generators", "tiers/field/field.toml", FieldRecipe, "top level")
