"""Truth and the answers of submissions, in the world and on the map: people, observers, and errors over time."""

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench.pictures.replay import Answer, Replay
from vbbench.pictures.viewer import marks
from vbbench.pictures.viewer.marks import GIRTH, MAP, WORLD, Colour, Ground, People

CAMERA = f"{WORLD}/observer/camera"
TRAIL_FRAMES, OBSERVER_FRAMES = 12, 200
"""Frames of the past in which trails show, people's and the observer's."""

ERRORS = "errors"
CONFIDENCE = 2.4477
"""Standard deviations of an ellipse that holds 95 % of a Gaussian of the plane, √(−2 ln 0.05)."""

_FORWARD_LEFT_UP = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # of right, down, forward
_FRUSTUM = 2.5  # m from the camera to the picture that is drawn before it


def record_world(ground: Ground, replay: Replay) -> None:
    """Record the ground, and the truth where it is available, else what is given."""
    rr, sequence = ground.tape.rr, replay.sequence
    ground.tape.always(WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP)
    if not replay.answers:
        ground.rings("given", sequence.given.positions, marks.GIVEN, 1.5 * GIRTH)
    source = sequence.given if replay.truth is None else replay.truth
    places = np.where(sequence.observed[..., None], source.positions, np.nan)
    look = People(marks.people_colours(replay), [str(track) for track in sequence.tracks], shown=True)
    ground.bodies("people", places, _heights(replay), look, solid=True)
    ground.dots("people", places, look, 5.0)
    if replay.truth is None:
        ground.arrows("given-observer", sequence.given.poses, marks.GIVEN, 1.0)
        return
    ground.trails("trails", replay.truth.positions, sequence.observed, marks.TRAIL, TRAIL_FRAMES)
    if replay.poses_known:
        _record_observer(ground, replay, replay.truth.poses)
    elif not replay.answers:
        ground.arrows("camera", replay.viewpoints, marks.TRUTH, 1.0)
    places, heights = replay.bystanders
    look = People(np.tile(np.array(marks.UNSEEN, np.uint8), (len(heights), 1)))
    ground.bodies("unseen", places, heights, look, solid=False)
    ground.dots("unseen", places, look, 2.5)


def _record_observer(ground: Ground, replay: Replay, poses: FloatArray) -> None:
    """The observer's moving frame, with body, viewing direction and camera in it."""
    tape, rr, camera = ground.tape, ground.tape.rr, replay.camera
    half, level = 0.5 * poses[:, 2], np.zeros(len(poses))
    tape.each(
        f"{WORLD}/observer",
        rr.Transform3D,
        translation=np.column_stack([poses[:, :2], level]),
        quaternion=np.column_stack([level, level, np.sin(half), np.cos(half)]),
    )
    mount, colour = camera.mount_height, marks.TRUTH
    body = rr.Ellipsoids3D(centers=[(0, 0, mount / 2)], half_sizes=[(GIRTH, GIRTH, mount / 2)], colors=[colour])
    tape.always(f"{WORLD}/observer/body", body)
    gaze = rr.Arrows3D(origins=[(0, 0, mount)], vectors=[(1.2, 0, 0)], colors=[colour], radii=0.04)
    tape.always(f"{WORLD}/observer/gaze", gaze)
    ground.trails("observer-trail", poses[:, None, :2], np.ones((len(poses), 1), np.bool_), colour, OBSERVER_FRAMES)
    ahead = 1.2 * np.stack([np.cos(poses[:, 2]), -np.sin(poses[:, 2])], axis=1)
    origins = poses[:, :2] * (1.0, -1.0)
    tape.always(f"{MAP}/observer", rr.Arrows2D.from_fields(colors=colour, radii=0.08))
    tape.each(f"{MAP}/observer", rr.Arrows2D, origins=origins, vectors=ahead)
    if camera.intrinsics is not None:
        _record_pinhole(ground, camera, camera.intrinsics)


def _record_pinhole(ground: Ground, camera: Camera, intrinsics: FloatArray) -> None:
    """The camera at its height, with its tilt, and its picture in front of it."""
    rr = ground.tape.rr
    # Rows are where the camera looks, its left and its top, as (forward, left, up) of the observer.
    axes = camera.to_level(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])) @ _FORWARD_LEFT_UP
    placed = rr.Transform3D(translation=(0.0, 0.0, camera.mount_height), mat3x3=axes.T)
    look = {"camera_xyz": rr.ViewCoordinates.FLU, "image_plane_distance": _FRUSTUM}
    ground.tape.always(CAMERA, placed)
    ground.tape.always(CAMERA, rr.Pinhole(image_from_camera=intrinsics, resolution=camera.picture_size, **look))


def record_estimate(ground: Ground, replay: Replay, number: int) -> None:
    """Record the answer of submission ``number``, in its own tree and colour, and its errors."""
    answer, colour = replay.answers[number], marks.answer_colours(replay)[number]
    name = ground.tape.rr.escape_entity_path_part(answer.name)
    tree = f"estimates/{name}"
    _record_answered_people(ground, replay, answer, tree, colour)
    _record_answered_observer(ground, answer, tree, colour)
    if answer.truth is None:
        return
    true, estimated = (
        np.concatenate([one.positions, one.poses[:, None, :2]], axis=1) for one in (answer.truth, answer.estimate)
    )
    ground.lines(f"{tree}/{ERRORS}", true, estimated, marks.ERROR, 0.03)
    tape = ground.tape
    for key, values in answer.errors.items():
        path, frames = f"{ERRORS}/{key}/{name}", np.flatnonzero(np.isfinite(values))
        tape.always(path, tape.rr.SeriesLines(colors=[colour], names=[answer.name], widths=[1.5]))
        tape.each(path, tape.rr.Scalars, frames, scalars=values[frames])


def _record_answered_people(ground: Ground, replay: Replay, answer: Answer, tree: str, colour: Colour) -> None:
    places, tracks = answer.estimate.positions, replay.sequence.tracks
    labels = [f"{track} {answer.name}" for track in tracks]
    look = People(np.tile(np.array(colour, np.uint8), (len(tracks), 1)), labels, shown=not replay.places_known)
    ground.bodies(f"{tree}/people", places, _heights(replay), look, solid=False)
    ground.dots(f"{tree}/people", places, look, 3.0)
    ground.trails(f"{tree}/trails", places, replay.sequence.observed, colour, TRAIL_FRAMES)
    ground.rings(f"{tree}/given", answer.given.positions, marks.GIVEN, 1.5 * GIRTH)
    if answer.estimate.position_covariances is not None:
        spread = answer.estimate.position_covariances
        ground.ellipses(f"{tree}/95-percent", places, spread, colour, reach=CONFIDENCE)


def _record_answered_observer(ground: Ground, answer: Answer, tree: str, colour: Colour) -> None:
    poses = answer.estimate.poses
    ground.arrows(f"{tree}/observer", poses, colour, 1.2)
    ground.trails(
        f"{tree}/observer-trail", poses[:, None, :2], np.ones((len(poses), 1), np.bool_), colour, OBSERVER_FRAMES
    )
    if answer.estimate.pose_covariances is not None:
        spread = answer.estimate.pose_covariances[:, None, :2, :2]
        ground.ellipses(f"{tree}/observer-95-percent", poses[:, None, :2], spread, colour, reach=CONFIDENCE)


def _heights(replay: Replay) -> FloatArray:
    """[K] true heights in m if they are known, else the prior's mean."""
    true = np.full(len(replay.sequence.tracks), np.nan) if replay.truth is None else replay.truth.heights
    return np.where(np.isfinite(true), true, replay.info.height_mean)
