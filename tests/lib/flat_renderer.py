"""A stand-in for a renderer: people are flat boxes of one colour, the ground and the sky are two more."""

import weakref
from typing import Any, ClassVar

import numpy as np

from vbbench.boxes import rectangles
from vbbench.camera import Camera
from vbbench.geometry import world_to_relative
from vbbench.pictures.rendering import Picture
from vbbench.scene import Scene
from vbbench.sequence import NOBODY


class FlatRenderer:
    """Draws whoever the camera projects, far ones first."""

    device = "a sheet of paper"
    made: ClassVar["list[FlatRenderer]"] = []

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        self.scene, self.seed, self.surroundings = scene, seed, surroundings
        self.frames: list[int] = []
        self.alive: list[weakref.ref[Picture]] = []
        self.most = 0
        self.closed = False
        FlatRenderer.made.append(self)

    def render(self, frame: int, camera: Camera, pose: Any, *, observer: int | None = None) -> Picture:
        self.frames.append(frame)
        width, height = camera.picture_size
        rgb = np.full((height, width, 3), (135, 180, 215), np.uint8)
        rgb[height // 2 :] = (120, 115, 105)
        depth, ids = np.full((height, width), np.inf, np.float32), np.full((height, width), NOBODY)
        relative = world_to_relative(self.scene.positions[frame], pose)
        reach, boxes = camera.depth(relative), rectangles(camera.project(relative, self.scene.heights))
        for k in np.argsort(-np.nan_to_num(reach)):
            if np.isnan(boxes[k]).any() or self.scene.people[k] == observer:
                continue
            left, top, right, bottom = (round(float(x)) for x in (*boxes[k, :2], *(boxes[k, :2] + boxes[k, 2:])))
            where = slice(max(top, 0), max(bottom, 0)), slice(max(left, 0), max(right, 0))
            rgb[where] = np.random.default_rng(int(self.scene.people[k])).integers(30, 220, 3)
            depth[where], ids[where] = reach[k], self.scene.people[k]
        picture = Picture(rgb=rgb, depth=depth, ids=ids)
        self.alive = [ref for ref in [*self.alive, weakref.ref(picture)] if ref() is not None]
        self.most = max(self.most, len(self.alive))
        return picture

    def close(self) -> None:
        self.closed = True
