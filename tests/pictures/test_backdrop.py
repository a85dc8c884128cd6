"""Footage in plots, films and the viewer: the camera's own pictures, and what is known of the truth."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tests.lib.made_footage import FRAMES, KINDS, known_as, made, photographed, recording
from tests.pictures.plotting.test_plotting import gids, part, points, words
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import Pictures
from vbbench.geometry import world_to_relative
from vbbench.pictures.backdrop import GROUND, SKY, Backdrop
from vbbench.pictures.film import TITLE_HEIGHT, Film
from vbbench.pictures.plotting import plot_replay
from vbbench.pictures.rendering import Backend, render_to_file
from vbbench.pictures.replay import load_replay
from vbbench.solving import solve

__all__ = ["photographed"]
EGO = slice(TITLE_HEIGHT, TITLE_HEIGHT + 720)
unpictured = pytest.mark.filterwarnings("ignore:.* pictures of sequence:vbbench.errors.VbbenchWarning")


@pytest.fixture(scope="module")
def datasets(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Dataset]:
    folder = tmp_path_factory.mktemp("footage")
    return {kind: made(folder / kind, known_as(kind)) for kind in KINDS}


@pytest.fixture(scope="module")
def answers(datasets: dict[str, Dataset]) -> dict[str, Path]:
    walker = "tests.lib.made_footage:Walker"
    return {
        kind: solve(one, walker, "cold-start", one.folder.with_name(f"{kind}-answer")) for kind, one in datasets.items()
    }


@pytest.fixture
def replay(datasets, answers, kind, answered):
    return load_replay(datasets[kind], 0, [answers[kind]] if answered else [])


@pytest.mark.slow
@pytest.mark.parametrize("answered", [True])
@pytest.mark.parametrize("kind", KINDS)
def test_errors_are_those_of_which_the_truth_is_known(replay, kind):
    metrics = {"whole": {"dx", "dx_rel", "dr", "dt"}, "poses": {"dr", "dt"}, "relative": {"dx_rel"}, "none": set()}
    (answer,) = replay.answers
    assert {key for key, values in answer.errors.items() if np.isfinite(values).any()} == metrics[kind]
    assert set(answer.errors) == metrics[kind]


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize("kind", ["relative"])
def test_people_known_from_the_camera_only_stand_around_the_answered_pose(replay, answered):
    places = replay.dataset.relative_truth(replay.sequence)
    poses = replay.answers[0].estimate.poses if answered else np.zeros((FRAMES, 3))
    np.testing.assert_allclose(replay.viewpoints, poses[: replay.sequence.frames])
    stands = np.isfinite(replay.viewpoints[:, 0])  # frame 1 is neither given nor answered
    assert stands.sum() >= FRAMES - 1
    again = world_to_relative(replay.truth.positions, replay.viewpoints)
    np.testing.assert_allclose(again[stands], places[stands])
    assert np.isnan(replay.truth.poses).all()
    assert not answered or 0.0 < np.nanmean(replay.answers[0].errors["dx_rel"]) < 1.0


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_plot_draws_what_is_known_and_says_what_is_not(replay, kind, answered):
    figure = plot_replay(replay, 10)
    drawn = gids(part(figure, "bird"))
    assert np.isfinite(points(figure, "truth")).all(axis=1).any() == (kind in ("whole", "relative"))
    assert ("observer-truth" in drawn) == (kind in ("whole", "poses") or (kind == "relative" and not answered))
    assert ("observer-estimate" in drawn) == answered
    caveat = {
        "poses": "where people really are is not known",
        "relative": "true places as seen from the",
        "none": "no truth was ever measured",
    }
    assert [other for other, text in caveat.items() if text in words(figure)] == [kind] * (kind != "whole")
    assert "one" in words(figure).split("sequence")[0], "the recording's name"


@pytest.mark.parametrize("answered", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_film_of_footage_needs_no_truth_and_no_renderer(replay):
    film = Film(replay, Backdrop(replay.dataset, replay.sequence))
    frame = next(film.frames([10]))
    assert frame.shape == (film.height, film.width, 3)
    for colour in (SKY, GROUND):
        assert np.all(frame[EGO, :1280] == colour, axis=-1).mean() > 0.2
    assert np.any(frame[EGO, 1280:] != 255, axis=-1).mean() > 0.01


def test_boxes_lie_over_the_cameras_own_pictures(photographed):
    replay = load_replay(photographed, 0)
    assert (replay.sequence.first_frame, replay.sequence.frames) == (0, FRAMES)
    with pytest.warns(VbbenchWarning, match=f"1 of {FRAMES} pictures of sequence 0 are missing, .*029.png first"):
        backdrop = Backdrop(photographed, replay.sequence)
    assert (backdrop.width, backdrop.height, backdrop.zoom) == (1280, 720, 1.0)
    assert backdrop.picture(7)[100, 100].tolist() == [70, 200, 40]
    assert backdrop.picture(FRAMES - 1)[0, 0].tolist() == list(SKY)
    shown = next(Film(replay, backdrop).frames([7]))[EGO, :1280]
    assert 0.6 < np.all(shown == (70, 200, 40), axis=-1).mean() < 0.999
    (picture,) = part(plot_replay(replay, 7), "ego").images
    assert picture.get_array()[0, 0].tolist() == [70, 200, 40]
    assert list(picture.get_extent()) == [0.0, 1280.0, 720.0, 0.0]
    with pytest.warns(VbbenchWarning, match="1 of 1 pictures"):
        assert not part(plot_replay(replay, FRAMES - 1), "ego").images


def test_the_map_of_a_long_way_goes_with_the_observer(tmp_path):
    slow, shift = recording(), 10.0 * np.arange(FRAMES)
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
    replay = load_replay(made(tmp_path / "d", recording(camera=camera, boxes=2.0 * recording().boxes)), 0)
    backdrop = Backdrop(replay.dataset, replay.sequence, widest=640)
    assert (backdrop.width, backdrop.height, backdrop.zoom) == (640, 360, 0.25)
    film = Film(replay, backdrop)
    bare, drawn = backdrop.picture(10), next(film.frames([10]))[TITLE_HEIGHT : TITLE_HEIGHT + 360, :640]
    u, v, length = 0.25 * replay.sequence.observations[10, 0]
    left = round(float(u - 0.18 * length))
    assert np.any(bare != drawn, axis=-1)[round(float(v)), left - 2 : left + 3].any()
    assert Backdrop(replay.dataset, replay.sequence, widest=100, least=200).height == 200


@unpictured
@pytest.mark.parametrize("shot", [False, True])
def test_a_box_beyond_the_border_is_drawn_in_films_and_plots(photographed, tmp_path, shot):
    """As those of a lens's corners lie once they are straight; the camera's own picture stays where it is."""
    boxes = recording().boxes.copy()
    boxes[:, 0] = -80.0, 360.0, 200.0
    pictures = photographed.info.pictures[0] if shot else None
    replay = load_replay(made(tmp_path / "beyond", recording(pictures=pictures, boxes=boxes)), 0)
    assert replay.window == (-116.0, 0.0, 1280.0, 720.0)
    backdrop = Backdrop(replay.dataset, replay.sequence, window=replay.window)
    ego = part(plot_replay(replay, 7), "ego")
    assert (backdrop.width, backdrop.height, backdrop.corner) == (1396, 720, (-116.0, 0.0))
    bare, drawn = backdrop.picture(7), next(Film(replay, backdrop).frames([7]))[EGO]
    assert (bare[100, 120].tolist() == [70, 200, 40]) == shot
    assert bare[100, 100].tolist() == list(SKY)
    assert np.any(bare[:, :80] != drawn[:, :80], axis=-1)[270:450, [0, 72]].all()
    assert ego.get_xlim() == (-116.0, 1280.0)
    assert [list(image.get_extent()) for image in ego.images] == [[-116.0, 1280.0, 720.0, 0.0]] * shot


def test_a_panorama_without_pictures_reaches_down_to_all_feet(tmp_path):
    low = recording(camera=PanoramaCamera(width=900, cy=100.0, focal=143.0))
    replay = load_replay(made(tmp_path / "d", low), 0)
    _, v, length = np.moveaxis(replay.sequence.observations, -1, 0)
    assert Backdrop(replay.dataset, replay.sequence).height == np.ceil(np.nanmax(v + length / 2))


@unpictured
def test_a_picture_that_is_none_is_one_clear_error(photographed):
    photographed.info.pictures[0].path(3).write_bytes(b"no picture")
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
    Image.new("RGB", (320, 180)).save(photographed.info.pictures[0].path(2))
    assert main(command) == 0
    assert (tmp_path / "film" / "film.txt").read_text() != key
    assert main([*command, "--backend", "raster"]) == 2
    assert "remove --backend" in capsys.readouterr().err


@pytest.mark.parametrize("kind", KINDS[1:])
def test_a_renderer_needs_the_whole_truth(datasets, tmp_path, kind, capsys):
    flat = Backend(name="tests.lib.flat_renderer:FlatRenderer")
    with pytest.raises(VbbenchError, match=r"cannot be rendered: where .* was never measured; 'vbbench render --foot"):
        render_to_file(datasets[kind], 0, tmp_path / "f.mp4", backend=flat)
    assert main(["render", str(datasets[kind].folder), "--sequence", "0", "--out", str(tmp_path / "f.mp4")]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1


@pytest.mark.extra
@pytest.mark.parametrize("answered", [True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_recording_for_the_viewer_holds_what_is_known(datasets, answers, replay, tmp_path, kind):
    pytest.importorskip("rerun.chunk", reason="needs the extra viewer, new enough to read recordings")
    from tests.pictures.test_viewer import read
    from vbbench.pictures.viewer import record_to_file

    entities = read(record_to_file(datasets[kind], 0, tmp_path / "x.rrd", submissions=[answers[kind]]))
    assert ("world/observer" in entities) == (kind in ("whole", "poses"))
    assert ("world/people" in entities) == (kind in ("whole", "relative"))
    errors = {name.split("/")[1] for name in entities if name.startswith("errors/") and not name.endswith("*")}
    assert errors == set(replay.answers[0].errors)
    text = entities["facts*"]["TextDocument:text"][0][0]
    assert "of recording one from its frame 0" in text
    assert ("true places as seen from the estimated camera" in text) == (kind == "relative")
    read(record_to_file(datasets[kind], 0, tmp_path / "y.rrd"))


@unpictured
@pytest.mark.extra
def test_a_recording_for_the_viewer_can_hold_the_cameras_pictures(photographed, tmp_path):
    pytest.importorskip("rerun.chunk", reason="needs the extra viewer, new enough to read recordings")
    from tests.pictures.test_viewer import read
    from vbbench.pictures.viewer import record_to_file

    entities = read(record_to_file(photographed, 0, tmp_path / "x.rrd", footage=True))
    pictures = entities["world/observer/camera/picture"]["EncodedImage:blob"]
    assert sum(one is not None for one in pictures) == FRAMES - 1
