"""The bundled tiers, registered under ``vbbench.tiers``, and a wrapper that adds occlusion to a tier."""

from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from vbbench.camera import Camera
from vbbench.generation.tier import Observations, Sight, Tier, Told
from vbbench_generators.tiers.noise import Outline, Showing, add_pixel_noise, enough, see
from vbbench_generators.tiers.tracking import TrackingSettings, get_tracking
from vbbench_generators.tiers.tracking.observing import VIDEO_RATE, Film, finer, track_video


@dataclass(frozen=True, kw_only=True)
class Hiding:
    """Parameters of occlusion.

    Parameters
    ----------
    least_visible : least visible fraction of a person who has a box.
    cut : whether boxes are cut to the visible part; otherwise they stay whole.
    outline : outline of people.
    """

    least_visible: float = 0.25
    cut: bool = True
    outline: Outline = field(default_factory=Outline)


def _showing(sight: Sight, outline: Outline) -> Showing:
    return see(sight.truth.positions, sight.truth.heights, sight.truth.poses, sight.camera, outline)


@dataclass(frozen=True, kw_only=True)
class Noise(Tier):
    """Boxes with Gaussian noise of ``std`` px on column, top and bottom, without occlusion."""

    std: float

    def pixel_std(self, camera: Camera) -> float:  # noqa: ARG002
        """See `Tier.pixel_std`: the true noise."""
        return self.std

    def noised(self, std: float) -> Tier:
        """The tier with noise of ``std`` px."""
        return replace(self, std=std) if self.std > 0 else super().noised(std)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """See `Tier.observe`: boxes of all people in the picture, with noise."""
        boxes = sight.boxes
        if self.std > 0:
            boxes = boxes.copy()
            boxes[sight.seen] = add_pixel_noise(boxes[sight.seen], sight.camera, self.std, rng)
        return Observations(boxes=boxes, visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0))


@dataclass(frozen=True, kw_only=True)
class Occlusion(Tier):
    """Nearer people hide those behind them. Boxes are exact bounds of visible parts; mostly hidden people have none."""

    hiding: Hiding = field(default_factory=Hiding)
    hides = True

    @property
    def definition(self) -> dict[str, Any]:
        """The model of how people hide one another, for ``dataset.json``."""
        return {"hiding": asdict(self.hiding)}

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:  # noqa: ARG002
        """See `Tier.observe`: boxes of the visible parts of people who are visible enough."""
        showing = _showing(sight, self.hiding.outline)
        whole = replace(sight, seen=sight.seen & enough(showing, self.hiding.least_visible)).boxes
        observed = ~np.isnan(whole[..., 2])
        boxes = np.where(observed[..., None], showing.boxes, np.nan) if self.hiding.cut else whole
        return Observations(boxes=boxes, visible=np.where(observed, showing.visible, np.nan))


@dataclass(frozen=True, kw_only=True)
class BehindOthers(Tier):
    """A ``tier`` applied to people who are visible enough under occlusion; their boxes are whole."""

    tier: Tier
    hiding: Hiding = field(default_factory=lambda: Hiding(cut=False))
    hides = True

    @property
    def definition(self) -> dict[str, Any]:
        """See `Tier.definition`: the occlusion, and the definition of the inner tier."""
        return {"hiding": asdict(self.hiding), **self.tier.definition}

    @property
    def own_camera(self) -> Camera | None:
        """The camera of the inner tier."""
        return self.tier.own_camera

    def told(self, camera: Camera) -> Told:
        """See `Tier.told`: that of the inner tier."""
        return self.tier.told(camera)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """See `Tier.observe`: the inner tier's observations of people who are visible enough."""
        showing = _showing(sight, self.hiding.outline)
        made = self.tier.observe(replace(sight, seen=sight.seen & enough(showing, self.hiding.least_visible)), rng)
        if made.persons is not None:
            return made
        return replace(made, visible=np.where(np.isnan(made.boxes[..., 2]), np.nan, showing.visible))


@dataclass(frozen=True, kw_only=True)
class Tracking(Tier):
    """A simulated detector with errors, and a real tracker of its detections; both have a settings file.

    They run at the rate of a video, and boxes are reported in the dataset's own frames.

    Parameters
    ----------
    outline : outline of people, for occlusion.
    least_track : tracks of fewer frames are removed; ``None``: the value of the settings file.
    """

    outline: Outline = field(default_factory=Outline)
    least_track: int | None = None
    hides = True

    @property
    def settings(self) -> TrackingSettings:
        """The settings of the file, with ``least_track``."""
        return get_tracking().lasting(self.least_track)

    def lasting(self, frames: int) -> Tier:
        """The tier without tracks of fewer frames."""
        return replace(self, least_track=frames)

    @property
    def definition(self) -> dict[str, Any]:
        """See `Tier.definition`: outline, rate of the video, and all settings."""
        return {"outline": asdict(self.outline), "video_rate": VIDEO_RATE, "tracking": asdict(self.settings)}

    def pixel_std(self, camera: Camera) -> float:
        """See `Tier.pixel_std`: the noise measured on this detector and tracker."""
        return get_tracking().pixel_std(camera)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """See `Tier.observe`: boxes of tracks, with the person of each."""
        fine, every = finer(sight)
        film = Film(sight=fine, every=every, boxes=fine.boxes, showing=_showing(fine, self.outline))
        return track_video(film, self.settings, self.outline, rng)


ideal = Noise(name="ideal", summary="Boxes are exact: only people's heights are unknown.", std=0.0)
noisy = Noise(name="noisy", summary="Boxes carry Gaussian noise of one pixel.", std=1.0)
occluded = Occlusion(name="occluded", summary="Nearer people hide those behind; boxes are cut to what shows.")
tracked = Tracking(
    name="tracked",
    summary="Simulated detections in video, linked by a real tracker: people are missed, tracks break or change hands.",
)
