"""What is so and what submissions answer, in the world and on the map: people, observers, and errors over time."""

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
    _record_people(ground, replay, np.where(sequence.observed[..., None], source.positions, np.nan))
    if replay.truth is None:
        ground.arrows("given-observer", sequence.given.poses, marks.GIVEN, 1.0, 0.05)
        return
    ground.trails("trails", replay.truth.positions, sequence.observed, marks.TRAIL, TRAIL_FRAMES)
    _record_bystanders(ground, replay)
    _record_observer(ground, replay, replay.truth.poses)


def _record_people(ground: Ground, replay: Replay, places: FloatArray) -> None:
    names = [str(track) for track in replay.sequence.tracks]
    look = People(marks.id_colours(replay.sequence.tracks), names, shown=True)
    ground.bodies("people", places, _heights(replay), look, solid=True)
    ground.dots("people", places, look, 5.0)


def _record_bystanders(ground: Ground, replay: Replay) -> None:
    places, heights = replay.bystanders
    look = People(np.tile(np.array(marks.UNSEEN, np.uint8), (len(heights), 1)))
    ground.bodies("unseen", places, heights, look, solid=False)
    ground.dots("unseen", places, look, 2.5)


def _record_observer(ground: Ground, replay: Replay, poses: FloatArray) -> None:
    """The observer moves and turns; body, viewing direction and camera hang on that."""
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
    """The camera at its height, tilted as it is, and its picture before it."""
    rr = ground.tape.rr
    # Rows are where the camera looks, its left and its top, as (forward, left, up) of the observer.
    axes = camera.to_level(np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])) @ _FORWARD_LEFT_UP
    placed = rr.Transform3D(translation=(0.0, 0.0, camera.mount_height), mat3x3=axes.T)
    size, towards = camera.picture_size, rr.ViewCoordinates.FLU
    pinhole = rr.Pinhole(
        image_from_camera=intrinsics, resolution=size, camera_xyz=towards, image_plane_distance=_FRUSTUM
    )
    ground.tape.always(CAMERA, placed)
    ground.tape.always(CAMERA, pinhole)


def record_estimate(ground: Ground, replay: Replay, number: int) -> None:
    """Record the answer of submission ``number``, in a tree and a colour of its own."""
    answer, colour = replay.answers[number], marks.solver_colour(number)
    name = ground.tape.rr.escape_entity_path_part(answer.name)
    tree = f"estimates/{name}"
    _record_answered_people(ground, replay, answer, tree, colour)
    _record_answered_observer(ground, answer, tree, colour)
    if replay.truth is not None:
        _record_error_lines(ground, replay, answer, tree)
        _record_error_series(ground, answer, name, colour)


def _record_answered_people(ground: Ground, replay: Replay, answer: Answer, tree: str, colour: Colour) -> None:
    places, tracks = answer.estimate.positions, replay.sequence.tracks
    labels = [f"{track} {answer.name}" for track in tracks]
    look = People(np.tile(np.array(colour, np.uint8), (len(tracks), 1)), labels, shown=replay.truth is None)
    ground.bodies(f"{tree}/people", places, _heights(replay), look, solid=False)
    ground.dots(f"{tree}/people", places, look, 3.0)
    ground.trails(f"{tree}/trails", places, replay.sequence.observed, colour, TRAIL_FRAMES)
    ground.rings(f"{tree}/given", answer.given.positions, marks.GIVEN, 1.5 * GIRTH)
    if answer.estimate.position_covariances is not None:
        spread = answer.estimate.position_covariances
        ground.ellipses(f"{tree}/95-percent", places, spread, colour, reach=CONFIDENCE)


def _record_answered_observer(ground: Ground, answer: Answer, tree: str, colour: Colour) -> None:
    poses = answer.estimate.poses
    ground.arrows(f"{tree}/observer", poses, colour, 1.2, 0.05)
    ground.trails(
        f"{tree}/observer-trail", poses[:, None, :2], np.ones((len(poses), 1), np.bool_), colour, OBSERVER_FRAMES
    )
    if answer.estimate.pose_covariances is not None:
        spread = answer.estimate.pose_covariances[:, None, :2, :2]
        ground.ellipses(f"{tree}/observer-95-percent", poses[:, None, :2], spread, colour, reach=CONFIDENCE)


def _record_error_lines(ground: Ground, replay: Replay, answer: Answer, tree: str) -> None:
    """From where people and the observer are to where they are said to be."""
    if replay.truth is None:
        return
    truth = np.concatenate([replay.truth.positions, replay.truth.poses[:, None, :2]], axis=1)
    said = np.concatenate([answer.estimate.positions, answer.estimate.poses[:, None, :2]], axis=1)
    ground.lines(f"{tree}/{ERRORS}", truth, said, marks.ERROR, 0.03)


def _record_error_series(ground: Ground, answer: Answer, name: str, colour: Colour) -> None:
    tape = ground.tape
    for key, values in answer.errors.items():
        path, frames = f"{ERRORS}/{key}/{name}", np.flatnonzero(np.isfinite(values))
        tape.always(path, tape.rr.SeriesLines(colors=[colour], names=[answer.name], widths=[1.5]))
        tape.each(path, tape.rr.Scalars, frames, scalars=values[frames])


def _heights(replay: Replay) -> FloatArray:
    """[K] true heights in m where they are known, the prior's mean elsewhere."""
    mean = replay.info.height_mean
    if replay.truth is None:
        return np.full(len(replay.sequence.tracks), mean)
    return np.where(np.isfinite(replay.truth.heights), replay.truth.heights, mean)
