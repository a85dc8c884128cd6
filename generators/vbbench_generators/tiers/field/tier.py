"""The tier `field`: boxes of a simulated carried camera with the errors of a real one."""

from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from vbbench.camera import Camera
from vbbench.generation.tier import Heights, Observations, Sight, Tier, Told
from vbbench.geometry import FloatArray, world_to_relative
from vbbench.sequence import NOBODY
from vbbench_generators.tiers.field import FieldRecipe, carry, cut_rows, drawn, frame, get_field, whole_boxes
from vbbench_generators.tiers.noise import Outline, Showing, see_figures
from vbbench_generators.tiers.tracking import get_tracking
from vbbench_generators.tiers.tracking.observing import Film, finer, track_video


@dataclass(frozen=True, kw_only=True)
class Field(Tier):
    """A camera with unknown tilt, sway and height error, over uneven ground; borders of the picture cut boxes.

    Parameters
    ----------
    outline : outline of people, for occlusion.
    detects : whether boxes are those of a detector and tracker, not of an annotator.
    least_track : tracks of fewer frames are removed; ``None``: the value of the tracker's settings file.
    """

    outline: Outline = field(default_factory=Outline)
    detects: bool = True
    least_track: int | None = None
    hides = True
    look = "natural"

    @property
    def definition(self) -> dict[str, Any]:
        """See `Tier.definition`: the recipe, and the outline of people."""
        recipe = get_field()
        return {
            "field": {name: asdict(part) for name, part in vars(recipe).items()},
            "outline": asdict(self.outline),
            "detector": {"tracker": asdict(get_tracking().lasting(self.least_track).tracker)} if self.detects else None,
        }

    @property
    def own_camera(self) -> Camera:
        """KITTI's camera."""
        return get_field().camera

    @property
    def own_heights(self) -> Heights:
        """The distribution of heights in KITTI."""
        return get_field().heights

    def told(self, camera: Camera) -> Told:
        """See `Tier.told`: standard deviations of boxes, tilt and mount height, but not the true values."""
        recipe = get_field()
        return Told(
            pixel_std=recipe.pixel_std(camera, self.detects),
            box_std=(recipe.detector if self.detects else recipe.annotator).box_std,
            tilt_std=float(np.hypot(recipe.tilt.pitch_std, recipe.tilt.sway_pitch_std)),
            mount_height_std=recipe.mount.std,
        )

    def annotated(self) -> "Field":
        """The tier with an annotator's boxes."""
        return replace(self, detects=False)

    def lasting(self, frames: int) -> Tier:
        """The tier without tracks of fewer frames, if it has a tracker."""
        return replace(self, least_track=frames) if self.detects else super().lasting(frames)

    def observe(self, sight: Sight, rng: np.random.Generator) -> Observations:
        """See `Tier.observe`: boxes of tracks, or an annotator's."""
        return (self._tracked if self.detects else self._drawn)(sight, get_field(), rng)

    def _drawn(self, sight: Sight, recipe: FieldRecipe, rng: np.random.Generator) -> Observations:
        boxes, showing = look(sight, recipe, self.outline, rng)
        model = recipe.annotator
        who = np.flatnonzero(sight.seen & (showing.visible >= model.least_visible))
        framed, inside = frame(drawn(boxes, who, sight.dt, model, rng), sight.camera, recipe.body.aspect)
        kept = inside >= model.least_inside
        made, visible = np.full((sight.seen.size, 3), np.nan), np.full(sight.seen.size, np.nan)
        made[who[kept]] = framed[kept]
        visible[who[kept]] = (showing.visible.reshape(-1)[who] * inside)[kept]
        return Observations(boxes=made.reshape(boxes.shape), visible=visible.reshape(boxes.shape[:2]))

    def _tracked(self, sight: Sight, recipe: FieldRecipe, rng: np.random.Generator) -> Observations:
        settings = recipe.tracking(sight.camera).lasting(self.least_track)
        tracked = track_video(self.film(sight, recipe, rng), settings, self.outline, rng)
        boxes = cut_rows(tracked.boxes, sight.camera)
        found = ~np.isnan(boxes[..., 2])
        persons = None if tracked.persons is None else np.where(found, tracked.persons, NOBODY)
        return Observations(boxes=boxes, visible=np.where(found, tracked.visible, np.nan), persons=persons)

    def film(self, sight: Sight, recipe: FieldRecipe, rng: np.random.Generator) -> Film:
        """The exact boxes at the rate of a video, for the detector."""
        fine, every = finer(sight)
        boxes, showing = look(fine, recipe, self.outline, rng)
        framed, inside = frame(boxes, sight.camera, recipe.body.aspect)
        kept = fine.seen & (inside >= recipe.annotator.least_inside)
        return Film(sight=fine, every=every, boxes=np.where(kept[..., None], framed, np.nan), showing=showing)


def look(sight: Sight, recipe: FieldRecipe, outline: Outline, rng: np.random.Generator) -> tuple[FloatArray, Showing]:
    """Boxes [T, K, 3] of whole people in the carried camera, and their visible parts."""
    truth, camera = sight.truth, sight.camera
    carriage = carry(truth.poses, camera.mount_height, sight.dt, sight.observer, recipe, rng)
    relative = world_to_relative(truth.positions, truth.poses)
    near_edge = rng.uniform(recipe.body.nearest_edge, recipe.body.farthest_edge)
    boxes = whole_boxes(relative, sight, carriage, near_edge)
    feet = np.stack([boxes[..., 0], boxes[..., 1] + 0.5 * boxes[..., 2], boxes[..., 2]], axis=-1)
    distances = np.where(np.isnan(boxes[..., 2]), np.nan, camera.depth(relative))
    return boxes, see_figures(feet, distances, camera, outline)


field_tier = Field(
    name="field",
    summary="A camera as real as footage: tilted and swaying over uneven ground, with boxes cut off at its borders, of "
    "a detector and tracker, or as people draw them (`detector = false`).",
)
