"""What a person looks like and how they move; and the limb meshes of looks, by level of detail."""

from dataclasses import dataclass, field, fields
from functools import cache

from vbbench.geometry import FloatArray, IntArray
from vbbench_renderers.meshes import Mesh, Pattern
from vbbench_renderers.people.body import body_meshes
from vbbench_renderers.people.garments import garment_meshes
from vbbench_renderers.people.head import head_meshes
from vbbench_renderers.people.loft import LEVELS

Triple = tuple[float, float, float]
ONE: Triple = (1.0, 1.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Part:
    """One limb of a look.

    Parameters
    ----------
    mesh : name in the library.
    bone : index of the bone that it hangs from.
    scale : along the limb's own axes.
    offset : of its origin from the bone's, in the bone's frame, in m for 1.75 m.
    colour, second : linear RGB.
    pattern : where the second colour shows.
    gloss : 0 … 1.
    coarsest : last level of detail at which it is drawn.
    """

    mesh: str
    bone: int
    scale: Triple = ONE
    offset: Triple = (0.0, 0.0, 0.0)
    colour: FloatArray
    second: FloatArray
    pattern: Pattern = Pattern.PLAIN
    gloss: float = 0.0
    coarsest: int = 2


@dataclass(frozen=True, kw_only=True)
class Style:
    """Build and way of walking, one row per person.

    Parameters
    ----------
    size : [N] the person's metres per metre of a person of 1.75 m.
    shoulders, hips : [N] relative breadth.
    track : [N] half the step width in m for 1.75 m.
    stance : [N, 2] how far in m the feet stand in front, when still.
    stride : [N] personal factor of the step length.
    start : [N] phase at which the person sets out.
    stoop : [N] how far in m the neck is before the hips.
    glance : [N] rad that the head turns to the left when still.
    arm_swing, arm_forward, arm_aside, arm_inward, elbow : [N, 2] rad.
    """

    size: FloatArray
    shoulders: FloatArray
    hips: FloatArray
    track: FloatArray
    stance: FloatArray
    stride: FloatArray
    start: FloatArray
    stoop: FloatArray
    glance: FloatArray
    arm_swing: FloatArray
    arm_forward: FloatArray
    arm_aside: FloatArray
    arm_inward: FloatArray
    elbow: FloatArray

    def of(self, people: IntArray) -> "Style":
        """The rows of some people."""
        return Style(**{item.name: getattr(self, item.name)[people] for item in fields(self)})


@dataclass(frozen=True, kw_only=True)
class Look:
    """A person to be drawn.

    Parameters
    ----------
    kind : what tells this look from others: sex, age, build, garments and colours.
    parts : the limbs.
    style : one row of `Style`, by name.
    """

    kind: tuple[str, ...]
    parts: tuple[Part, ...]
    style: dict[str, FloatArray] = field(repr=False)


def crown_of(parts: tuple[Part, ...], head_bone: int) -> float:
    """Height in m for 1.75 m of the top of head, hair and hat over the chin."""
    return max(part.offset[2] + part.scale[2] * top_of(part.mesh) for part in parts if part.bone == head_bone)


_MAKERS = body_meshes() | head_meshes() | garment_meshes()
NAMES = tuple(_MAKERS)
"""What each mesh of the library is."""


@cache
def library() -> tuple[Mesh, ...]:
    """The meshes of all levels, the finest first, each in the order of `NAMES`."""
    return tuple(make(level) for level in range(LEVELS) for make in _MAKERS.values())


@cache
def top_of(name: str) -> float:
    """Height in m of the highest point of a mesh in its own frame."""
    return float(library()[NAMES.index(name)].vertices[:, 2].max())
