"""What the pictures show: boxes, positions, labels and words, read from the artists and not from pixels."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.text import Text
from scipy.optimize import isotonic_regression

from tests.lib.answers import submit, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.geometry import relative_to_world
from vbbench.pictures.colours import solver_colour
from vbbench.pictures.plotting import ego, plot_sequence, plot_to_file, style
from vbbench.pictures.plotting.style import free_offsets, save_picture, spread, text_extent
from vbbench.scoring import score
from vbbench.sequence import Given, Sequence, Truth
from vbbench.solver import Estimate

FRAMES, FOCUS = 9, 4
RELATIVE = np.array([[0.0, 3.0], [2.0, 4.0], [0.01, -5.0], [-3.0, 1.0]])
"""(right, forward): ahead, ahead right, behind across the seam, left."""
TRACKS = np.array([3, 14, 15, 92])


@dataclass
class Stub:
    """A dataset of one sequence in memory."""

    info: DatasetInfo
    held: Sequence
    real: Truth | None

    @property
    def has_truth(self) -> bool:
        return self.real is not None

    def sequence(self, index: int) -> Sequence:
        return self.held

    def camera(self, sequence: Sequence) -> Camera:
        return self.info.camera

    def truth(self, sequence: Sequence) -> Truth | None:
        return self.real


def make(camera: Camera, *, truth: bool = True, caution: str | None = None) -> Any:
    poses = np.column_stack([np.linspace(0, 3, FRAMES), np.zeros(FRAMES), np.full(FRAMES, 0.3)])
    relative = np.tile(RELATIVE, (FRAMES, 1, 1))
    boxes = camera.project(relative, np.full(relative.shape[:2], 1.7))
    positions = relative_to_world(relative, poses)
    early = np.arange(FRAMES)[:, None] < 2
    seen = ~np.isnan(boxes[..., 2])
    shown = np.where((early & seen)[..., None], positions, np.nan)
    sequence = Sequence(
        index=0,
        scene=0,
        observer=1,
        first_frame=0,
        tracks=TRACKS,
        observations=boxes,
        visible=np.where(seen, 1.0, np.nan),
        given=Given(poses=np.where(early, poses, np.nan), positions=shown),
    )
    info = DatasetInfo(
        split="tiny", title="Tiny", camera=camera, tier="ideal", seed=0, dt=0.4, height_mean=1.7, height_std=0.0,
        pixel_std=0.0, scenes=("s",), definition={}, caution=caution,
    )  # fmt: skip
    real = Truth(poses=poses, positions=positions, heights=np.full(4, 1.7)) if truth else None
    return Stub(info, sequence, real)


def shifted(stub: Any, by: float = 0.5) -> Estimate:
    """Everything too far east."""
    real = stub.real or make(stub.info.camera).real
    east = np.array([by, 0.0])
    return Estimate(poses=real.poses + np.array([by, 0.0, 0.1]), positions=real.positions + east)


def part(figure: Figure, name: str) -> Any:
    return next(axes for axes in figure.axes if axes.get_label() == name)


def drawn(axes: Any, gid: str) -> Any:
    return next(artist for artist in axes.get_children() if artist.get_gid() == gid)


def gids(axes: Any) -> list[str]:
    return [artist.get_gid() for artist in axes.get_children() if artist.get_gid()]


def boxes(figure: Figure) -> list[str]:
    return sorted(gid for gid in gids(part(figure, "ego")) if gid.startswith("box-"))


def points(figure: Figure, gid: str) -> np.ndarray:
    return np.asarray(drawn(part(figure, "bird"), gid).get_offsets().filled(np.nan))


def words(figure: Figure) -> str:
    legend = [text.get_text() for text in part(figure, "legend").get_legend().get_texts()]
    facts = [text.get_text() for text in part(figure, "facts").texts]
    return "\n".join([*(text.get_text() for text in figure.texts), *legend, *facts])


def test_a_box_across_the_seam_of_a_whole_panorama_is_drawn_at_both_ends(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(ego, "_MOST", 0.0)
    figure = plot_sequence(make(PanoramaCamera()), 0, frame=FOCUS)
    assert boxes(figure) == ["box-14", "box-15", "box-15", "box-3", "box-92"]
    left, right = sorted(
        patch.get_x() + patch.get_width() / 2 for patch in part(figure, "ego").patches if patch.get_gid() == "box-15"
    )
    assert right - left == pytest.approx(PanoramaCamera().width)


def test_a_perspective_image_holds_whom_the_camera_sees():
    figure = plot_sequence(make(PerspectiveCamera()), 0, frame=FOCUS)
    assert boxes(figure) == ["box-14", "box-3"]
    assert "field-of-view" in gids(part(figure, "bird"))
    assert len(points(figure, "truth")) == 2
    assert len(points(figure, "unseen")) == 2
    assert "there, but not observed now" in words(figure)


def test_every_box_has_its_id_and_the_colour_of_its_distance_in_both_views():
    figure = plot_sequence(make(PanoramaCamera()), 0, frame=FOCUS)
    for name in ("ego", "bird"):
        assert sorted(t.get_text() for t in part(figure, name).texts if t.get_gid()) == ["14", "15", "3", "92"]
    people = drawn(part(figure, "bird"), "truth")
    edges = {patch.get_gid(): patch.get_edgecolor() for patch in part(figure, "ego").patches}
    for track, colour in zip(TRACKS, people.get_facecolors(), strict=True):
        np.testing.assert_allclose(edges[f"box-{track}"], colour)


def test_in_a_large_crowd_only_the_nearest_bear_their_ids(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(style, "MOST_LABELS", 2)
    figure = plot_sequence(make(PanoramaCamera()), 0, frame=FOCUS)
    for name in ("ego", "bird"):
        assert {t.get_text() for t in part(figure, name).texts if t.get_gid()} == {"3", "92"}
    assert "ids of the nearest 2" in words(figure)


@pytest.mark.parametrize("camera", [PanoramaCamera(), PerspectiveCamera()], ids=lambda c: c.kind)
def test_truth_estimate_and_error_lines(camera):
    stub = make(camera)
    figure = plot_sequence(stub, 0, shifted(stub), frame=FOCUS, solver="vb-cv", protocol="rollout")
    np.testing.assert_allclose(points(figure, "estimate"), points(figure, "truth") + np.array([0.5, 0.0]))
    assert len(drawn(part(figure, "bird"), "errors").get_segments()) == len(points(figure, "truth"))
    assert {"observer-truth", "observer-estimate"} <= set(gids(part(figure, "bird")))
    assert "error, truth to estimate" in words(figure)
    assert "vb-cv (rollout)" in words(figure)


def test_the_title_states_what_is_shown_and_the_errors_of_the_frame():
    stub = make(PanoramaCamera())
    text = words(plot_sequence(stub, 0, shifted(stub), frame=FOCUS))
    for fact in ("tiny", "sequence 0", f"frame {FOCUS} (0–{FRAMES - 1})", "panorama", "ideal"):
        assert fact in text
    for error in ("Δx = 0.500 m", "Δx̃ = 0.000 m", "Δr = 0.100 rad", "Δt = 0.500 m"):
        assert error in text


def test_without_truth_the_given_and_the_estimate_are_drawn():
    stub = make(PanoramaCamera(), truth=False)
    figure = plot_sequence(stub, 0, shifted(stub))
    assert len(points(figure, "estimate")) == 4
    assert np.isfinite(points(figure, "given")).all(axis=1).sum() == 2 * 4 + 2
    assert "observer-truth" not in gids(part(figure, "bird"))
    assert "no truth available" in words(figure)


@pytest.mark.parametrize("camera", [PanoramaCamera(), PerspectiveCamera()], ids=lambda c: c.kind)
def test_with_nothing_but_what_is_given_its_last_frame_is_drawn(camera):
    figure = plot_sequence(make(camera, truth=False), 0)
    assert "frame 1 (0" in words(figure)
    assert np.isfinite(points(figure, "truth")).all()


def test_false_alarms_gaps_in_an_estimate_and_frames_of_nobody_are_drawn_around():
    stub = make(PanoramaCamera())
    positions = stub.real.positions.copy()
    positions[:, 1] = np.nan
    stub = replace(stub, real=replace(stub.real, positions=positions))
    assert len(boxes(plot_sequence(stub, 0, shifted(stub), frame=FOCUS))) == 4
    blank = Estimate(poses=np.full((FRAMES, 3), np.nan), positions=np.full((FRAMES, 4, 2), np.nan))
    assert "Δ" not in words(plot_sequence(stub, 0, blank, frame=FOCUS))
    nobody = replace(stub.held, observations=np.full((FRAMES, 4, 3), np.nan), visible=np.full((FRAMES, 4), np.nan))
    figure = plot_sequence(replace(stub, held=nobody), 0, shifted(stub))
    assert boxes(figure) == []
    assert "0 people seen" in words(figure)


def test_what_does_not_fit_is_refused(tmp_path: Path):
    stub = make(PanoramaCamera())
    other = Estimate(poses=np.zeros((3, 3)), positions=np.zeros((3, 4, 2)))
    with pytest.raises(VbbenchError, match=r"\[3, 4, 2\].*\[9, 4, 2\]"):
        plot_sequence(stub, 0, other)
    for frame in (-1, FRAMES):
        with pytest.raises(VbbenchError, match=f"frames 0 to {FRAMES - 1}, not {frame}"):
            plot_sequence(stub, 0, frame=frame)
    with pytest.raises(FileError, match="PNG, PDF or SVG"):
        save_picture(Figure(), tmp_path / "a.jpg")


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("plot") / "dataset"
    write_dataset(folder, Crowd(scenes=1))
    return Dataset(folder)


CAUTION = "made up for tests. " + "Every word of this must be readable on the picture, however long it is. " * 6


def test_several_answers_and_one_with_faults_in_one_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    shown: list[Figure] = []
    monkeypatch.setattr("vbbench.pictures.plotting.save_picture", lambda drawing, _: shown.append(drawing))
    data, number = tmp_path / "data", 3
    write_dataset(data, Crowd(scenes=3, frames=40, people=8, stay=(8, 20), caution=CAUTION))
    noise = {"good": ("vb-cv", 0.1), "bad": ("cv", 0.6), "again": ("cv", 0.3)}
    answers = [submit(tmp_path / name, data, true_answers(data, m), solver=who) for name, (who, m) in noise.items()]
    poses, positions = true_answers(data, 0.2)
    careless = submit(tmp_path / "careless", data, (poses[poses["frame"] != 4], positions), solver="careless")
    plot_to_file(Dataset(data), number, "x.png", submissions=[*answers, careless])
    (drawing,) = shown
    parts = {axes.get_label(): axes for axes in drawing.axes}
    own = score(answers[0], data).per_sequence
    assert drawn(parts["table"], "cell-1-5").get_text() == f"{own.figures['dt'][own.sequence == number][0]:.3f}"
    truth = Dataset(data).truth(Dataset(data).sequence(number))
    np.testing.assert_allclose(drawn(parts["map-0"], "true-path").get_xdata(), truth.poses[:, 0])
    first, second = (drawn(parts["map-0"], f"path-cv ({name})") for name in ("bad", "again"))
    assert to_hex(first.get_color()) == to_hex(second.get_color()) == solver_colour("cv")
    assert first.get_linestyle() != second.get_linestyle()
    words = " ".join(text.get_text() for text in drawing.findobj(Text))
    assert "careless (careless) is not scored: poses.parquet" in words
    assert " ".join(CAUTION.split()) in " ".join(words.split())
    lines = [text.get_window_extent() for text in drawing.texts if (text.get_gid() or "").startswith("caution-")]
    assert all(box.x0 >= 0 and box.x1 <= drawing.bbox.width and box.y0 >= 0 for box in lines)


@pytest.mark.parametrize(("ending", "begin"), [("png", b"\x89PNG\r\n\x1a\n"), ("pdf", b"%PDF-"), ("svg", b"<?xml")])
def test_formats_by_ending_have_the_same_bytes_each_time(dataset: Dataset, tmp_path: Path, ending: str, begin: bytes):
    answer = submit(tmp_path / "answer", dataset.folder, true_answers(dataset.folder), protocol="rollout")
    first, second = (
        plot_to_file(dataset, 0, tmp_path / f"new/{n}.{ending}", submissions=[answer], frame=2) for n in (1, 2)
    )
    assert sorted(first.parent.iterdir()) == [first, second]
    assert first.read_bytes() == second.read_bytes()
    assert first.read_bytes().startswith(begin)
    if ending == "pdf":
        assert b"/FontFile2" in first.read_bytes()
        assert b"CreationDate" not in first.read_bytes()
    if ending == "svg":
        assert ">x (m)</text>" in first.read_text("utf-8")
        assert "<dc:date>" not in first.read_text("utf-8")


@given(st.lists(st.floats(-100.0, 100.0), min_size=1, max_size=30).map(np.array))
def test_spread_labels_are_the_nearest_that_keep_their_distance(wanted):
    gap = 3.0
    ramp = gap * np.arange(len(wanted))
    nearest = isotonic_regression(np.sort(wanted) - ramp).x + ramp
    np.testing.assert_allclose(np.sort(spread(wanted, gap, -1e4, 1e4)), nearest, atol=1e-9)


@given(st.lists(st.floats(0, 100), max_size=30), st.floats(0.1, 10))
def test_spread_labels_keep_their_order_their_distance_and_the_frame(wanted, gap):
    wanted = np.array(wanted)
    places = spread(wanted, gap, 0.0, 100.0)
    ordered = places[np.argsort(wanted, kind="stable")]
    fits = gap if len(wanted) < 2 else min(gap, 100.0 / (len(wanted) - 1))
    assert np.all(np.diff(ordered) > fits - 1e-9)
    assert np.all((places > -1e-9) & (places < 100.0 + 1e-9))


def test_labels_on_the_map_do_not_overlap():
    places = np.random.default_rng(0).uniform(0, 200, (60, 2))
    extents = text_extent(["123"] * 60, 6.5)
    offsets = free_offsets(places, extents, places, 3.0)
    placed = np.isfinite(offsets[:, 0])
    assert placed.sum() > 30
    centres = (places + offsets)[placed]
    apart = np.abs(centres[:, None] - centres) >= extents[0] - 1e-9
    assert np.all(apart.any(axis=-1) | np.eye(len(centres), dtype=bool))
