"""Lifts the heads of a surveillance picture to the ground plane."""

from dataclasses import dataclass

from vbbench.arrays import FloatArray
from vbbench.errors import VbbenchError
from vbbench.scene import Scene
from vbbench_generators.lifting.calibration import Calibration, calibration_of
from vbbench_generators.lifting.finding import below_horizon, find_by_heads, find_by_homography
from vbbench_generators.lifting.heads import HeadBoxes, split_at_gaps
from vbbench_generators.lifting.settings import LiftingSettings
from vbbench_generators.lifting.smoothing import smooth_tracks
from vbbench_generators.lifting.walking import walking_speed


@dataclass(frozen=True, kw_only=True)
class Lifted:
    """A crowd on the ground, and the camera that saw it.

    Parameters
    ----------
    tracks : in m, X to the right and Y forward from the camera's foot, or in the frame of the user's homography.
    calibration : the camera and how well it is known.
    """

    tracks: Scene
    calibration: Calibration


def lift(boxes: HeadBoxes, settings: LiftingSettings, homography: FloatArray | None = None) -> Lifted:
    """Put a crowd's heads on the ground.

    Parameters
    ----------
    boxes : of one recording.
    settings : the recipe's.
    homography : [3, 3] from px to metres on the ground; without it, the camera is found from the heads.

    Raises
    ------
    VbbenchError
        If the heads, or the homography, do not tell where the camera is.
    """
    if not len(boxes):
        raise VbbenchError(f"{boxes.name}: no head box to lift")
    heads = boxes.heads()
    try:
        if homography is not None:
            found = find_by_homography(homography, heads, boxes.centre, settings)
        else:
            found = find_by_heads(heads, boxes, settings)
        kept = below_horizon(found.camera.depth(heads.x, heads.nu))
    except ValueError as error:
        advice = "is that of another picture?" if homography is not None else "give its homography with --homography"
        raise VbbenchError(f"{boxes.name}: the camera cannot be found: {error}; {advice}") from error
    heads = heads.take(kept)
    speed = walking_speed(heads, found.camera, settings.window)
    if settings.apply_walking_speed and speed is not None and found.fit is not None:
        found = found.scaled(settings.walking_speed / speed, settings.head_height)
    heads = split_at_gaps(heads, settings.gap)
    smoothed = smooth_tracks(heads, found.camera, settings.head_size * found.scale, boxes.name)
    calibration = calibration_of(found, heads, smoothed, settings, boxes.centre[1], speed)
    return Lifted(tracks=smoothed.scene, calibration=calibration)
