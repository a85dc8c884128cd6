"""Writes the frames of a film: as an mp4 file, or a folder of PNG files that can be continued."""

import math
import os
import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, VbbenchError, VbbenchWarning, needs_extra
from vbbench.files.dataset_info import Pictures
from vbbench.folders.locks import locked
from vbbench.folders.replacing import is_unused, replacing, write_bytes_atomically, write_text_atomically

with needs_extra("render", "reading and writing pictures and films"):
    import cv2

Frames = Callable[[Iterable[int]], Iterator[NDArray[np.uint8]]]
"""Makes the pictures [H, W, 3] (sRGB) of the requested frames, one by one."""

KEY_FILE = "film.txt"
"""In a folder of frames: the key of their film."""

_CODES = ("avc1", "vp09", "mp4v")
"""Of H.264, VP9 and MPEG-4, in order of preference: browsers play the first two, not every OpenCV has the first."""
_PNG_LEVEL = 3
"""Of zlib: about as small as the default, and three times as fast."""


def write_mp4(path: Path, frames: Frames, count: int, fps: float, done: Callable[[], object] = int) -> None:
    """Write frames 0 … ``count`` − 1 as an mp4 file, which appears when it is whole.

    The codec is the first of H.264, VP9 and MPEG-4 that this OpenCV can write. Raises VbbenchError if there is none, or
    the file cannot be written.

    Parameters
    ----------
    path : the file; an existing one is replaced.
    frames : makes the pictures, of even width and height.
    count : number of frames.
    fps : frames per second.
    done : called after every frame.
    """
    writer: cv2.VideoWriter | None = None
    with replacing(path, path.suffix) as temporary:
        try:
            for picture in frames(range(count)):
                if writer is None:
                    writer = _open_writer(temporary, fps, (picture.shape[1], picture.shape[0]))
                writer.write(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
                done()
        finally:
            if writer is not None:
                writer.release()
        if writer is None:
            raise VbbenchError("a film of no frames cannot be written")
        if _count_frames(temporary) != count:
            raise FileError(path, "could not be written to its end; is the disk full?")


def write_png_folder(folder: Path, frames: Frames, count: int, key: str, done: Callable[[], object] = int) -> None:
    """Write frames as ``frame-000000.png`` and so on; existing ones stay.

    Raises FileError if the folder is a file, or holds something other than frames.

    Parameters
    ----------
    folder : the folder; created if needed. Frames of another film, with another key, are replaced.
    frames : makes the pictures.
    count : number of frames.
    key : identifies the film; the same key must mean the same pictures.
    done : called for every frame, new or existing.
    """
    if folder.exists() and not folder.is_dir():
        raise FileError(folder, "is a file; name a folder for frames, or a file that ends in .mp4")
    mark = folder / KEY_FILE
    with locked(folder):
        if not (mark.is_file() or is_unused(folder)):
            raise FileError(folder, "holds something other than frames of a film; choose another folder or empty it")
        if not (mark.is_file() and mark.read_text("utf-8") == key):
            for old in folder.glob("frame-*.png"):
                old.unlink()
            write_text_atomically(mark, key)
        missing = [frame for frame in range(count) if not (folder / frame_name(frame)).is_file()]
        for _ in range(count - len(missing)):
            done()
        for frame, picture in zip(missing, frames(missing), strict=True):
            write_bytes_atomically(folder / frame_name(frame), png_bytes(picture))
            done()


def frame_name(frame: int) -> str:
    """Name of a frame's file."""
    return f"frame-{frame:06d}.png"


def png_bytes(picture: NDArray[np.uint8]) -> bytes:
    """A picture [H, W, 3] (sRGB) as a PNG file."""
    _, data = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_PNG_COMPRESSION, _PNG_LEVEL])
    return data.tobytes()


def _count_frames(path: Path) -> int:
    """Frames of a film; 0 if it is incomplete: OpenCV does not report that it cannot write."""
    with _opened(path) as film:
        return int(film.get(cv2.CAP_PROP_FRAME_COUNT)) if film.isOpened() else 0


def _open_writer(path: Path, fps: float, size: tuple[int, int]) -> cv2.VideoWriter:
    with _silently():  # a missing codec is expected
        for code in _CODES:
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*code), fps, size)
            if writer.isOpened():
                return writer
            writer.release()
    raise VbbenchError(f"{path.parent}: no film can be written here; name a folder for PNG files instead")


ENDINGS = (".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff", ".ppm")
"""Of pictures in a folder."""
FASTEST = 1000.0
"""Frames a second above which a video does not know its own rate."""
UNEVEN = 0.6
"""Frames by which a picture may be early or late before the video's frame rate is doubted."""


@dataclass(frozen=True, kw_only=True)
class Film:
    """A video, or a folder of pictures in the order of their names.

    Parameters
    ----------
    path : the file or folder.
    files : [T] of a folder; none of a video.
    width, height : of the pictures in px.
    frames : number of pictures T; of a video, as it says.
    fps : frames per second; ``None`` if that is not known.
    """

    path: Path
    files: tuple[Path, ...]
    width: int
    height: int
    frames: int
    fps: float | None

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """All pictures [H, W, 3] (sRGB), one by one.

        Raises FileError if one cannot be read, or has another size than the first.
        """
        for shown, picture in self._files() if self.files else self._video():
            if picture.shape != (self.height, self.width, 3):
                size = f"{picture.shape[1]} x {picture.shape[0]} px"
                raise FileError(shown, f"is {size}, the pictures before it {self.width} x {self.height}")
            yield np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), np.uint8)

    def numbered(self) -> Pictures | None:
        """Where the pictures are, if they are files numbered one by one."""
        found = [re.fullmatch(r"(.*?)([0-9]+)(\.[A-Za-z]+)", file.name) for file in self.files]
        first = found[0] if found else None
        if first is None:
            return None
        start, digits = int(first[2]), len(first[2])
        names = (f"{first[1]}{start + n:0{digits}d}{first[3]}" for n in range(len(found)))
        if any(file.name != name for file, name in zip(self.files, names, strict=True)):
            return None
        before = f"{self.path.resolve()}/{first[1]}".replace("{", "{{").replace("}", "}}")
        return Pictures(pattern=f"{before}{{:0{digits}d}}{first[3]}", first=start, step=1)

    def _files(self) -> Iterator[tuple[Path, NDArray[np.uint8]]]:
        for file in self.files:
            yield file, _read_picture(file)

    def _video(self) -> Iterator[tuple[Path, NDArray[np.uint8]]]:
        latest, count = 0.0, 0
        with _opened(self.path) as video:
            while True:
                whole, picture = video.read()
                if not whole:
                    break
                if self.fps is not None:
                    off = video.get(cv2.CAP_PROP_POS_MSEC) * 1e-3 * self.fps - count
                    latest = max(latest, off, key=abs)
                count += 1
                yield self.path, np.asarray(picture, np.uint8)
        if count < self.frames - 1:
            _warn(self.path, f"only {count} of {self.frames} frames can be read; the file seems to be cut short")
        if abs(latest) > UNEVEN:
            problem = f"a frame comes {latest:+.1f} frames from where {self.fps:.4g} frames a second would have it"
            _warn(self.path, f"{problem}; make the rate constant first, for instance with ffmpeg -vsync cfr")


def open_film(path: Path) -> Film:
    """A video, or a folder of pictures.

    Raises FileError if it is missing, holds no pictures, or cannot be read.
    """
    if path.is_dir():
        return _open_folder(path)
    if not path.is_file():
        raise FileError(path, "there is no such film; name a video, or a folder of pictures")
    with _opened(path) as video:
        whole, picture = video.read()
        if not whole:
            raise FileError(path, "is no video that OpenCV can read; convert it to H.264, or to a folder of pictures")
        count, fps = video.get(cv2.CAP_PROP_FRAME_COUNT), video.get(cv2.CAP_PROP_FPS)
    height, width = picture.shape[:2]
    known = math.isfinite(fps) and 0.0 < fps <= FASTEST
    frames = int(count) if math.isfinite(count) and count > 0 else 0
    return Film(path=path, files=(), width=width, height=height, frames=frames, fps=fps if known else None)


def _open_folder(folder: Path) -> Film:
    files = sorted((file for file in folder.iterdir() if file.suffix.lower() in ENDINGS), key=_natural)
    if not files:
        raise FileError(
            folder, f"holds no pictures; wanted: {', '.join(ENDINGS)}, YOLO's labels, or one file of boxes, in it"
        )
    height, width = _read_picture(files[0]).shape[:2]
    return Film(path=folder, files=tuple(files), width=width, height=height, frames=len(files), fps=None)


def _natural(file: Path) -> list[tuple[int, str]]:
    """Numbers in names count as numbers: 9.png comes before 10.png."""
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in re.split(r"([0-9]+)", file.name)]


def _read_picture(file: Path) -> NDArray[np.uint8]:
    picture = cv2.imdecode(np.fromfile(file, np.uint8), cv2.IMREAD_COLOR) if file.stat().st_size else None
    if picture is None:
        raise FileError(file, "is no picture that OpenCV can read")
    return np.asarray(picture, np.uint8)


@contextmanager
def _silently() -> Iterator[None]:
    """OpenCV and FFmpeg print nothing: what is wrong is said by us."""
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    finally:
        cv2.utils.logging.setLogLevel(level)


@contextmanager
def _opened(path: Path) -> Iterator[cv2.VideoCapture]:
    with _silently():
        video = cv2.VideoCapture(str(path))
        try:
            yield video
        finally:
            video.release()


def _warn(path: Path, problem: str) -> None:
    warnings.warn(VbbenchWarning(f"{path}: {problem}"), stacklevel=3)
