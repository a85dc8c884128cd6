"""Films are read, videos and folders of pictures, and people in them become a file of boxes."""

from typing import Any

import cv2
import numpy as np
import pytest

from tests.lib.mot_text import read_mot
from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.detection import Detections
from vbbench.exchange.film_boxes import find_boxes, kept_detections, key_of
from vbbench.pictures.video import open_film, write_mp4

FRAMES, WIDTH, HEIGHT = 12, 96, 64


def drawn(frame: int) -> Any:
    """A white square that moves 5 px a frame over a red ground."""
    picture = np.full((HEIGHT, WIDTH, 3), (180, 0, 0), np.uint8)
    picture[20:50, 10 + 5 * frame : 20 + 5 * frame] = 255
    return picture


def write_video(path: Any, fps: float = 10.0) -> Any:
    write_mp4(path, lambda frames: map(drawn, frames), FRAMES, fps)
    return path


def write_folder(folder: Any, name: str = "{}.png") -> Any:
    folder.mkdir(parents=True)
    for frame in range(FRAMES):
        cv2.imwrite(str(folder / name.format(frame)), drawn(frame)[..., ::-1])
    return folder


class Square:
    """Finds the square, in two of three frames, and a false alarm in the first."""

    seen = 0

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        rows, columns = np.nonzero(rgb.min(axis=-1) > 128)
        box = [columns.min(), rows.min(), np.ptp(columns) + 1, np.ptp(rows) + 1]
        self.seen += 1
        if self.seen == 1:
            return Detections(boxes=np.array([box, [70.0, 5.0, 8.0, 20.0]]), scores=np.array([0.9, 0.9]))
        return Detections(boxes=np.array([box], float), scores=np.array([0.9]))


class Once(Square):
    """Finds the square in the first picture alone."""

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        found = super().detect(rgb)
        kept = slice(1 if self.seen == 1 else 0)
        return Detections(boxes=found.boxes[kept], scores=found.scores[kept])


SQUARE = "tests.exchange.test_film_boxes:Square"


def test_a_video_has_its_frame_rate_size_and_colours(tmp_path, recwarn):
    film = open_film(write_video(tmp_path / "film.mp4", fps=12.5))
    assert (film.width, film.height, film.frames, film.fps) == (WIDTH, HEIGHT, FRAMES, pytest.approx(12.5))
    pictures = list(film.pictures())
    assert (len(pictures), len(recwarn)) == (FRAMES, 0)
    assert np.abs(pictures[4][:5].mean(axis=(0, 1)) - [180, 0, 0]).max() < 12  # RGB, and lossy
    assert pictures[4][35, 35].min() > 200
    assert film.numbered() is None


def test_a_folder_is_read_in_the_order_of_its_numbers(tmp_path):
    film = open_film(write_folder(tmp_path / "pictures"))
    assert (film.frames, film.fps) == (FRAMES, None)
    for frame, picture in enumerate(film.pictures()):
        np.testing.assert_array_equal(picture, drawn(frame))
    assert film.numbered() is not None
    assert film.numbered().path(11) == (tmp_path / "pictures" / "11.png").resolve()


def test_pictures_that_are_numbered_are_found_by_their_number(tmp_path):
    film = open_film(write_folder(tmp_path / "a{b}", "shot-{:04d}.png"))
    pictures = film.numbered()
    assert pictures is not None
    assert [pictures.path(frame).is_file() for frame in (0, 11, 12)] == [True, True, False]
    (tmp_path / "a{b}" / "shot-0005.png").unlink()
    assert open_film(tmp_path / "a{b}").numbered() is None


@pytest.mark.parametrize("kind", ["video", "folder"])
def test_people_become_boxes_and_what_does_not_last_is_left_out(tmp_path, kind):
    path = write_video(tmp_path / "film.mp4") if kind == "video" else write_folder(tmp_path / "pictures")
    fps = None if kind == "video" else 10.0
    found = find_boxes(open_film(path), tmp_path / "boxes.txt", fps=fps, detector=SQUARE)
    assert (found.frames, found.dt, found.detections) == (FRAMES, pytest.approx(0.1), FRAMES + 1)
    assert (found.boxes, found.tracks) == (FRAMES, 1)
    rows = read_mot(found.path, FRAMES)
    np.testing.assert_array_equal(rows.frame, np.arange(FRAMES))
    np.testing.assert_allclose(rows.boxes[:, 0], 10 + 5 * np.arange(FRAMES), atol=3.0)
    np.testing.assert_allclose(rows.boxes[:, 3], 30.0, atol=3.0)
    assert "the tracker keeps 12 boxes of 1 people" in str(found)


class Tired(Square):
    """Stops before its eighth picture."""

    def detect(self, rgb: Any, period: float | None = None) -> Detections:
        if self.seen == 7:
            raise KeyboardInterrupt
        return super().detect(rgb, period)


TIRED = "tests.exchange.test_film_boxes:Tired"


def stopped_search(folder: Any) -> Any:
    """A film, the file of boxes that was not made, and the detections that are kept."""
    film, out = open_film(write_folder(folder / "pictures")), folder / "boxes.txt"
    with pytest.raises(KeyboardInterrupt):
        find_boxes(film, out, fps=10.0, detector=TIRED)
    return film, out, folder / "boxes.txt.detections"


def test_a_search_that_was_stopped_goes_on_where_it_was(tmp_path, monkeypatch):
    """Also where the last line was half written."""
    film, out, kept = stopped_search(tmp_path)
    whole = find_boxes(film, tmp_path / "whole.txt", fps=10.0, detector=SQUARE)
    assert len(kept.read_text().splitlines()) == 1 + 7
    assert not out.exists()
    with kept.open("a") as file:
        file.write("[[1.0, 2.0")
    seen = []

    def rested(self: Any, rgb: Any, period: float | None = None) -> Detections:
        seen.append(rgb)
        return Square.detect(self, rgb)

    monkeypatch.setattr(Square, "seen", 1)
    monkeypatch.setattr(Tired, "detect", rested)
    found = find_boxes(film, out, fps=10.0, detector=TIRED)
    assert len(seen) == FRAMES - 7
    assert out.read_bytes() == whole.path.read_bytes()
    assert (found.detections, found.boxes, found.tracks) == (whole.detections, whole.boxes, whole.tracks)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["boxes.txt", "pictures", "whole.txt"]


@pytest.mark.parametrize("damage", [b"\0\0\0\0\n", b"[5, [[1.0, 2.0]]]\n", b"[3, []]\n", b"{}\n"])
def test_lines_from_a_damaged_one_on_are_made_again(tmp_path, damage):
    film, out, kept = stopped_search(tmp_path)
    whole = find_boxes(film, tmp_path / "whole.txt", fps=10.0, detector=SQUARE)
    lines = kept.read_bytes().splitlines(keepends=True)
    kept.write_bytes(b"".join([*lines[:6], damage, *lines[7:]]))
    with kept_detections(kept, key_of(film, TIRED, None)) as (found, _):
        assert len(found) == 5
    find_boxes(film, out, fps=10.0, detector=SQUARE)
    assert out.read_bytes() == whole.path.read_bytes()


def test_detections_of_another_detector_are_made_anew(tmp_path):
    film, out, _ = stopped_search(tmp_path)
    assert find_boxes(film, out, fps=10.0, detector=SQUARE).detections == FRAMES + 1


def test_a_file_of_ones_own_is_not_overwritten_by_detections(tmp_path):
    film = open_film(write_folder(tmp_path / "pictures"))
    (tmp_path / "boxes.txt.detections").write_text("mine\n")
    with pytest.raises(FileError, match="is in the way of detections that are kept there; move it"):
        find_boxes(film, tmp_path / "boxes.txt", fps=10.0, detector=SQUARE)
    assert (tmp_path / "boxes.txt.detections").read_text() == "mine\n"


def test_every_third_frame_is_written_but_all_are_tracked(tmp_path):
    film = open_film(write_folder(tmp_path / "pictures"))
    found = find_boxes(film, tmp_path / "boxes.txt", fps=10.0, detector=SQUARE, every=3)
    assert read_mot(found.path, FRAMES).frame.tolist() == [0, 3, 6, 9]
    assert found.detections == FRAMES + 1


def test_without_a_frame_rate_or_people_it_is_one_clear_line(tmp_path):
    folder = write_folder(tmp_path / "pictures")
    with pytest.raises(FileError, match="does not say how many frames a second it has; write fps in camera"):
        find_boxes(open_film(folder), tmp_path / "boxes.txt", detector=SQUARE)
    with pytest.raises(FileError, match="hog finds nobody in 12 pictures; do they show people"):
        find_boxes(open_film(folder), tmp_path / "boxes.txt", fps=10.0)
    with pytest.raises(FileError, match="finds 1 boxes, and none of them lasts; a better detector"):
        find_boxes(open_film(folder), tmp_path / "boxes.txt", fps=10.0, detector="tests.exchange.test_film_boxes:Once")
    with pytest.raises(VbbenchError, match="every must be at least 1 frame, not 0"):
        find_boxes(open_film(folder), tmp_path / "boxes.txt", fps=10.0, every=0)


def test_a_film_that_cannot_be_read_is_one_clear_line(tmp_path):
    with pytest.raises(FileError, match="there is no such film; name a video, or a folder of pictures"):
        open_film(tmp_path / "none.mp4")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileError, match=r"holds no pictures; wanted.*one file of boxes"):
        open_film(tmp_path / "empty")
    for name, content in (("a.mp4", b"no video" * 99), ("b.mp4", b"")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(FileError, match="is no video that OpenCV can read"):
            open_film(tmp_path / name)


@pytest.mark.parametrize(
    ("content", "message"), [(b"", "is no picture"), (b"no png", "is no picture"), (None, "is 8 x")]
)
def test_a_damaged_picture_is_named(tmp_path, content, message):
    folder = write_folder(tmp_path / "pictures")
    if content is None:
        cv2.imwrite(str(folder / "7.png"), np.zeros((8, 8, 3), np.uint8))
    else:
        (folder / "7.png").write_bytes(content)
    with pytest.raises(FileError, match=rf"7\.png: {message}"):
        list(open_film(folder).pictures())


def test_a_video_that_is_cut_short_is_said(tmp_path):
    path = write_video(tmp_path / "film.mp4")
    film = open_film(path)
    object.__setattr__(film, "frames", 40)
    with pytest.warns(VbbenchWarning, match="only 12 of 40 frames can be read"):
        list(film.pictures())


def test_a_frame_rate_that_the_pictures_do_not_keep_is_said(tmp_path):
    film = open_film(write_video(tmp_path / "film.mp4", fps=10.0))
    object.__setattr__(film, "fps", 8.0)
    with pytest.warns(VbbenchWarning, match=r"a frame comes -2\.\d frames from where 8 frames a second would"):
        list(film.pictures())
