"""Films of sequences: what is on them, where they go, and what is left when something goes wrong."""

import itertools
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tests.lib.flat_renderer import FlatRenderer
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.boxes import suppress, with_seam_copies
from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.pictures.film import TITLE_HEIGHT, Film, draw_legend, paint
from vbbench.pictures.rendering import Backend, Rendered, render_to_file, scene_of
from vbbench.pictures.replay import load_replay
from vbbench.pictures.video import KEY_FILE, frame_name, write_mp4, write_png_folder
from vbbench.solving import solve

FLAT = "tests.lib.flat_renderer:FlatRenderer"
BY_FLAT = Backend(name=FLAT)


@pytest.fixture(scope="module", params=["panorama", "perspective"])
def dataset(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    camera = PanoramaCamera() if request.param == "panorama" else PerspectiveCamera()
    return generate("demo", tmp_path_factory.mktemp("film") / "demo", Options(camera=camera, limit=3))


@pytest.fixture(scope="module")
def panorama(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("demo") / "demo", Options(camera=PanoramaCamera(), limit=2))


@pytest.fixture(scope="module")
def submission(panorama: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return solve(panorama, "vb-cv", "sequential", tmp_path_factory.mktemp("answer") / "vb-cv")


def a_film(dataset: Dataset, number: int = 0, submission: Path | None = None) -> Film:
    replay = load_replay(dataset, number, [submission] if submission else [])
    return Film(replay, Rendered(replay, FlatRenderer(scene_of(dataset, replay.sequence.scene))))


def read_back(path: Path) -> tuple[list[Any], float]:
    film, pictures = cv2.VideoCapture(str(path)), []
    while True:
        there, picture = film.read()
        if not there:
            return pictures, float(film.get(cv2.CAP_PROP_FPS))
        pictures.append(picture[..., ::-1])


@pytest.mark.slow
def test_an_mp4_has_every_frame_at_real_time(dataset, tmp_path):
    out = render_to_file(dataset, 0, tmp_path / "film.mp4", backend=BY_FLAT)
    pictures, fps = read_back(out)
    film = a_film(dataset)
    assert len(pictures) == dataset.sequence(0).frames
    assert fps == pytest.approx(1.0 / dataset.info.dt)
    assert pictures[0].shape == (film.height, film.width, 3)
    assert film.width % 2 == film.height % 2 == 0
    frame = next(film.frames([0]))
    assert cv2.PSNR(frame, np.ascontiguousarray(pictures[0])) > 25.0
    assert [path.name for path in tmp_path.iterdir()] == ["film.mp4"]


def test_without_a_wish_the_codec_is_one_that_browsers_play(panorama, tmp_path):
    path = tmp_path / "film.mp4"
    write_mp4(path, lambda wanted: (np.full((64, 96, 3), 8 * n, np.uint8) for n in wanted), 5, 2.5)
    code = int(cv2.VideoCapture(str(path)).get(cv2.CAP_PROP_FOURCC)).to_bytes(4, "little").decode()
    assert code.lower() in ("avc1", "h264", "vp09", "vp90")
    assert len(read_back(path)[0]) == 5


def test_the_ego_view_is_the_picture_with_boxes_where_people_are(dataset):
    film = a_film(dataset)
    renderer = FlatRenderer.made[-1]
    sequence, camera = film.replay.sequence, dataset.info.camera
    canvas = next(film.frames([3]))
    bare = renderer.render(sequence.first_frame + 3, camera, film.replay.known.poses[3], observer=sequence.observer).rgb
    width, height = camera.picture_size
    ego = canvas[TITLE_HEIGHT : TITLE_HEIGHT + height, :width]
    changed = np.any(ego != bare, axis=-1)
    assert 0.0 < changed.mean() < 0.2
    u, v, length = sequence.observations[3, np.flatnonzero(sequence.observed[3])[0]]
    row, column = round(float(v)), round(float(u - 0.18 * length))
    assert changed[max(row, 0) : row + 1, max(column - 2, 0) : column + 3].any()


def test_a_box_on_the_seam_is_drawn_at_both_ends():
    box = np.array([[1430.0, 200.0, 20.0, 60.0]])
    period = PanoramaCamera().period
    assert with_seam_copies(box, period)[0][:, 0].tolist() == [1430.0, -10.0]
    assert with_seam_copies(box - [1435.0, 0, 0, 0], period)[0][:, 0].tolist() == [-5.0, 1435.0]
    assert len(with_seam_copies(box, PerspectiveCamera().period)[0]) == 1


def test_an_estimate_changes_the_map_and_the_title(panorama, submission):
    plain, drawn = a_film(panorama), a_film(panorama, 0, submission)
    one, other = (next(film.frames([5])) for film in (plain, drawn))
    below = TITLE_HEIGHT + 480
    assert np.array_equal(one[TITLE_HEIGHT:below], other[TITLE_HEIGHT:below])
    assert (one[below : below + plain.bird.height] != other[below : below + plain.bird.height]).any()
    assert (one[:TITLE_HEIGHT] != other[:TITLE_HEIGHT]).any()


def test_frames_are_made_one_at_a_time_and_forgotten(panorama):
    film = a_film(panorama)
    renderer = FlatRenderer.made[-1]
    frames = film.frames(itertools.cycle(range(5)))
    next(frames)
    assert len(renderer.frames) == 1
    for _ in range(30):
        next(frames)
    assert renderer.most <= 2


@pytest.mark.slow
def test_a_folder_of_pictures_is_gone_on_with(panorama, tmp_path):
    count = panorama.sequence(0).frames
    render_to_file(panorama, 0, tmp_path / "film", backend=BY_FLAT)
    names = {path.name for path in (tmp_path / "film").iterdir()}
    assert names == {KEY_FILE, *(frame_name(n) for n in range(count))}
    before = (tmp_path / "film" / frame_name(2)).read_bytes()
    (tmp_path / "film" / frame_name(2)).unlink()
    render_to_file(panorama, 0, tmp_path / "film", backend=BY_FLAT)
    assert FlatRenderer.made[-1].frames == [panorama.sequence(0).first_frame + 2]
    assert FlatRenderer.made[-1].closed
    assert (tmp_path / "film" / frame_name(2)).read_bytes() == before


@pytest.mark.slow
@pytest.mark.parametrize("change", [{"seed": 1}, {"surroundings": False}])
def test_frames_of_another_command_are_made_anew(panorama, tmp_path, change):
    render_to_file(panorama, 0, tmp_path / "film", backend=BY_FLAT)
    (tmp_path / "film" / frame_name(9999)).write_bytes(b"left over")
    render_to_file(panorama, 0, tmp_path / "film", backend=Backend(name=FLAT, **change))
    assert len(FlatRenderer.made[-1].frames) == panorama.sequence(0).frames
    assert not (tmp_path / "film" / frame_name(9999)).exists()


def test_a_folder_of_something_else_is_left_alone(panorama, tmp_path):
    (tmp_path / "thesis.tex").write_text("...")
    with pytest.raises(FileError, match="holds something other than frames"):
        render_to_file(panorama, 0, tmp_path, backend=BY_FLAT)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def failing_after(frames: int) -> Any:
    def make(wanted):
        for n in wanted:
            if n == frames:
                raise KeyboardInterrupt
            yield np.full((64, 96, 3), n, np.uint8)

    return make


def test_an_interrupted_film_leaves_whole_files_only(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"the film of yesterday")
    with pytest.raises(KeyboardInterrupt):
        write_mp4(path, failing_after(3), 9, 10.0)
    assert path.read_bytes() == b"the film of yesterday"
    assert list(tmp_path.iterdir()) == [path]
    with pytest.raises(KeyboardInterrupt):
        write_png_folder(tmp_path / "film", failing_after(3), 9, "key")
    names = {path.name for path in (tmp_path / "film").iterdir()}
    assert names == {KEY_FILE, *(frame_name(n) for n in range(3))}


@pytest.mark.parametrize(
    ("backend", "message"),
    [
        (Backend(name=FLAT, seed=-1), "seed must be at least 0, not -1"),
        (Backend(name="rastr"), "no renderer is called 'rastr'; did you mean 'raster'"),
    ],
)
def test_a_backend_that_cannot_be_opened_is_named(panorama, tmp_path, backend, message):
    with pytest.raises(VbbenchError, match=message):
        render_to_file(panorama, 0, tmp_path / "film.mp4", backend=backend)


def test_without_truth_it_is_one_clear_error(tmp_path, capsys):
    options = Options(camera=PanoramaCamera(), limit=1)
    generate("demo", tmp_path / "kept", options, withhold_truth=True)
    command = ["render", str(tmp_path / "kept"), "--sequence", "0", "--out", str(tmp_path / "f.mp4"), "--backend", FLAT]
    assert main(command) == 2
    assert (
        f"has no truth; put it at {tmp_path / 'kept' / 'truth'}, or name its folder with `truth`"
        in capsys.readouterr().err
    )
    (tmp_path / "kept.truth").rename(tmp_path / "kept" / "truth")
    assert main(command) == 0
    shown = capsys.readouterr()
    assert shown.out == f"{tmp_path / 'f.mp4'}\n"
    assert f"rendering with {FLAT} on a sheet of paper" in shown.err
    assert read_back(tmp_path / "f.mp4")[1] == pytest.approx(2.5, rel=0.01)


def test_a_long_caution_is_whole_below_the_film(tmp_path, monkeypatch):
    caution = "made up for tests. " + "Every word of this must be readable, however long it is. " * 6
    write_dataset(tmp_path / "data", Crowd(scenes=1, caution=caution))
    lines: list[str] = []
    monkeypatch.setattr(paint, "draw_text", lambda _canvas, text, *_rest, **_look: lines.append(text))
    legend = draw_legend(960, load_replay(Dataset(tmp_path / "data"), 0), 10.0)
    assert " ".join(caution.split()) in " ".join(lines)
    assert all(paint.text_width(line, 14) <= 960 for line in lines)
    assert legend.shape[1] == 960


def test_false_alarms_are_marked(tmp_path):
    write_dataset(tmp_path / "tiny", Crowd(scenes=1, tier="tracked"))
    film = a_film(Dataset(tmp_path / "tiny"))
    ego = next(film.frames([3]))[TITLE_HEIGHT : TITLE_HEIGHT + film.view.height]
    assert np.all(ego == (156, 42, 0), axis=-1).any()


def test_of_boxes_that_overlap_only_the_best_is_kept_round_the_seam_too():
    boxes = np.array([[0, 0, 30, 90], [2, 0, 30, 90], [100, 0, 30, 90], [1300, 0, 30, 90]], float)
    assert suppress(boxes, np.array([1.0, 2.0, 0.5, 0.1]), 0.4, 1300.0).tolist() == [1, 2]
    assert suppress(boxes, np.array([1.0, 2.0, 0.5, 0.1]), 0.4).tolist() == [1, 2, 3]
