"""People as limbs to be drawn at any frame: bodies, looks and gait, invented from a seed and a person's id."""

import numpy as np

import vbbench_renderers.required  # noqa: F401 (says what to install)
from vbbench.geometry import FloatArray, IntArray
from vbbench.scene import Scene
from vbbench_renderers.meshes import Limbs
from vbbench_renderers.people.bodies import LEVELS, NAMES, library
from vbbench_renderers.people.gait import STYLE, Feet, Moment, moment_at, place_feet, pose_bones, trace_paths
from vbbench_renderers.people.looks import PART, Look, make_look

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
        self._style = np.array([tuple(look.style[name] for name in STYLE.names or ()) for look in self.looks], STYLE)
        self._paths = trace_paths(scene, heights, self._style["stride"], self._style["start"])
        self._parts = np.concatenate([np.empty(0, PART), *(look.parts for look in self.looks)])
        self._owners = np.repeat(np.arange(len(self.looks), dtype=np.int32), [len(look.parts) for look in self.looks])

    def feet(self, frame: float) -> Feet:
        """Where the feet are at a frame."""
        return self._feet(moment_at(self._paths, frame))

    def bones(self, frame: float) -> tuple[IntArray, FloatArray]:
        """Columns [N] of the people who are present, and the transforms [N, 18, 3, 4] of their bones."""
        moment = moment_at(self._paths, frame)
        return moment.person, pose_bones(moment, self._feet(moment), self._style[moment.person])

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
        return self._placed(people, bones, np.searchsorted(NEAR, distance * (NEAR_FOCAL / focal)))

    def _feet(self, moment: Moment) -> Feet:
        return place_feet(self._paths, moment, self._style[moment.person])

    def _placed(self, people: IntArray, bones: FloatArray, level: IntArray) -> Limbs:
        """The limbs of some people [N], whose bones [N, 18, 3, 4] are given, at their levels of detail [N]."""
        row = np.full(len(self.looks), -1, dtype=np.int64)
        row[people] = np.arange(len(people))
        owner = row[self._owners]
        chosen = np.flatnonzero((owner >= 0) & (self._parts["coarsest"] >= np.append(level, LEVELS)[owner]))
        owner, part = owner[chosen], self._parts[chosen]
        bone = bones[owner, part["bone"]]
        transform = np.empty((len(chosen), 3, 4), dtype=np.float32)
        transform[..., :3] = bone[..., :3] * part["scale"][:, None]
        transform[..., 3] = bone[..., 3] + (bone[..., :3] @ part["offset"][..., None])[..., 0]
        return Limbs(
            mesh=(part["mesh"] + len(NAMES) * level[owner]).astype(np.int32),
            transform=transform,
            person=self._owners[chosen],
            **{name: part[name] for name in ("colour", "second_colour", "pattern", "gloss")},
        )
