"""Writes the recording of a sequence, whole or not at all, and the layout in which the viewer opens it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.boxes import rectangles, with_seam_copies
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import describe
from vbbench.folders.replacing import replacing
from vbbench.geometry import FloatArray, IntArray
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of, silent
from vbbench.pictures.replay import Answer, Replay, load_replay
from vbbench.pictures.viewer import marks
from vbbench.pictures.viewer.marks import MAP, WORLD, Ground, Tape, rerun, strictly
from vbbench.pictures.viewer.world import CAMERA, ERRORS, record_estimate, record_world
from vbbench.scoring.metrics import METRICS
from vbbench.sequence import NOBODY, Given

QUALITY = 90
"""Of the JPEG pictures, in percent."""
CENTIMETRES = 100.0
"""Units of the depth pictures in a metre; 16 bits reach 655 m."""
_HORIZON_POINTS = 181


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


def record_pictures(tape: Tape, replay: Replay, backend: Backend, announce: Callable[[str], object]) -> None:
    """Record rendered pictures, one per frame; the pixels of people have the colours of their boxes."""
    rr, root, tracks = tape.rr, ego_root(replay), replay.sequence.tracks
    scene, frames = scene_of(replay.dataset, replay.sequence.scene), replay.sequence.frames
    looks = zip(tracks.astype(str), marks.people_colours(replay).tolist(), strict=True)
    classes = [("nobody", (0, 0, 0, 0)), *looks, ("no box", marks.UNSEEN)]
    tape.always(root, rr.AnnotationContext([(number, *look) for number, look in enumerate(classes)]))
    class_of = _classes(replay, scene.people)
    with open_renderer(backend, scene, announce) as renderer, progress_bar(frames, "frames", unit="frame") as bar:
        for frame, picture in enumerate(pictures(replay.dataset, replay.sequence, renderer)):
            centimetres = np.where(np.isfinite(picture.depth), picture.depth * CENTIMETRES, 0.0).clip(0, 65535)
            ids = np.where(picture.ids == NOBODY, 0, class_of[frame, np.searchsorted(scene.people, picture.ids)])
            tape.now(frame, f"{root}/picture", rr.Image(picture.rgb).compress(jpeg_quality=QUALITY))
            tape.now(frame, f"{root}/depth", rr.DepthImage(centimetres.astype(np.uint16), meter=CENTIMETRES))
            tape.now(frame, f"{root}/ids", rr.SegmentationImage(ids.astype(np.uint16)))
            bar.update()


def _classes(replay: Replay, people: IntArray) -> IntArray:
    """[T, N] the class of a person's pixels: the number, from 1, of the track whose box shows them, else a last one."""
    sequence, persons = replay.sequence, replay.dataset.track_persons(replay.sequence)
    classes = np.full((sequence.frames, len(people)), len(sequence.tracks) + 1)
    frame, track = np.nonzero(sequence.observed & (persons != NOBODY))
    classes[frame, np.searchsorted(people, persons[frame, track])] = track + 1
    return classes


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
_PICTURES = {"picture": "What the observer sees", "depth": "Depth", "ids": "Ids"}


def record_to_file(
    dataset: Dataset,
    sequence: int,
    out: Path | str | None = None,
    *,
    submissions: Sequence[Path | str] = (),
    backend: Backend | None = None,
    footage: bool = False,
    announce: Callable[[str], object] = silent,
) -> Path:
    """Write a sequence, and the answers of submissions to it, as a recording for the rerun viewer.

    Raises VbbenchError if rerun is not installed, there is no such sequence or backend, a submission answers another
    dataset, a renderer lacks truth or is named with ``footage``, or ``out`` is not an ``.rrd`` file.

    Parameters
    ----------
    dataset : the dataset; without truth, boxes, what is given and estimates are recorded.
    sequence : number of the sequence.
    out : an ``.rrd`` file; by default named after split and sequence, in the working directory.
    submissions : folders of submissions that answer the dataset.
    backend : renders the picture, depth and ids of every frame; ``None`` for boxes only.
    footage : record the pictures that the camera itself took, instead of a renderer's.
    announce : called once with a line that names the renderer.

    Returns
    -------
    The file.
    """
    package = rerun()
    if footage and backend is not None:
        raise VbbenchError("a recording shows the pictures of a renderer or of the footage; ask for one of them")
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
        stream.send_blueprint(_layout(replay, pictures=backend is not None), make_active=True, make_default=True)
        tape = Tape(stream, replay.sequence.frames, dataset.info.dt)
        ground = Ground(tape)
        record_words(tape, replay)
        record_world(ground, replay)
        record_boxes(tape, replay)
        for number in range(len(replay.answers)):
            record_estimate(ground, replay, number)
        if footage:
            record_footage(tape, replay)
        elif backend is not None:
            record_pictures(tape, replay, backend, announce)
        stream.disconnect()
    return path


def _layout(replay: Replay, *, pictures: bool) -> Any:
    """The blueprint of a recording; ``pictures`` says whether there are rendered ones."""
    import rerun.blueprint as rrb

    root = ego_root(replay)
    hidden = [f"- /{root}/{name}" for name in ("depth", "ids")]
    world = rrb.Spatial3DView(origin=f"/{WORLD}", contents=["$origin/**", *hidden], name="World", **_eye(rrb, replay))
    views = [_ego_view(rrb, replay, name) for name in (_PICTURES if pictures else ["picture"])]
    ego = rrb.Tabs(*views, active_tab=0) if len(views) > 1 else views[0]
    wide = replay.camera.picture_size[0] > 2.5 * replay.camera.picture_size[1]
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


def _ego_view(rrb: Any, replay: Replay, shown: str) -> Any:
    root = ego_root(replay)
    hidden = [f"- $origin/{name}" for name in _PICTURES if name != shown]
    width, height = replay.camera.picture_size
    bounds = rrb.VisualBounds2D(x_range=(-0.01 * width, 1.01 * width), y_range=(-0.01 * height, 1.01 * height))
    contents = ["$origin/**", *hidden]
    return rrb.Spatial2DView(origin=f"/{root}", contents=contents, visual_bounds=bounds, name=_PICTURES[shown])


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
