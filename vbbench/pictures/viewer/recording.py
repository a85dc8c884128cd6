"""Writes the recording of a sequence, whole or not at all, and the layout in which the viewer opens it."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.replacing import replacing
from vbbench.geometry import FloatArray
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of, silent
from vbbench.pictures.replay import Replay, load_replay
from vbbench.pictures.viewer.ego import ego_root, record_boxes, record_footage, record_pictures
from vbbench.pictures.viewer.marks import MAP, WORLD, Ground, Tape
from vbbench.pictures.viewer.rerun_sdk import rerun, strictly
from vbbench.pictures.viewer.words import FACTS, NOW, record_words
from vbbench.pictures.viewer.world import ERRORS, record_estimate, record_world
from vbbench.scoring.metrics import METRICS

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

    Raises
    ------
    VbbenchError
        If rerun is not installed, there is no such sequence or backend, a submission answers another dataset,
        a renderer lacks truth or is named with ``footage``, or ``out`` is not an ``.rrd`` file.
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
        _record(tape, replay)
        if footage:
            _show_footage(tape, replay)
        elif backend is not None:
            _render(tape, replay, backend, announce)
        stream.disconnect()
    return path


def _record(tape: Tape, replay: Replay) -> None:
    ground = Ground(tape)
    record_words(tape, replay)
    record_world(ground, replay)
    record_boxes(tape, replay)
    for number in range(len(replay.answers)):
        record_estimate(ground, replay, number)


def _show_footage(tape: Tape, replay: Replay) -> None:
    backdrop = Backdrop(replay.dataset, replay.sequence)
    if backdrop.is_recorded:
        with progress_bar(replay.sequence.frames, "frames", unit="frame") as bar:
            record_footage(tape, replay, backdrop, bar.update)


def _render(tape: Tape, replay: Replay, backend: Backend, announce: Callable[[str], object]) -> None:
    scene, frames = scene_of(replay.dataset, replay.sequence.scene), replay.sequence.frames
    with open_renderer(backend, scene, announce) as renderer, progress_bar(frames, "frames", unit="frame") as bar:

        def shown() -> Any:
            for picture in pictures(replay.dataset, replay.sequence, renderer):
                yield picture
                bar.update()

        record_pictures(tape, replay, scene.people, shown())


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
