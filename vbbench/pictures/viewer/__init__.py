"""Recordings of a sequence for the rerun viewer: the world, the map, the ego view and errors, frame by frame.

A file is written whole or not at all. Rerun (extra ``viewer``) is imported when a recording is made, not before.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.camera import Camera
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe
from vbbench.folders.replacing import replacing
from vbbench.geometry import FloatArray
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.replay import Answer, Replay, load_replay
from vbbench.pictures.viewer import marks
from vbbench.pictures.viewer.marks import GIRTH, MAP, WORLD, Colour, Ground, People, Tape, rerun, strictly
from vbbench.scoring.metrics import METRICS
from vbbench.sequence import Given

QUALITY = 90
"""Of the JPEG pictures, in percent."""
_HORIZON_POINTS = 181


CAMERA = f"{WORLD}/observer/camera"
TRAIL_FRAMES, OBSERVER_FRAMES = 12, 200
"""Frames of the past in which trails show, people's and the observer's."""

ERRORS = "errors"
CONFIDENCE = 2.4477
"""Standard deviations of an ellipse that holds 95 % of a Gaussian of the plane, √(−2 ln 0.05)."""

_FORWARD_LEFT_UP = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # of right, down, forward
_FRUSTUM = 2.5  # m from the camera to the picture that is drawn before it


def ego_root(replay: Replay) -> str:
    """The parent of the picture: a pinhole camera whose pose is known, else its own plane."""
    return CAMERA if replay.camera.intrinsics is not None and replay.poses_known else "ego"


def record_boxes(tape: Tape, replay: Replay) -> None:
    """Record everybody's box in their colour, false alarms in red, and at both ends if it crosses a panorama's seam."""
    root, sequence = ego_root(replay), replay.sequence
    frame, track = np.nonzero(sequence.observed)
    colours = marks.people_colours(replay)[track]
    colours[replay.false_alarms[frame, track]] = marks.ALARM
    boxes, row = with_seam_copies(rectangles(sequence.observations[frame, track]), replay.camera.period)
    tape.many(
        f"{root}/boxes",
        tape.rr.Boxes2D,
        np.bincount(frame[row], minlength=sequence.frames),
        centers=boxes[:, :2] + 0.5 * boxes[:, 2:],
        half_sizes=0.5 * boxes[:, 2:],
        colors=colours[row],
        labels=sequence.tracks[track[row]].astype(str),
    )
    _record_frame(tape, replay, root)


def record_footage(tape: Tape, replay: Replay) -> None:
    """Record the pictures that the camera itself took, in the frames that have one."""
    rr, path, frames = tape.rr, f"{ego_root(replay)}/picture", replay.sequence.frames
    backdrop = Backdrop(replay.dataset, replay.sequence)
    if backdrop.is_recorded:
        with progress_bar(frames, "frames", unit="frame") as bar:
            for frame in range(frames):
                shown = backdrop.recorded(frame)
                image = rr.Clear(recursive=False) if shown is None else rr.Image(shown).compress(jpeg_quality=QUALITY)
                tape.now(frame, path, image)
                bar.update()


def _record_frame(tape: Tape, replay: Replay, root: str) -> None:
    """The picture's border and horizon, and in a panorama the directions of its columns; lines of one pixel."""
    rr, camera = tape.rr, replay.camera
    width, height = camera.picture_size
    look: dict[str, Any] = {"colors": [marks.BORDER], "radii": rr.Radius.ui_points(0.5)}
    tape.always(f"{root}/border", rr.Boxes2D(mins=[(0, 0)], sizes=[(width, height)], **look))
    columns = np.linspace(0.0, width, _HORIZON_POINTS)
    rows = camera.horizon(columns)
    inside = (rows >= 0.0) & (rows <= height)
    points = np.stack([columns, rows], axis=-1)
    pieces = np.stack([points[:-1], points[1:]], axis=1)[inside[:-1] & inside[1:]]
    tape.always(f"{root}/horizon", rr.LineStrips2D(pieces, **look))
    ahead = {text: column for text, column in replay.bearings.items() if text != "behind"}
    if ahead:
        places = [(column, 0.04 * height) for column in ahead.values()]
        colours = [marks.TRUTH] * len(ahead)
        tape.always(f"{root}/directions", rr.Points2D(places, labels=list(ahead), colors=colours, radii=2.0))


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


FACTS, NOW = "facts", "now"

_READING = """\
**How to read it.** Solid bodies are people at their true places, each in its own colour; grey wire frames are people
without a box. Wire frames in a submission's colour are its estimates, red lines join the two, blue rings are given
positions. The map shows world (x, y) at (x, −y), since rows count downwards there. Only heights are known: widths of
bodies and boxes are made up."""


def record_words(tape: Tape, replay: Replay) -> None:
    """Record the facts, and the text of every frame."""
    rr = tape.rr
    tape.always(FACTS, rr.TextDocument(_facts(replay), media_type=rr.MediaType.MARKDOWN))
    texts = [_frame_text(replay, frame) for frame in range(replay.sequence.frames)]
    media = [str(rr.MediaType.MARKDOWN)] * len(texts)
    tape.each(NOW, rr.TextDocument, text=texts, media_type=media)


def _facts(replay: Replay) -> str:
    info, sequence = replay.info, replay.sequence
    heading, *lines = describe(info).splitlines()
    lines = [line.strip() for line in lines if not line.strip().startswith("caution: ")]
    parts = [
        f"**{heading}**",
        f"**Sequence {sequence.index}**: {sequence.frames} frames, {len(sequence.tracks)} tracks, "
        f"{_recorded_by(replay)}" + (f"; **{replay.caveat}**." if replay.caveat else "."),
        *([f"> **Caution:** {info.caution}"] if info.caution else []),
        "\n".join(f"* {line}" for line in lines),
        *(_answer_text(answer) for answer in replay.answers),
        _READING,
    ]
    return "\n\n".join(parts) + "\n"


def _recorded_by(replay: Replay) -> str:
    sequence = replay.sequence
    if replay.is_footage and sequence.scene < len(replay.info.scenes):
        return f"of recording {replay.info.scenes[sequence.scene]} from its frame {sequence.first_frame}"
    return f"observer {sequence.observer} in scene {sequence.scene}"


def _answer_text(answer: Answer) -> str:
    known = {key: values for key, values in answer.errors.items() if np.isfinite(values).any()}
    means = [f"{METRICS[key].symbol} {np.nanmean(values):.3f} {METRICS[key].unit}" for key, values in known.items()]
    figures = f" Means over the frames scored: {', '.join(means)}." if means else ""
    return f"**{answer.name}** ({answer.protocol.id}).{figures} {' '.join(answer.protocol.text.split())}"


def _frame_text(replay: Replay, frame: int) -> str:
    seen, seconds = int(replay.sequence.observed[frame].sum()), frame * replay.info.dt
    lines = [f"**Frame {frame}** of 0–{replay.sequence.frames - 1}, {seconds:.2f} s, {seen} people seen"]
    if not replay.answers:
        return "\n\n".join([*lines, f"Given (sequential): {_given_words(replay.given, frame)}"])
    answers = [
        ", ".join([f"* **{one.name}**: given {_given_words(one.given, frame)}", *one.figures(frame)])
        for one in replay.answers
    ]
    return "\n\n".join([*lines, "\n".join(answers)])


def _given_words(given: Given, frame: int) -> str:
    people = int(np.isfinite(given.positions[frame, :, 0]).sum())
    pose = ["the pose"] if np.isfinite(given.poses[frame, 0]) else []
    return " and ".join([*pose, *([f"{people} positions"] if people else [])]) or "nothing"


SUFFIX = ".rrd"
_MARGIN = 1.5  # m around everything


def record_to_file(
    dataset: Dataset,
    sequence: int,
    out: Path | str | None = None,
    *,
    submissions: Sequence[Path | str] = (),
    footage: bool = False,
) -> Path:
    """Write a sequence, and the answers of submissions to it, as a recording for the rerun viewer.

    Raises VbbenchError if rerun is not installed, there is no such sequence, a submission answers another dataset, or
    ``out`` is not an ``.rrd`` file.

    Parameters
    ----------
    dataset : the dataset; without truth, boxes, what is given and estimates are recorded.
    sequence : number of the sequence.
    out : an ``.rrd`` file; by default named after split and sequence, in the working directory.
    submissions : folders of submissions that answer the dataset.
    footage : record the pictures that the camera itself took.

    Returns
    -------
    The file.
    """
    package = rerun()
    replay = load_replay(dataset, sequence, submissions)
    path = Path(out or f"{dataset.info.split}-{sequence}{SUFFIX}")
    if path.suffix != SUFFIX or path.is_dir():
        raise FileError(path, f"a recording is a file that ends in {SUFFIX}; give it such a name")
    with replacing(path) as temporary, strictly():
        # The viewer remembers a layout for each application; that of another sequence does not fit this one.
        stream = package.RecordingStream(f"vbbench {replay.info.split} {replay.camera.kind} {sequence}")
        if not package.is_enabled(stream):
            raise VbbenchError("rerun is switched off; unset the environment variable RERUN")
        stream.save(temporary)
        stream.send_blueprint(_layout(replay), make_active=True, make_default=True)
        tape = Tape(stream, replay.sequence.frames, dataset.info.dt)
        ground = Ground(tape)
        record_words(tape, replay)
        record_world(ground, replay)
        record_boxes(tape, replay)
        for number in range(len(replay.answers)):
            record_estimate(ground, replay, number)
        if footage:
            record_footage(tape, replay)
        stream.disconnect()
    return path


def _layout(replay: Replay) -> Any:
    """The blueprint of a recording."""
    import rerun.blueprint as rrb

    world = rrb.Spatial3DView(origin=f"/{WORLD}", name="World", **_eye(rrb, replay))
    width, height = replay.camera.picture_size
    bounds = rrb.VisualBounds2D(x_range=(-0.01 * width, 1.01 * width), y_range=(-0.01 * height, 1.01 * height))
    ego = rrb.Spatial2DView(origin=f"/{ego_root(replay)}", visual_bounds=bounds, name="What the observer sees")
    wide = width > 2.5 * height
    left = rrb.Vertical(world, ego, row_shares=[3, 1] if wide else [1, 1])
    words = rrb.Horizontal(
        rrb.TextDocumentView(origin=f"/{NOW}", name="Frame"), rrb.TextDocumentView(origin=f"/{FACTS}", name="Facts")
    )
    (west, south), (east, north) = _extent(replay)
    bounds = rrb.VisualBounds2D(x_range=(west, east), y_range=(-north, -south))  # rows of the map are −y
    right = [rrb.Spatial2DView(origin=f"/{MAP}", visual_bounds=bounds, name="Map"), *_plots(rrb, replay), words]
    shares = [6, 4, 3] if len(right) == 3 else [2, 1]
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*right, row_shares=shares), column_shares=[3, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed"),
    )


def _plots(rrb: Any, replay: Replay) -> list[Any]:
    """Errors over time, where there are any: all metrics side by side, all submissions in each."""
    views: list[Any] = []
    for number, key in enumerate(next((answer.errors for answer in replay.answers if answer.errors), {})):
        top = max(float(np.nanmax(answer.errors[key], initial=0.0)) for answer in replay.answers)
        axis, legend = rrb.ScalarAxis(range=(0.0, 1.05 * top or 1.0)), rrb.PlotLegend(visible=number == 0)
        options = {"origin": f"/{ERRORS}/{key}", "name": METRICS[key].label}
        views.append(rrb.TimeSeriesView(**options, axis_y=axis, plot_legend=legend))
    return [rrb.Grid(*views, grid_columns=2)] if views else []


def _eye(rrb: Any, replay: Replay) -> dict[str, Any]:
    """Look at the middle of the scene from behind the observer's start, if this rerun has the option."""
    if not hasattr(rrb, "EyeControls3D"):
        return {}
    low, high = _extent(replay)
    middle, reach = 0.5 * (low + high), 0.5 * float(np.hypot(*(high - low)))
    yaw = float(np.nan_to_num(replay.viewpoints[0, 2]))
    back = middle - 1.2 * reach * np.array([np.cos(yaw), np.sin(yaw)])
    eye = rrb.EyeControls3D(position=(*back, 0.9 * reach), look_target=(*middle, 0.0), eye_up=(0.0, 0.0, 1.0))
    return {"eye_controls": eye}


def _extent(replay: Replay) -> tuple[FloatArray, FloatArray]:
    """Lower and upper corner [2] in m of everything on the ground, with a margin, ignoring wild estimates."""
    sequence, whole = replay.sequence, replay.poses_known and replay.places_known
    guesses = [] if whole else [answer.estimate for answer in replay.answers]
    sources = [replay.truth or sequence.given, *guesses]
    places = [one.positions[sequence.observed] for one in sources] + [one.poses[:, :2] for one in sources]
    low, high = np.nanpercentile(np.concatenate(places), (1.0, 99.0) if guesses else (0.0, 100.0), axis=0)
    return low - _MARGIN, high + _MARGIN
