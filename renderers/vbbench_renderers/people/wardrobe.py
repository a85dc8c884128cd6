"""Draws a look at random: who, what they wear and carry, in colours that go together."""

from dataclasses import dataclass, field

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Pattern
from vbbench_renderers.people.looks import Part, Triple
from vbbench_renderers.people.palette import linear
from vbbench_renderers.people.skeleton import Bone

Rng = np.random.Generator


@dataclass
class Outfit:
    """A look that is being assembled."""

    rng: Rng
    woman: bool
    age: str
    girth: float
    skin: FloatArray
    hair: FloatArray
    torso: str = ""
    outer: str = ""
    cloth: FloatArray | None = None
    kind: list[str] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)

    def choose(self, options: tuple[str, ...], shares: tuple[float, ...] | None = None) -> str:
        """One of the options, recorded as part of this look."""
        weights = None if shares is None else np.array(shares) / sum(shares)
        chosen = options[int(self.rng.choice(len(options), p=weights))]
        self.kind.append(chosen)
        return chosen

    def colour(self, options: tuple[str, ...]) -> FloatArray:
        """A colour of a palette, varied a little."""
        return np.clip(linear(self.choose(options)) * self.rng.uniform(0.85, 1.15), 0.0, 1.0)

    def add(
        self,
        mesh: str,
        bone: int,
        colour: FloatArray,
        *,
        scale: Triple = (1.0, 1.0, 1.0),
        offset: Triple = (0.0, 0.0, 0.0),
        second: FloatArray | None = None,
        pattern: Pattern = Pattern.PLAIN,
        gloss: float = 0.0,
        coarsest: int = 2,
    ) -> None:
        """Put something on."""
        second = colour if second is None else second
        self.parts.append(
            Part(
                mesh=mesh,
                bone=int(bone),
                scale=scale,
                offset=offset,
                colour=colour,
                second=second,
                pattern=pattern,
                gloss=gloss,
                coarsest=coarsest,
            )
        )

    def drape(self, mesh: str, colour: FloatArray, scale: Triple) -> None:
        """A skirt: four copies that overlap; from far away two are enough."""
        for number in range(4):
            self.add(mesh, Bone.SKIRT + number, colour, scale=scale, coarsest=2 if number in (0, 3) else 1)

    def pair(self, mesh: str, bone: int, colour: FloatArray, **more: object) -> None:
        """The same on the left and on the right."""
        for side in (0, 1):
            self.add(mesh, bone + side, colour, **more)  # type: ignore[arg-type]
