"""The bundled tiers, registered under ``vbbench.tiers``, and a tier on a split where people hide one another."""

from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from vbbench.camera import Camera
from vbbench.generation.tier import Observations, Sight, Tier, Told
from vbbench_generators.tiers.noise import Outline, Showing, add_pixel_noise, enough, see
from vbbench_generators.tiers.tracking.observing import VIDEO_RATE, finer, track_video
from vbbench_generators.tiers.tracking.settings import TrackingSettings, get_tracking


@dataclass(frozen=True, kw_only=True)
class Hiding:
    """That people hide one another.

    Parameters
    ----------
    least_visible : who shows less than this share has no box.
    cut : whether boxes are cut to what shows; otherwise they stay whole.
    outline : what people look like.
    """

    least_visible: float = 0.25
    cut: bool = True
    outline: Outline = field(default_factory=Outline)


def _showing(sight: Sight, outline: Outline) -> Showing:
    return see(sight.truth.positions, sight.truth.heights, sight.truth.poses, sight.camera, outline)


@dataclass(frozen=True, kw_only=True)
class Noise(Tier):
    """Boxes of whole people, with Gaussian noise of ``std`` px on column, top and bottom; nobody is hidden."""

    std: float

    def pixel_std(self, camera: Camera) -> float:  # noqa: ARG002
        """The noise that there is."""
        return self.std

    def noised(self, std: float) -> Tier:
        """Noise of another size."""
        return replace(self, std=std) if self.std > 0 else super().noised(std)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """Noise on everybody who is to be seen."""
        boxes = sight.boxes
        if self.std > 0:
            boxes = boxes.copy()
            boxes[sight.seen] = add_pixel_noise(boxes[sight.seen], sight.camera, self.std, rng)
        return Observations(boxes=boxes, visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0))


@dataclass(frozen=True, kw_only=True)
class Occlusion(Tier):
    """Nearer people hide those behind; who shows too little has no box, and what shows of others is exact."""

    hiding: Hiding = field(default_factory=Hiding)
    hides = True

    @property
    def definition(self) -> dict[str, Any]:
        """How people hide one another."""
        return {"hiding": asdict(self.hiding)}

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:  # noqa: ARG002
        """Boxes about what shows of everybody who shows enough."""
        showing = _showing(sight, self.hiding.outline)
        whole = replace(sight, seen=sight.seen & enough(showing, self.hiding.least_visible)).boxes
        observed = ~np.isnan(whole[..., 2])
        boxes = np.where(observed[..., None], showing.boxes, np.nan) if self.hiding.cut else whole
        return Observations(boxes=boxes, visible=np.where(observed, showing.visible, np.nan))


@dataclass(frozen=True, kw_only=True)
class BehindOthers(Tier):
    """A ``tier`` on a split whose people hide one another: who shows too little has no box, and others a whole one."""

    tier: Tier
    hiding: Hiding = field(default_factory=lambda: Hiding(cut=False))
    hides = True

    @property
    def definition(self) -> dict[str, Any]:
        """How people hide one another, and what the tier says."""
        return {"hiding": asdict(self.hiding), **self.tier.definition}

    @property
    def own_camera(self) -> Camera | None:
        """The tier's."""
        return self.tier.own_camera

    def told(self, camera: Camera) -> Told:
        """As the tier says."""
        return self.tier.told(camera)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """What the tier makes of everybody who shows enough."""
        showing = _showing(sight, self.hiding.outline)
        made = self.tier.observe(replace(sight, seen=sight.seen & enough(showing, self.hiding.least_visible)), rng)
        if made.persons is not None:
            return made
        return replace(made, visible=np.where(np.isnan(made.boxes[..., 2]), np.nan, showing.visible))


@dataclass(frozen=True, kw_only=True)
class Tracking(Tier):
    """A detector that errs on what shows of people, and a tracker that links what it finds; both by a settings file.

    They run at the rate of a video, and boxes are reported in the dataset's own frames.

    Parameters
    ----------
    outline : what people look like to whom they hide.
    least_track : tracks of fewer frames are removed; ``None`` for what the settings file says.
    """

    outline: Outline = field(default_factory=Outline)
    least_track: int | None = None
    hides = True

    @property
    def settings(self) -> TrackingSettings:
        """Those of the file, without shorter tracks."""
        return get_tracking().lasting(self.least_track)

    def lasting(self, frames: int) -> Tier:
        """Without shorter tracks."""
        return replace(self, least_track=frames)

    @property
    def definition(self) -> dict[str, Any]:
        """What people look like, the rate of the video, and all settings."""
        return {"outline": asdict(self.outline), "video_rate": VIDEO_RATE, "tracking": asdict(self.settings)}

    def pixel_std(self, camera: Camera) -> float:
        """As measured of this detector and tracker."""
        return get_tracking().pixel_std(camera)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """The boxes of tracks, and who is behind them."""
        fine, every = finer(sight)
        showing = _showing(fine, self.outline)
        tracked = track_video(fine, every, fine.boxes, showing, self.settings, self.outline, rng)
        return Observations(boxes=tracked.boxes, visible=tracked.scores, persons=tracked.persons)


ideal = Noise(name="ideal", summary="Boxes are exact: only people's heights are unknown.", std=0.0)
noisy = Noise(name="noisy", summary="Boxes carry Gaussian noise of one pixel.", std=1.0)
occluded = Occlusion(name="occluded", summary="Nearer people hide those behind; boxes are cut to what shows.")
tracked = Tracking(
    name="tracked",
    summary="Simulated detections in video, linked by a real tracker: people are missed, tracks break or change hands.",
)
