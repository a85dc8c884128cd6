"""Tiers: how exact boxes are corrupted."""

from dataclasses import asdict, dataclass, field
from typing import Any

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray
from vbbench_generators.tiers.noise import Precision
from vbbench_generators.tiers.occlusion import Outline
from vbbench_generators.tiers.tracking.settings import TrackingSettings, get_tracking

PIXEL_STD = {"ideal": 0.0, "noisy": 1.0, "occluded": 0.0}
"""Standard deviation in px of a box's column, top and bottom, by tier; that of `tracked` stands in its settings."""
TIERS = (*PIXEL_STD, "tracked")


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


@dataclass(frozen=True, kw_only=True)
class Corruption:
    """What is done to exact boxes.

    Parameters
    ----------
    pixel_std : noise in px on column, top and bottom.
    hiding : ``None`` where everybody is seen through everybody.
    tracking : detector and tracker whose boxes are seen instead of people's own; ``None`` for these.
    precision : what boxes are rounded to in the end; ``None`` = not at all.
    """

    pixel_std: float = 0.0
    hiding: Hiding | None = None
    tracking: TrackingSettings | None = None
    precision: Precision | None = None

    def told_std(self, camera: Camera) -> float:
        """What solvers are told of the noise on column, top and bottom, in px."""
        return self.pixel_std if self.tracking is None else self.tracking.pixel_std(camera)

    @property
    def definition(self) -> dict[str, Any]:
        """What a dataset's definition says of it beside the tier and the noise."""
        precision = {} if self.precision is None else {"precision": asdict(self.precision)}
        if self.tracking is not None:
            outline = asdict((self.hiding or Hiding()).outline)
            return {"outline": outline, "tracking": asdict(self.tracking), **precision}
        return precision if self.hiding is None else {"hiding": asdict(self.hiding), **precision}

    def written(self, boxes: FloatArray, camera: Camera) -> FloatArray:
        """Boxes [..., 3] in px as they are written."""
        return boxes if self.precision is None else self.precision.rounded(boxes, camera)


def corruption_of(tier: str, *, whole: bool = False) -> Corruption:
    """What the ``tier`` does to boxes; with ``whole`` hidden people have none in any tier, and others a whole one."""
    if tier == "tracked":
        return Corruption(hiding=Hiding(), tracking=get_tracking())
    cut = tier == "occluded"
    return Corruption(pixel_std=PIXEL_STD[tier], hiding=Hiding(cut=cut) if cut or whole else None)


def check_options(split: str, options: Options) -> None:
    """Raise VbbenchError unless the tier that is asked of a ``split`` is one of `TIERS`."""
    if options.tier not in TIERS:
        raise VbbenchError(f"split '{split}' offers the tiers {', '.join(TIERS)}, not '{options.tier}'")
