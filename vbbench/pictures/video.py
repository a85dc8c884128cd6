"""Writes the frames of a film: as an mp4 file, or a folder of PNG files that can be continued."""

import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, VbbenchError, needs_extra
from vbbench.folders.locks import locked
from vbbench.folders.replacing import is_unused, replacing, write_bytes_atomically, write_text_atomically

with needs_extra("render", "writing pictures and films"):
    import cv2

Codec = Literal["h264", "vp9", "mpeg4"]
Frames = Callable[[Iterable[int]], Iterator[NDArray[np.uint8]]]
"""Makes the pictures [H, W, 3] (sRGB) of the requested frames, one by one."""

KEY_FILE = "film.txt"
"""In a folder of frames: the key of their film."""

_CODES: dict[Codec, str] = {"h264": "avc1", "vp9": "vp09", "mpeg4": "mp4v"}
"""Four-letter codes in order of preference: browsers play the first two, but not every OpenCV has the first."""
_PNG_LEVEL = 3
"""Of zlib: about as small as the default, and three times as fast."""


def write_mp4(
    path: Path, frames: Frames, count: int, fps: float, codec: Codec | None = None, done: Callable[[], object] = int
) -> None:
    """Write frames 0 … ``count`` − 1 as an mp4 file, which appears when it is whole.

    Parameters
    ----------
    path : the file; an existing one is replaced.
    frames : makes the pictures, of even width and height.
    count : number of frames.
    fps : frames per second.
    codec : ``None`` for the first of H.264, VP9 and MPEG-4 that this OpenCV can write.
    done : called after every frame.

    Raises VbbenchError if the codec is not available, or the file cannot be written.
    """
    if not (np.isfinite(fps) and 0.0 < fps <= 1000.0):
        raise VbbenchError(f"fps must be above 0 and at most 1000, not {fps:g}")
    writer: cv2.VideoWriter | None = None
    with replacing(path, path.suffix) as temporary:
        try:
            for picture in frames(range(count)):
                if writer is None:
                    writer = _open_writer(temporary, fps, (picture.shape[1], picture.shape[0]), codec)
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

    Parameters
    ----------
    folder : the folder; created if needed. Frames of another film, with another key, are replaced.
    frames : makes the pictures.
    count : number of frames.
    key : identifies the film; the same key must mean the same pictures.
    done : called for every frame, new or existing.

    Raises FileError if the folder is a file, or holds something other than frames.
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
    film = cv2.VideoCapture(str(path))
    try:
        return int(film.get(cv2.CAP_PROP_FRAME_COUNT)) if film.isOpened() else 0
    finally:
        film.release()


def _open_writer(path: Path, fps: float, size: tuple[int, int], codec: Codec | None) -> cv2.VideoWriter:
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # a missing codec is expected
    level = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        for name in [codec] if codec else list(_CODES):
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*_CODES[name]), fps, size)
            if writer.isOpened():
                return writer
            writer.release()
    finally:
        cv2.utils.logging.setLogLevel(level)
    if codec:
        raise VbbenchError(f"this OpenCV cannot write {codec}; remove the codec, or name a folder for PNG files")
    raise VbbenchError(f"{path.parent}: no film can be written here; name a folder for PNG files instead")
