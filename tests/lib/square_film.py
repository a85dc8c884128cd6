"""A film of a white square that moves over a red ground, as a video or a folder of pictures."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from vbbench.pictures.video import write_mp4

FRAMES, WIDTH, HEIGHT = 12, 96, 64


def drawn(frame: int) -> Any:
    """A white square that moves 5 px a frame over a red ground."""
    picture = np.full((HEIGHT, WIDTH, 3), (180, 0, 0), np.uint8)
    picture[20:50, 10 + 5 * frame : 20 + 5 * frame] = 255
    return picture


def write_video(path: Path, fps: float = 10.0) -> Path:
    """Write the film as a video."""
    write_mp4(path, lambda frames: map(drawn, frames), FRAMES, fps)
    return path


def write_folder(folder: Path, name: str = "{}.png") -> Path:
    """Write the film as pictures."""
    folder.mkdir(parents=True)
    for frame in range(FRAMES):
        cv2.imwrite(str(folder / name.format(frame)), drawn(frame)[..., ::-1])
    return folder
