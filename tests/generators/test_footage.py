"""Footage: recordings of real cameras as datasets, whatever is known of their truth."""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from tests.pictures.plotting.test_plotting import gids, part, points, words
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import Pictures
from vbbench.files.verification import verify
from vbbench.generation.datasets import write_dataset
from vbbench.generation.footage import Footage, FootageOptions, joined_odometry
from vbbench.generation.generator import Card, Options
from vbbench.geometry import relative_to_world, world_to_relative
from vbbench.pictures.backdrop import GROUND, SKY, Backdrop
from vbbench.pictures.film.frames import TITLE_HEIGHT, Film
from vbbench.pictures.plotting.figure import plot_replay
from vbbench.pictures.rendering import Backend, render_to_file
from vbbench.pictures.replay import Replay, load_replay
from vbbench.scene import Scene
from vbbench.scoring import score
from vbbench.sequence import NOBODY, Odometry
from vbbench.solving import solve
from vbbench_generators.footage.argoverse2 import argoverse2
from vbbench_generators.footage.jrdb.split import jrdb
from vbbench_generators.footage.kitti.split import kitti
from vbbench_generators.footage.motsynth import motsynth
from vbbench_generators.footage.nuscenes import nuscenes
from vbbench_generators.footage.own import own
from vbbench_generators.footage.split import FootageSplit, Recordings

CARD = Card(name="walk", title="A walk", licence="CC0", citation="-", sources=())
FRAMES, PEOPLE = 30, 5


def recording(name: str = "one", mount_height: float = 1.5, **changes: Any) -> Footage:
    """Somebody walks forward among people who cross, and one track without a person."""
    rng, time = np.random.default_rng(len(name)), 0.4 * np.arange(FRAMES)
    camera = PerspectiveCamera(mount_height=mount_height)
    poses = np.stack([0.5 * time, 0.1 * time, 0.02 * time], axis=-1)
    start = rng.uniform([8.0, -4.0], [14.0, 4.0], (PEOPLE, 2))
    people = start + time[:, None, None] * rng.normal(0.0, 0.3, (PEOPLE, 2))
    heights = rng.normal(1.72, 0.05, PEOPLE)
    boxes = camera.project(world_to_relative(people, poses), np.broadcast_to(heights, people.shape[:2]))
    boxes[:4, 0] = np.nan
    boxes = np.concatenate([boxes, boxes[:, -1:] + 30.0], axis=1)
    persons = np.where(np.isnan(boxes[..., 2]), NOBODY, np.append(np.arange(PEOPLE), NOBODY) * 10)
    persons[:, -1] = NOBODY
    facts: dict[str, Any] = {
        "poses": poses,
        "scene": Scene(name=name, dt=0.4, people=10 * np.arange(PEOPLE), positions=people, heights=heights),
        "persons": persons,
    }
    return Footage(
        name=name,
        camera=camera,
        dt=0.4,
        tracks=np.arange(PEOPLE + 1),
        boxes=boxes,
        visible=np.where(np.isnan(boxes[..., 2]), np.nan, 1.0),
        **{**facts, **changes},
    )


def relative(one: Footage) -> Footage:
    """The same where only the places from the camera are known."""
    assert one.scene is not None
    assert one.poses is not None
    scene = replace(one.scene, positions=world_to_relative(one.scene.positions, one.poses))
    return replace(one, poses=None, scene=scene)


@dataclass(frozen=True, kw_only=True)
class Walk(FootageSplit):
    """Recordings of the tests."""

    card: Card = CARD
    found: tuple[Footage, ...] = ()

    def recordings(self, options: Options) -> Recordings:
        """They are made here."""
        return Recordings(footage=self.found, definition={})


def made(folder: Any, *found: Footage, **options: Any) -> Dataset:
    return write_dataset(Walk(found=found).plan(Options(**options)), folder)


def test_cameras_may_differ_from_sequence_to_sequence(tmp_path):
    dataset = made(tmp_path / "d", recording("one", 1.5), recording("two", 1.2))
    assert [camera.mount_height for camera in dataset.info.cameras] == [1.5, 1.2]
    assert [dataset.camera(sequence).mount_height for sequence in dataset.sequences()] == [1.5, 1.2]
    assert [dataset.problem(sequence).camera.mount_height for sequence in dataset.sequences()] == [1.5, 1.2]
    assert "are as written" in verify(tmp_path / "d")
    for sequence in dataset.sequences():
        truth = dataset.truth(sequence)
        nobody = (dataset.track_persons(sequence) == NOBODY).all(axis=0)
        assert nobody.sum() == 1
        assert np.isnan(truth.positions[:, nobody]).all()
        assert sequence.observed[:, nobody].any()
        heights = truth.heights[~nobody]
        again = dataset.camera(sequence).project(
            world_to_relative(truth.positions[:, ~nobody], truth.poses),
            np.broadcast_to(heights, truth.positions.shape[:1] + heights.shape),
        )
        seen = sequence.observed[:, ~nobody]
        np.testing.assert_allclose(again[seen], sequence.observations[:, ~nobody][seen])


def test_whole_footage_is_solved_and_scored_like_any_dataset(tmp_path):
    dataset = made(tmp_path / "d", recording())
    for protocol in ("one-step", "sequential", "rollout"):
        figures = score(solve(dataset, "cv", protocol, tmp_path / protocol), tmp_path / "d").values()["metrics"]
        assert figures["dx"]["mean"] < 1.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("known", "changes", "missing"),
    [
        ("poses", {"scene": None, "persons": None}, {"dx", "dx_rel"}),
        ("none", {"scene": None, "persons": None, "poses": None}, {"dx", "dx_rel", "dr", "dt"}),
        ("relative", None, {"dx", "dr", "dt"}),
    ],
)
def test_what_is_not_known_is_not_scored_and_said(tmp_path, known, changes, missing):
    one = relative(recording()) if changes is None else recording(**changes)
    dataset = made(tmp_path / "d", one)
    assert (dataset.info.truth, Dataset(tmp_path / "d").info.id) == (known, dataset.info.id)
    verify(tmp_path / "d")
    with pytest.raises(VbbenchError, match="use cold-start"):
        solve(dataset, "cv", "sequential", tmp_path / "no")
    answer = solve(dataset, f"{__name__}:Still", "cold-start", tmp_path / "a")
    if known == "none":
        with pytest.raises(VbbenchError, match="has no true poses"):
            score(answer, tmp_path / "d")
        return
    result = score(answer, tmp_path / "d")
    assert {name for name, figure in result.values()["metrics"].items() if figure["mean"] is None} == missing
    assert "not known" in result.table()
    assert result.values()["truth"] == known
    assert (
        "not known"
        not in score(solve(made(tmp_path / "w", recording()), "cv", "rollout", tmp_path / "b"), tmp_path / "w").table()
    )


def test_relative_errors_without_poses_are_those_with_them_up_to_the_turn(tmp_path):
    whole = recording(poses=np.zeros((FRAMES, 3)))
    answers = []
    for name, one in (("whole", whole), ("relative", relative(whole))):
        dataset = made(tmp_path / name, one)
        answers.append(
            score(solve(dataset, f"{__name__}:Still", "cold-start", tmp_path / f"{name}-a"), tmp_path / name)
        )
    np.testing.assert_allclose(answers[0].summaries["dx_rel"].mean, answers[1].summaries["dx_rel"].mean)
    assert answers[0].summaries["dx_rel"].mean > 0.01


class Still:
    """Stands where it was first and places people where their boxes are at the mean height."""

    def start(self, problem: Any) -> None:
        self.problem = problem

    def step(self, frame: Any) -> Any:
        from vbbench.estimate import FrameEstimate

        self.start_pose = frame.given.poses[2] if frame.index == 0 else self.start_pose
        pose = np.array(self.start_pose)
        heights = np.full(len(frame.observations), self.problem.height_mean)
        places = relative_to_world(self.problem.camera.unproject(frame.observations, heights), pose)
        return FrameEstimate(pose=pose, positions=places)


@pytest.mark.slow
def test_odometry_reaches_solvers_frame_by_frame(tmp_path):
    motions = np.full((FRAMES, 3), np.nan)
    motions[1:] = np.arange(3 * (FRAMES - 1)).reshape(-1, 3)
    covariances = np.einsum("t,ij->tij", np.arange(FRAMES), np.array([[3.0, 1, 0.5], [1, 2, 0.25], [0.5, 0.25, 1]]))
    dataset = made(tmp_path / "d", recording(odometry=Odometry(motions=motions, covariances=covariances)))
    (sequence,) = dataset.sequences()
    odometry = sequence.given.odometry
    assert odometry is not None
    first = int(FRAMES - sequence.frames)
    np.testing.assert_array_equal(odometry.motions, motions[first:])
    np.testing.assert_array_equal(odometry.covariances[1:], covariances[first + 1 :])
    for isolate in (False, True):
        solve(dataset, f"{__name__}:Watcher", "cold-start", tmp_path / f"a{isolate}", isolate=isolate)


class Watcher(Still):
    """Checks that odometry of frame t is shown at t, and never before."""

    def step(self, frame: Any) -> Any:
        forward = frame.given.odometry.motions[:, 0]
        expected = np.array([3.0 * (t - 1) if t > 0 else np.nan for t in range(frame.index - 2, frame.index + 1)])
        np.testing.assert_array_equal(forward, expected)
        return super().step(frame)


def test_thinned_odometry_is_the_motion_between_the_kept_frames():
    rng = np.random.default_rng(0)
    motions = rng.normal(0.0, 0.3, (9, 3))
    poses = np.zeros((9, 3))
    for t in range(1, 9):
        poses[t, :2] = relative_to_world(np.array([[-motions[t, 1], motions[t, 0]]]), poses[t - 1])[0]
        poses[t, 2] = poses[t - 1, 2] + motions[t, 2]
    joined = joined_odometry(Odometry(motions=motions, covariances=np.tile(np.diag([0.01, 0.02, 1e-3]), (9, 1, 1))), 4)
    assert np.isnan(joined.motions[0]).all()
    for row in (1, 2):
        ((right, forward),) = world_to_relative(poses[4 * row, :2][None], poses[4 * (row - 1)])
        np.testing.assert_allclose(joined.motions[row], [forward, -right, poses[4 * row, 2] - poses[4 * row - 4, 2]])
    drawn = np.array(
        [_chain(motions[1:5] + rng.normal(0.0, 1.0, (4, 3)) * np.sqrt([0.01, 0.02, 1e-3])) for _ in range(20000)]
    )
    np.testing.assert_allclose(np.cov(drawn.T), joined.covariances[1], rtol=0.1, atol=0.002)


def _chain(motions: Any) -> Any:
    total = np.zeros(3)
    for forward, left, turn in motions:
        cos, sin = np.cos(total[2]), np.sin(total[2])
        total = total + np.array([cos * forward - sin * left, sin * forward + cos * left, turn])
    return total


def test_every_nth_frame_keeps_pictures_and_people_in_step(tmp_path):
    one = recording(pictures=Pictures(pattern="/films/{:04d}.png", first=7, step=1))
    dataset = made(tmp_path / "d", one, footage=FootageOptions(every=3))
    assert (dataset.info.dt, len(dataset.sequence(0).observations)) == (pytest.approx(1.2), FRAMES // 3)
    pictures = Dataset(tmp_path / "d").info.pictures[0]
    assert pictures is not None
    assert str(pictures.path(2)) == "/films/0013.png"
    assert one.poses is not None
    poses = dataset.world(dataset.sequence(0)).poses(one.poses[::3])
    np.testing.assert_array_equal(dataset.truth(dataset.sequence(0)).poses, poses)


SPLITS = {
    "own": own,
    "kitti": kitti,
    "jrdb": jrdb,
    "motsynth": motsynth,
    "argoverse2": argoverse2,
    "nuscenes": nuscenes,
}


@pytest.mark.parametrize(
    ("split", "name", "value"),
    [
        ("own", "cyclists", True),
        ("kitti", "cameras", ("panorama",)),
        ("jrdb", "poses", Path("p")),
        ("motsynth", "bags", Path("g")),
        ("argoverse2", "interpolated", False),
        ("nuscenes", "cyclists", True),
    ],
)
def test_an_option_that_a_split_does_not_read_is_refused(tmp_path, split, name, value):
    asked = Options(source=tmp_path, footage=FootageOptions(**{name: value}))
    with pytest.raises(
        VbbenchError, match=f"^{split} is footage and does not read `{name}`; it reads `seed`, .* and `"
    ):
        SPLITS[split].plan(asked)


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--tier", "noisy"], "--tier"),
        (["--sigma-h", "0.2"], "--sigma-h"),
        (["--no-interpolated"], "--interpolated"),
        (["--options", "detector=false"], "--detector"),
        (["--scenario", "plaza"], "--scenario or --people"),
    ],
)
def test_the_command_says_so_in_one_line(tmp_path, capsys, option, said):
    command = ["generate", "own", "--source", str(tmp_path), *option, "--out", str(tmp_path / "d")]
    assert main(command) == 2
    read = "--seed, --limit, --source, --dt, --sequences, --every, --longest, --poses, --boxes and --person-class"
    assert capsys.readouterr().err == f"vbbench: own is footage and does not read {said}; it reads {read}\n"


def test_footage_without_enough_people_in_a_row_is_refused(tmp_path):
    empty = replace(
        recording(), boxes=np.full((FRAMES, PEOPLE + 1, 3), np.nan), visible=np.full((FRAMES, PEOPLE + 1), np.nan)
    )
    with pytest.raises(VbbenchError, match="walk: nowhere are there 5 frames in a row, 1 apart, with 3 people"):
        made(tmp_path / "d", empty)


KINDS = ("whole", "poses", "relative", "none")


class Walker(Still):
    """Says that it walks along the diagonal and turns, which is wrong, and places people by their boxes."""

    def step(self, frame: Any) -> Any:
        answer = super().step(frame)
        pose = np.array([0.1 * frame.index, 0.2 * frame.index, 0.05 * frame.index])
        from vbbench.geometry import relative_to_world

        heights = np.full(len(frame.observations), self.problem.height_mean)
        places = relative_to_world(self.problem.camera.unproject(frame.observations, heights), pose)
        return replace(answer, pose=pose, positions=places)


def known_as(kind: str, **changes: Any) -> Footage:
    """The recording of the tests, with less known of it."""
    whole = recording(**changes)
    if kind == "relative":
        return relative(whole)
    less = {"whole": {}, "poses": {"scene": None, "persons": None}}
    return replace(whole, **less.get(kind, {"scene": None, "persons": None, "poses": None}))


@pytest.fixture(scope="module")
def datasets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Dataset]:
    folder = tmp_path_factory.mktemp("footage")
    return {kind: made(folder / kind, known_as(kind)) for kind in KINDS}


@pytest.fixture(scope="module")
def answers(datasets: dict[str, Dataset]) -> dict[str, Path]:
    return {
        kind: solve(one, f"{__name__}:Walker", "cold-start", one.folder.with_name(f"{kind}-answer"))
        for kind, one in datasets.items()
    }


@pytest.fixture
def photographed(tmp_path: Path) -> Dataset:
    """Every frame but the last has a picture, a quarter as wide as the camera's, of its own colour."""
    (tmp_path / "photos").mkdir()
    for frame in range(FRAMES - 1):
        Image.new("RGB", (320, 180), (10 * frame % 256, 200, 40)).save(tmp_path / "photos" / f"{frame:03d}.png")
    pictures = Pictures(pattern=str(tmp_path / "photos" / "{:03d}.png"), first=0, step=1)
    return made(tmp_path / "d", recording(pictures=pictures))


def replays(datasets: dict[str, Dataset], answers: dict[str, Path], kind: str) -> tuple[Replay, Replay]:
    """Without an answer, and with one."""
    return load_replay(datasets[kind], 0), load_replay(datasets[kind], 0, [answers[kind]])


def first(dataset: Dataset) -> int:
    """The recording's frame where the sequence begins."""
    return dataset.sequence(0).first_frame


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_errors_are_those_of_which_the_truth_is_known(datasets, answers, kind):
    _, answered = replays(datasets, answers, kind)
    metrics = {"whole": {"dx", "dx_rel", "dr", "dt"}, "poses": {"dr", "dt"}, "relative": {"dx_rel"}, "none": set()}
    (answer,) = answered.answers
    assert {key for key, values in answer.errors.items() if np.isfinite(values).any()} == metrics[kind]
    assert set(answer.errors) == metrics[kind]


def test_people_known_from_the_camera_only_stand_around_the_answered_pose(datasets, answers):
    bare, answered = replays(datasets, answers, "relative")
    places = datasets["relative"].relative_truth(bare.sequence)
    for replay, poses in ((bare, np.zeros((FRAMES, 3))), (answered, answered.answers[0].estimate.poses)):
        assert replay.truth is not None
        np.testing.assert_allclose(replay.viewpoints, poses[: replay.sequence.frames])
        stands = np.isfinite(replay.viewpoints[:, 0])  # frame 1 is neither given nor answered
        assert stands.sum() >= FRAMES - 1
        again = world_to_relative(replay.truth.positions, replay.viewpoints)
        np.testing.assert_allclose(again[stands], places[stands])
        assert np.isnan(replay.truth.poses).all()
    scored = np.nanmean(answered.answers[0].errors["dx_rel"])
    assert 0.0 < scored < 1.0


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_plot_draws_what_is_known_and_says_what_is_not(datasets, answers, kind, answered):
    figure = plot_replay(replays(datasets, answers, kind)[answered], 10)
    places = np.isfinite(points(figure, "truth")).all(axis=1).sum()
    assert (places > 0) == (kind in ("whole", "relative"))
    assert ("observer-truth" in gids(part(figure, "bird"))) == (
        kind in ("whole", "poses") or (kind == "relative" and not answered)
    )
    assert ("observer-estimate" in gids(part(figure, "bird"))) == answered
    caveat = {
        "poses": "where people really are is not known",
        "relative": "true places as seen from the",
        "none": "no truth was ever measured",
    }
    for other, text in caveat.items():
        assert (text in words(figure)) == (other == kind)
    assert "one" in words(figure).split("sequence")[0], "the recording's name"


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_film_of_footage_needs_no_truth_and_no_renderer(datasets, answers, kind, answered):
    replay = replays(datasets, answers, kind)[answered]
    film = Film(replay, Backdrop(replay.dataset, replay.sequence))
    frame = next(film.frames([10]))
    assert frame.shape == (film.height, film.width, 3)
    ego = frame[TITLE_HEIGHT : TITLE_HEIGHT + 720, :1280]
    for colour in (SKY, GROUND):
        assert np.all(ego == colour, axis=-1).mean() > 0.2
    drawn = np.any(frame[TITLE_HEIGHT : TITLE_HEIGHT + 720, 1280:] != 255, axis=-1)
    assert drawn.mean() > 0.01


def test_boxes_lie_over_the_cameras_own_pictures(photographed):
    replay = load_replay(photographed, 0)
    assert (first(photographed), replay.sequence.frames) == (0, FRAMES)
    with pytest.warns(VbbenchWarning, match=f"1 of {FRAMES} pictures of sequence 0 are missing, .*029.png first"):
        backdrop = Backdrop(photographed, replay.sequence)
    assert (backdrop.width, backdrop.height, backdrop.zoom) == (1280, 720, 1.0)
    assert backdrop.picture(7)[100, 100].tolist() == [70, 200, 40]
    assert backdrop.picture(FRAMES - 1)[0, 0].tolist() == list(SKY)
    shown = next(Film(replay, backdrop).frames([7]))[TITLE_HEIGHT : TITLE_HEIGHT + 720, :1280]
    assert 0.6 < np.all(shown == (70, 200, 40), axis=-1).mean() < 0.999
    figure = plot_replay(replay, 7)
    (picture,) = part(figure, "ego").images
    assert picture.get_array()[0, 0].tolist() == [70, 200, 40]
    assert list(picture.get_extent()) == [0.0, 1280.0, 720.0, 0.0]
    with pytest.warns(VbbenchWarning, match="1 of 1 pictures"):
        assert not part(plot_replay(replay, FRAMES - 1), "ego").images


def test_the_map_of_a_long_way_goes_with_the_observer(tmp_path):
    slow = recording()
    assert slow.poses is not None
    assert slow.scene is not None
    shift = 10.0 * np.arange(FRAMES)
    poses = slow.poses + np.stack([shift, shift, 0.0 * shift], axis=-1)
    people = replace(slow.scene, positions=slow.scene.positions + shift[:, None, None])
    replay = load_replay(made(tmp_path / "d", replace(slow, poses=poses, scene=people)), 0)
    film = Film(replay, Backdrop(replay.dataset, replay.sequence))
    assert film.bird.moves
    frames = [0, 15, FRAMES - 1]
    for frame, _ in zip(frames, film.frames(frames), strict=True):
        seen = replay.known.positions[frame, replay.sequence.observed[frame]]
        for place in film.bird.place(np.vstack([seen, replay.known.poses[frame, None, :2]])):
            assert np.isnan(place).all() or np.all((place > 0) & (place < [film.bird.width, film.bird.height]))


def test_large_pictures_are_made_smaller_and_boxes_with_them(tmp_path):
    camera = PerspectiveCamera(width=2560, height=1440, focal=1280.0, cx=1280.0, cy=720.0, mount_height=1.5)
    big = replace(recording(), camera=camera, boxes=2.0 * recording().boxes)
    replay = load_replay(made(tmp_path / "d", big), 0)
    backdrop = Backdrop(replay.dataset, replay.sequence, widest=640)
    assert (backdrop.width, backdrop.height, backdrop.zoom) == (640, 360, 0.25)
    film = Film(replay, backdrop)
    bare, drawn = backdrop.picture(10), next(film.frames([10]))[TITLE_HEIGHT : TITLE_HEIGHT + 360, :640]
    u, v, length = 0.25 * replay.sequence.observations[10, 0]
    changed = np.any(bare != drawn, axis=-1)
    left = round(float(u - 0.18 * length))
    assert changed[round(float(v)), left - 2 : left + 3].any()
    assert Backdrop(replay.dataset, replay.sequence, widest=100, least=200).height == 200


@pytest.mark.parametrize("shot", [False, True])
def test_a_box_beyond_the_border_is_drawn_in_films_and_plots(photographed, tmp_path, shot):
    """As those of a lens's corners lie once they are straight; the camera's own picture stays where it is."""
    boxes = recording().boxes.copy()
    boxes[:, 0] = -80.0, 360.0, 200.0
    pictures = photographed.info.pictures[0] if shot else None
    replay = load_replay(made(tmp_path / "beyond", replace(recording(pictures=pictures), boxes=boxes)), 0)
    assert replay.window == (-116.0, 0.0, 1280.0, 720.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VbbenchWarning)
        backdrop = Backdrop(replay.dataset, replay.sequence, window=replay.window)
        ego = part(plot_replay(replay, 7), "ego")
    assert (backdrop.width, backdrop.height, backdrop.corner) == (1396, 720, (-116.0, 0.0))
    bare, drawn = backdrop.picture(7), next(Film(replay, backdrop).frames([7]))[TITLE_HEIGHT : TITLE_HEIGHT + 720]
    assert (bare[100, 120].tolist() == [70, 200, 40]) == shot
    assert bare[100, 100].tolist() == list(SKY)
    changed = np.any(bare[:, :80] != drawn[:, :80], axis=-1)
    for column in (0, 72):
        assert changed[270:450, column].all()
    assert ego.get_xlim() == (-116.0, 1280.0)
    assert [list(image.get_extent()) for image in ego.images] == [[-116.0, 1280.0, 720.0, 0.0]] * shot


def test_a_panorama_without_pictures_reaches_down_to_all_feet(tmp_path):
    camera = PanoramaCamera(width=900, cy=100.0, focal=143.0)
    low = replace(recording(), camera=camera)
    replay = load_replay(made(tmp_path / "d", low), 0)
    _, v, length = np.moveaxis(replay.sequence.observations, -1, 0)
    assert Backdrop(replay.dataset, replay.sequence).height == np.ceil(np.nanmax(v + length / 2))


def test_a_picture_that_is_none_is_one_clear_error(photographed):
    pictures = photographed.info.pictures[0]
    assert pictures is not None
    pictures.path(3).write_bytes(b"no picture")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", VbbenchWarning)
        backdrop = Backdrop(photographed, photographed.sequence(0))
    with pytest.raises(FileError, match=r"003\.png: cannot be read as a picture"):
        backdrop.picture(3)


def test_a_pattern_that_names_no_path_is_one_clear_error(tmp_path):
    dataset = made(tmp_path / "d", recording(pictures=Pictures(pattern="/{wrong}.png", first=0, step=1)))
    with pytest.raises(FileError, match="key 'pictures': no path of sequence 0"):
        Backdrop(dataset, dataset.sequence(0))


@pytest.mark.slow
def test_render_footage_writes_a_film_and_goes_on_with_it(photographed, capsys, tmp_path):
    command = ["render", str(photographed.folder), "--sequence", "0", "--footage", "--out", str(tmp_path / "film")]
    assert main(command) == 0
    shown = capsys.readouterr()
    assert shown.out == f"{tmp_path / 'film'}\n"
    assert shown.err.count("pictures of sequence 0 are missing") == 1
    key = (tmp_path / "film" / "film.txt").read_text()
    assert main(command) == 0
    assert (tmp_path / "film" / "film.txt").read_text() == key
    pictures = photographed.info.pictures[0]
    assert pictures is not None
    Image.new("RGB", (320, 180)).save(pictures.path(2))
    assert main(command) == 0
    assert (tmp_path / "film" / "film.txt").read_text() != key
    assert main([*command, "--backend", "raster"]) == 2
    assert "remove --backend" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["poses", "relative", "none"])
def test_a_renderer_needs_the_whole_truth(datasets, tmp_path, kind, capsys):
    with pytest.raises(VbbenchError, match=r"cannot be rendered: where .* was never measured; 'vbbench render --foot"):
        render_to_file(
            datasets[kind], 0, tmp_path / "f.mp4", backend=Backend(name="tests.lib.flat_renderer:FlatRenderer")
        )
    assert main(["render", str(datasets[kind].folder), "--sequence", "0", "--out", str(tmp_path / "f.mp4")]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.extra
@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_for_the_viewer_holds_what_is_known(datasets, answers, tmp_path, kind):
    pytest.importorskip("rerun.chunk", reason="needs the extra viewer, new enough to read recordings")
    from tests.pictures.test_viewer import read
    from vbbench.pictures.viewer import record_to_file

    entities = read(record_to_file(datasets[kind], 0, tmp_path / "x.rrd", submissions=[answers[kind]]))
    assert ("world/observer" in entities) == (kind in ("whole", "poses"))
    assert ("world/people" in entities) == (kind in ("whole", "relative"))
    assert {name.split("/")[1] for name in entities if name.startswith("errors/") and not name.endswith("*")} == set(
        load_replay(datasets[kind], 0, [answers[kind]]).answers[0].errors
    )
    text = entities["facts*"]["TextDocument:text"][0][0]
    assert "of recording one from its frame 0" in text
    assert ("true places as seen from the estimated camera" in text) == (kind == "relative")
    read(record_to_file(datasets[kind], 0, tmp_path / "y.rrd"))


@pytest.mark.extra
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
def test_a_recording_for_the_viewer_can_hold_the_cameras_pictures(photographed, tmp_path):
    pytest.importorskip("rerun.chunk", reason="needs the extra viewer, new enough to read recordings")
    from tests.pictures.test_viewer import read
    from vbbench.pictures.viewer import record_to_file

    entities = read(record_to_file(photographed, 0, tmp_path / "x.rrd", footage=True))
    pictures = entities["world/observer/camera/picture"]["EncodedImage:blob"]
    assert sum(one is not None for one in pictures) == FRAMES - 1
    with pytest.raises(VbbenchError, match="ask for one of them"):
        record_to_file(photographed, 0, tmp_path / "y.rrd", footage=True, backend=Backend())


@pytest.mark.parametrize("kind", ["poses", "relative", "none"])
def test_other_commands_say_what_they_lack(datasets, answers, kind, tmp_path, capsys):
    folder = str(datasets[kind].folder)
    for command in (["export", "mot"], ["export", "csv"]):
        assert main([*command, folder, "--out", str(tmp_path / command[1])]) == 0
    assert main(["verify", folder]) == 0
    assert main(["info", folder]) == 0
    capsys.readouterr()
    own = [str(answers[kind])] * 2
    assert main(["compare", *own, "--dataset", folder]) == (2 if kind == "none" else 0)
    table = capsys.readouterr().out
    assert "nan" not in table
    assert table.count("not known") == {"poses": 2, "relative": 5, "none": 0}[kind]
