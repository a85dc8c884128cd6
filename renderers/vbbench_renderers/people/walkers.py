"""The people of a scene as limbs to be drawn, at any frame."""

from dataclasses import fields

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.scene import Scene
from vbbench_renderers.meshes import Limbs
from vbbench_renderers.people.bodies import LEVELS, NAMES, library
from vbbench_renderers.people.gait import Feet, Moment, Style, moment_at, place_feet, pose_bones, trace_paths
from vbbench_renderers.people.looks import Look, make_look

NEAR, NEAR_FOCAL = (8.0, 20.0), 640.0
"""Distances in m beyond which the next level of detail is drawn at this focal length in px: people of 136 and 54 px."""
USUAL_HEIGHT = 1.7


class Walkers:
    """Everybody in a scene.

    Parameters
    ----------
    scene : who walks where; an unknown height is 1.7 m.
    seed : looks follow from it and the person's id, whoever else is there.
    """

    levels = LEVELS
    meshes = library()
    """The limb meshes of all levels of detail, the finest level first."""

    def __init__(self, scene: Scene, seed: int) -> None:
        heights = np.where(np.isnan(scene.heights), USUAL_HEIGHT, scene.heights)
        self.looks: tuple[Look, ...] = tuple(
            make_look(seed, int(person), float(height)) for person, height in zip(scene.people, heights, strict=True)
        )
        self.heights: FloatArray = heights
        self._style = _stack_styles(self.looks)
        self._paths = trace_paths(scene, heights, self._style.stride, self._style.start)
        self._parts = _PartTable(self.looks)

    def feet(self, frame: float) -> Feet:
        """Where the feet are at a frame."""
        return self._feet(moment_at(self._paths, frame))

    def bones(self, frame: float) -> tuple[IntArray, FloatArray]:
        """Columns [N] of the people who are present, and the transforms [N, 18, 3, 4] of their bones."""
        moment = moment_at(self._paths, frame)
        return moment.person, pose_bones(moment, self._feet(moment), self._style.of(moment.person))

    def limbs(self, frame: float, eye: FloatArray, focal: float = 640.0, *, without: int | None = None) -> Limbs:
        """The limbs to draw; their meshes are of `meshes`.

        Parameters
        ----------
        frame : frame of the scene; fractions lie in between.
        eye : [2] where the camera is, in m.
        focal : its focal length in px, which with the distance gives the size of a person in the picture.
        without : column of a person who is not drawn.
        """
        people, bones = self.bones(frame)
        if without is not None:
            people, bones = people[people != without], bones[people != without]
        distance = np.hypot(*(bones[:, 0, :2, 3] - eye).T)
        return self._parts.placed(people, bones, np.searchsorted(NEAR, distance * (NEAR_FOCAL / focal)))

    def _feet(self, moment: Moment) -> Feet:
        return place_feet(self._paths, moment, self._style.of(moment.person))


class _PartTable:
    """The parts of all looks, one row per part."""

    def __init__(self, looks: tuple[Look, ...]) -> None:
        parts = [part for look in looks for part in look.parts]
        number = {name: index for index, name in enumerate(NAMES)}
        self.person = np.repeat(np.arange(len(looks), dtype=np.int32), [len(look.parts) for look in looks])
        self.mesh = np.array([number[part.mesh] for part in parts], dtype=np.int64)
        self.bone = np.array([part.bone for part in parts], dtype=np.int64)
        self.coarsest = np.array([part.coarsest for part in parts], dtype=np.int64)
        self.scale = np.array([part.scale for part in parts]).reshape(-1, 1, 3)
        self.offset = np.array([part.offset for part in parts]).reshape(-1, 3, 1)
        self.colour = np.array([part.colour for part in parts], dtype=np.float32).reshape(-1, 3)
        self.second = np.array([part.second for part in parts], dtype=np.float32).reshape(-1, 3)
        self.pattern = np.array([part.pattern for part in parts], dtype=np.int32)
        self.gloss = np.array([part.gloss for part in parts], dtype=np.float32)

    def placed(self, people: IntArray, bones: FloatArray, level: IntArray) -> Limbs:
        """The limbs of some people [N], whose bones [N, 18, 3, 4] are given, at their levels of detail [N]."""
        row = np.full(int(self.person.max(initial=-1)) + 1, -1, dtype=np.int64)
        row[people] = np.arange(len(people))
        owner = row[self.person]
        chosen = np.flatnonzero((owner >= 0) & (self.coarsest >= np.append(level, LEVELS)[owner]))
        owner = owner[chosen]
        bone = bones[owner, self.bone[chosen]]
        transform = np.empty((len(chosen), 3, 4), dtype=np.float32)
        transform[..., :3] = bone[..., :3] * self.scale[chosen]
        transform[..., 3] = bone[..., 3] + (bone[..., :3] @ self.offset[chosen])[..., 0]
        return Limbs(
            mesh=(self.mesh[chosen] + len(NAMES) * level[owner]).astype(np.int32),
            transform=transform,
            colour=self.colour[chosen],
            second_colour=self.second[chosen],
            pattern=self.pattern[chosen],
            gloss=self.gloss[chosen],
            person=self.person[chosen].astype(np.int32),
        )


def _stack_styles(looks: tuple[Look, ...]) -> Style:
    shape = {"stance", "arm_swing", "arm_forward", "arm_aside", "arm_inward", "elbow"}
    return Style(
        **{
            item.name: np.array([look.style[item.name] for look in looks]).reshape(-1, *[2] * (item.name in shape))
            for item in fields(Style)
        }
    )
