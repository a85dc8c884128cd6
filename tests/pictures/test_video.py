"""Films are read: videos and folders of pictures."""

import cv2
import numpy as np
import pytest

from tests.lib.square_film import FRAMES, HEIGHT, WIDTH, drawn, write_folder, write_video
from vbbench.errors import FileError, VbbenchWarning
from vbbench.pictures.video import open_film


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
