"""A synthetic recording of somebody's own camera, with its truth, as the files that users write."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vbbench.boxes import rectangles
from vbbench.camera import Camera, PerspectiveCamera
from vbbench.geometry import FloatArray, world_to_relative

CAMERA_TOML = """\
width = 1280
height = 720
focal = 700.0
mount_height = 1.5
fps = 10
"""
HEAD = "frame,id,left,top,width,height\n"
"""The first line of ``boxes.csv``."""


@dataclass(frozen=True, kw_only=True)
class Walk:
    """Somebody walks among people who cross, with ids from 1 on.

    Parameters
    ----------
    camera : the camera.
    dt : seconds per frame.
    poses : [T, 3] of the camera.
    people : [T, K, 2] in m; ``heights`` [K].
    boxes : [T, K, 4] (left, top, width, height) in px, NaN = not seen.
    """

    camera: Camera
    dt: float
    poses: FloatArray
    people: FloatArray
    heights: FloatArray
    boxes: FloatArray

    @property
    def rows(self) -> list[tuple[int, int, list[float]]]:
        """Frame, id and box of everybody seen."""
        seen = np.argwhere(np.isfinite(self.boxes[..., 0]))
        return [(int(t), int(k) + 1, self.boxes[t, k].tolist()) for t, k in seen]


def make_walk(
    frames: int = 60, people: int = 8, noise: float = 1.0, seed: int = 0, *, across: float = 0.0, **camera: float
) -> Walk:
    """A walk of ``frames`` at 10 Hz, boxes off by ``noise`` px; people also walk ``across`` m/s to a side."""
    rng, dt = np.random.default_rng(seed), 0.1
    time = dt * np.arange(frames)
    facts = {"width": 1280, "height": 720, "focal": 700.0, "cx": 640.0, "cy": 360.0, "mount_height": 1.5, **camera}
    model = PerspectiveCamera(**facts)  # type: ignore[arg-type]
    poses = np.stack([1.0 * time, 0.3 * np.sin(0.4 * time), 0.05 * np.sin(0.3 * time)], axis=-1)
    start = np.stack([rng.uniform(6.0, 14.0, people), rng.uniform(-3.0, 3.0, people)], axis=-1)
    velocity = np.array([1.0, 0.0]) + rng.normal(0.0, 0.25, (people, 2))
    velocity[:, 1] -= across * np.sign(start[:, 1])
    places = start + time[:, None, None] * velocity + 0.1 * np.sin(time[:, None, None] + rng.uniform(0, 6, (people, 2)))
    heights = rng.normal(1.72, 0.07, people)
    boxes = model.project(world_to_relative(places, poses), np.broadcast_to(heights, (frames, people)))
    flat = rectangles(boxes)
    return Walk(
        camera=model,
        dt=dt,
        poses=poses,
        people=places,
        heights=heights,
        boxes=flat + rng.normal(0.0, noise, flat.shape) * [1.0, 1.0, 0.0, 1.0] if noise else flat,
    )


def write_mot(path: Path, walk: Walk, *, linked: bool = True) -> Path:
    """MOTChallenge text, frames and px from 1."""
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [
        f"{t + 1},{k if linked else -1},{x + 1:.4f},{y + 1:.4f},{w:.4f},{h:.4f},1,-1,-1,-1\n"
        for t, k, (x, y, w, h) in walk.rows
    ]
    path.write_text("".join(lines))
    return path


def write_csv(path: Path, walk: Walk, *, begin: float | None = None) -> Path:
    """CSV with a header; with ``begin`` time stamps from then on."""
    lines = ["frame,id,left,top,width,height\n" if begin is None else "time,id,left,top,width,height\n"]
    for t, k, box in walk.rows:
        when = t if begin is None else f"{begin + t * walk.dt:.4f}"
        lines.append(f"{when},{k},{','.join(f'{value:.4f}' for value in box)}\n")
    path.write_text("".join(lines))
    return path


def write_tum(path: Path, walk: Walk, *, begin: float = 0.0, every: float = 1.0) -> Path:
    """Poses of the walk, ``every`` of its frames."""
    wanted = np.arange(0.0, len(walk.poses) - 1 + 1e-9, every)
    at = np.stack([np.interp(wanted, np.arange(len(walk.poses)), column) for column in walk.poses.T], axis=-1)
    lines = [
        f"{begin + t * walk.dt:.6f} {x:.9f} {y:.9f} 1.5 0 0 {np.sin(yaw / 2):.12f} {np.cos(yaw / 2):.12f}\n"
        for t, (x, y, yaw) in zip(wanted, at, strict=True)
    ]
    path.write_text("".join(lines))
    return path


def write_people(path: Path, walk: Walk, *, relative: bool = False) -> Path:
    """Places and heights of everybody in the world of the poses, or ``relative`` to the camera (right, forward)."""
    lines = ["frame,id,x,y,height\n"]
    places = world_to_relative(walk.people, walk.poses) if relative else walk.people
    for t, k in np.ndindex(walk.people.shape[:2]):
        x, y = places[t, k]
        lines.append(f"{t},{k + 1},{x:.6f},{y:.6f},{walk.heights[k]:.4f}\n")
    path.write_text("".join(lines))
    return path


def write_folder(folder: Path, walk: Walk, *, camera: str = CAMERA_TOML) -> Path:
    """A folder with camera file and boxes."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "camera.toml").write_text(camera)
    write_csv(folder / "boxes.csv", walk)
    return folder
