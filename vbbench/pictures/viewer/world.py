"""What is really so: people of their true height, trails, and the observer with the camera."""

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.geometry import FloatArray
from vbbench.pictures.viewer import palette
from vbbench.pictures.viewer.ground import GIRTH, MAP, WORLD, Ground, People
from vbbench.pictures.viewer.take import Take

CAMERA = f"{WORLD}/observer/camera"
TRAIL_FRAMES, OBSERVER_FRAMES = 12, 200
"""Frames of the past in which trails show, people's and the observer's."""

_FRUSTUM = 2.5  # m from the camera to the picture that is drawn before it


def record_world(ground: Ground, take: Take) -> None:
    """Record the ground, and the truth where it is at hand, else what is given."""
    rr, sequence = ground.tape.rr, take.sequence
    ground.tape.always(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    if not take.estimates:
        ground.rings("given", sequence.given.positions, palette.GIVEN, 1.5 * GIRTH)
    if take.truth is None:
        given = np.where(sequence.observed[..., None], sequence.given.positions, np.nan)
        _record_people(ground, take, given, np.full(len(sequence.tracks), take.dataset.info.height_mean))
        ground.arrows("given-observer", sequence.given.poses, palette.GIVEN, 1.0, 0.05)
        return
    seen = np.where(sequence.observed[..., None], take.truth.positions, np.nan)
    _record_people(ground, take, seen, take.truth.heights)
    ground.trails("trails", take.truth.positions, sequence.observed, palette.TRAIL, TRAIL_FRAMES)
    _record_unseen(ground, take)
    _record_observer(ground, take, take.truth.poses)


def _record_people(ground: Ground, take: Take, places: FloatArray, heights: FloatArray) -> None:
    names = [str(track) for track in take.sequence.tracks]
    look = People(palette.id_colours(take.sequence.tracks), names, shown=True)
    ground.bodies("people", places, heights, look, solid=True)
    ground.dots("people", places, look, 5.0)


def _record_unseen(ground: Ground, take: Take) -> None:
    places, heights = take.unseen
    look = People(np.tile(np.array(palette.UNSEEN, np.uint8), (len(heights), 1)))
    ground.bodies("unseen", places, heights, look, solid=False)
    ground.dots("unseen", places, look, 2.5)


def _record_observer(ground: Ground, take: Take, poses: FloatArray) -> None:
    """The observer moves and turns; body, viewing direction and camera hang on that."""
    tape, rr, camera = ground.tape, ground.tape.rr, take.dataset.info.camera
    half, level = 0.5 * poses[:, 2], np.zeros(len(poses))
    tape.each(
        f"{WORLD}/observer",
        rr.Transform3D,
        translation=np.column_stack([poses[:, :2], level]),
        quaternion=np.column_stack([level, level, np.sin(half), np.cos(half)]),
    )
    mount, colour = camera.mount_height, palette.TRUTH
    body = rr.Ellipsoids3D(centers=[(0, 0, mount / 2)], half_sizes=[(GIRTH, GIRTH, mount / 2)], colors=[colour])
    tape.always(f"{WORLD}/observer/body", body)
    gaze = rr.Arrows3D(origins=[(0, 0, mount)], vectors=[(1.2, 0, 0)], colors=[colour], radii=0.04)
    tape.always(f"{WORLD}/observer/gaze", gaze)
    ground.trails("observer-trail", poses[:, None, :2], np.ones((len(poses), 1), np.bool_), colour, OBSERVER_FRAMES)
    ahead = 1.2 * np.stack([np.cos(poses[:, 2]), -np.sin(poses[:, 2])], axis=1)
    origins = poses[:, :2] * (1.0, -1.0)
    tape.always(f"{MAP}/observer", rr.Arrows2D.from_fields(colors=colour, radii=0.08))
    tape.each(f"{MAP}/observer", rr.Arrows2D, origins=origins, vectors=ahead)
    if isinstance(camera, PerspectiveCamera):
        _record_pinhole(ground, camera)


def _record_pinhole(ground: Ground, camera: PerspectiveCamera) -> None:
    rr = ground.tape.rr
    pinhole = rr.Pinhole(
        focal_length=camera.focal,
        principal_point=(camera.cx, camera.cy),
        resolution=(camera.width, camera.height),
        camera_xyz=rr.ViewCoordinates.FLU,
        image_plane_distance=_FRUSTUM,
    )
    ground.tape.always(CAMERA, rr.Transform3D(translation=(0.0, 0.0, camera.mount_height)))
    ground.tape.always(CAMERA, pinhole)
