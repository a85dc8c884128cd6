"""What a person looks like and how they move, invented from only the seed and the person's id, garment by garment."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench.parsing.toml_text import bundled_table
from vbbench_renderers.meshes import Pattern, srgb_to_linear
from vbbench_renderers.people.bodies import MID_TORSO, NAMES, top_of
from vbbench_renderers.people.gait import CHIN, FOREARM, SHIN, THIGH, UPPER_ARM, Bone

Triple = tuple[float, float, float]
ONE: Triple = (1.0, 1.0, 1.0)
MID_ARM, MID_FOREARM, WRIST = (0.0, 0.0, -0.5 * UPPER_ARM), (0.0, 0.0, -0.5 * FOREARM), (0.0, 0.0, -FOREARM)
MID_THIGH, MID_SHIN = (0.0, 0.0, -0.5 * THIGH), (0.0, 0.0, -0.5 * SHIN)

_TABLE: dict[str, dict[str, Any]] = bundled_table(__package__, "wardrobe.toml")
COLOURS: dict[str, list[str]] = {name: colours.split() for name, colours in _TABLE["colours"].items()}
SHARES = _TABLE["shares"]


def linear(code: str) -> FloatArray:
    """Linear RGB [3] of a colour written as six hexadecimal digits of sRGB (IEC 61966-2-1)."""
    return srgb_to_linear(np.frombuffer(bytes.fromhex(code), np.uint8).astype(np.float32) / 255.0).astype(np.float64)


PART = np.dtype(
    [
        *((name, np.int32) for name in ("mesh", "bone", "coarsest", "pattern")),
        *((name, float, 3) for name in ("scale", "offset")),
        *((name, np.float32, 3) for name in ("colour", "second_colour")),
        ("gloss", np.float32),
    ]
)
"""One limb of a look.

mesh : number in `NAMES`.
bone : of `Bone`, that it hangs from.
coarsest : last level of detail at which it is drawn.
pattern : a `Pattern`, where the second colour shows.
scale : along the limb's own axes.
offset : of its origin from the bone's, in the bone's frame, in m for 1.75 m.
colour, second_colour : linear RGB.
gloss : 0 … 1.
"""


@dataclass(frozen=True, kw_only=True)
class Look:
    """A person to be drawn.

    Parameters
    ----------
    kind : what distinguishes this look: sex, age, build, garments and colours.
    parts : [P] limbs, rows of `PART`.
    style : one row of `vbbench_renderers.people.gait.STYLE`, by name.
    """

    kind: tuple[str, ...]
    parts: NDArray[np.void]
    style: dict[str, float | FloatArray] = field(repr=False)


@dataclass
class Outfit:
    """A look that is being assembled."""

    rng: np.random.Generator
    woman: bool
    age: str
    girth: float
    skin: FloatArray
    hair: FloatArray
    torso: str = ""
    outer: str = ""
    cloth: FloatArray | None = None
    kind: list[str] = field(default_factory=list)
    parts: list[tuple[Any, ...]] = field(default_factory=list)

    @property
    def sex(self) -> str:
        """Ending of the names of meshes."""
        return "woman" if self.woman else "man"

    def choose(self, shares: dict[str, float]) -> str:
        """One of the names, by their shares."""
        return self.pick(list(shares), np.array(list(shares.values())) / sum(shares.values()))

    def usual(self, what: str) -> str:
        """One of the names of a thing, by the shares of men or of women."""
        return self.choose(SHARES[self.sex][what])

    def colour(self, name: str) -> FloatArray:
        """A colour of a palette, varied a little."""
        return np.clip(linear(self.pick(COLOURS[name])) * self.rng.uniform(0.85, 1.15), 0.0, 1.0)

    def pick(self, options: list[str], shares: FloatArray | None = None) -> str:
        """One of the options, recorded as part of this look."""
        self.kind.append(options[int(self.rng.choice(len(options), p=shares))])
        return self.kind[-1]

    def add(
        self,
        mesh: str,
        bone: int,
        colour: FloatArray,
        second: FloatArray | None = None,
        *,
        scale: Triple = ONE,
        offset: Triple = (0.0, 0.0, 0.0),
        pattern: Pattern = Pattern.PLAIN,
        gloss: float = 0.0,
        coarsest: int = 2,
    ) -> None:
        """Put something on, as in `PART`."""
        dyes = colour, colour if second is None else second
        self.parts.append((NAMES.index(mesh), bone, coarsest, pattern, scale, offset, *dyes, gloss))

    def drape(self, mesh: str, colour: FloatArray, scale: Triple) -> None:
        """A skirt: four copies that overlap; from far away two are enough."""
        for number in range(4):
            self.add(mesh, Bone.SKIRT + number, colour, scale=scale, coarsest=2 if number in (0, 3) else 1)

    def pair(self, mesh: str, bone: int, colour: FloatArray, **more: Any) -> None:
        """The same on the left and on the right."""
        for side in (0, 1):
            self.add(mesh, bone + side, colour, **more)


def _add_head(who: Outfit) -> None:
    """Head, neck and hair."""
    scale = (1.0, 1.0 + 0.25 * (who.girth - 1.0), 1.0)
    who.add(f"head {who.sex}", Bone.HEAD, who.skin, scale=scale, gloss=0.12)
    who.add("eyes", Bone.HEAD, linear(COLOURS["white"][0]), scale=scale, gloss=0.3, coarsest=0)
    thick = (0.86 if who.woman else 1.0) * (0.9 + 0.1 * who.girth)
    who.add("neck", Bone.NECK, who.skin, scale=(thick, thick, 1.0), gloss=0.1, coarsest=1)
    hair = who.usual("old_hair" if who.age == "old" else "hair")
    if hair != "bald":
        who.add(hair, Bone.HEAD, who.hair, scale=scale, gloss=0.25)
    if hair == "hair tied":
        who.add(who.pick(["bun", "pony tail"]), Bone.HEAD, who.hair, gloss=0.25)


def _add_top(who: Outfit) -> None:
    """Shirt, sweater, jacket or coat, with its sleeves and the hands."""
    kind = who.usual("top")
    outer = kind in ("jacket", "coat", "suit")
    colour = who.colour("coats" if outer else "tops")
    pattern = Pattern.PLAIN if outer else Pattern[who.choose(SHARES["pattern"]).upper()]
    second = who.colour("tops") if pattern else colour
    inner = "torso heavy" if who.girth > 1.12 else f"torso {who.sex}"
    who.torso = base = ("jacket woman" if who.woman else "jacket") if outer else inner
    who.cloth, who.outer = None if outer else colour, kind if outer else ""
    wide = (who.girth, who.girth, 1.0)
    who.add(base, Bone.CHEST, colour, second, scale=wide, offset=(0.0, 0.0, MID_TORSO), pattern=pattern)
    if outer:
        shirt = who.colour("shirts" if kind == "suit" else "tops")
        cut = "buttoned" if kind == "suit" or who.rng.random() < 0.4 else "open"
        who.add(f"{cut} {base}", Bone.CHEST, shirt, scale=(who.girth, 1.0, 1.0), coarsest=1)
    slim = 0.94 if who.woman else 1.0
    if kind == "coat":
        who.drape("coat hem", colour, (who.girth, who.girth * slim, float(who.rng.uniform(0.9, 1.35))))
    if kind in ("coat", "suit", "shirt"):
        who.add("collar", Bone.CHEST, colour, scale=(0.95, 0.9 if who.woman else 1.0, 1.0), coarsest=1)
    short = kind == "tee" or (kind == "shirt" and who.rng.random() < 0.3)
    _add_arms(who, colour, second, pattern, short)


def _add_arms(who: Outfit, colour: FloatArray, second: FloatArray, pattern: Pattern, short: bool) -> None:
    thick = who.girth * (0.86 if who.woman else 1.0)
    scale = (thick, thick, 1.0)
    cloth = {"second": second, "pattern": pattern, "scale": scale}
    if short:
        who.pair("upper arm", Bone.UPPER_ARM, who.skin, scale=scale, offset=MID_ARM, gloss=0.1, coarsest=1)
        who.pair("short sleeve", Bone.UPPER_ARM, colour, offset=MID_ARM, **cloth)
        who.pair("forearm", Bone.FOREARM, who.skin, scale=scale, offset=MID_FOREARM, gloss=0.1)
    else:
        who.pair("sleeve", Bone.UPPER_ARM, colour, offset=MID_ARM, **cloth)
        who.pair("forearm sleeve", Bone.FOREARM, colour, offset=MID_FOREARM, **cloth)
    size = 0.92 if who.woman else 1.0
    for side, name in enumerate(("left hand", "right hand")):
        who.add(name, Bone.FOREARM + side, who.skin, scale=(size, size, size), offset=WRIST, gloss=0.1)


def _add_bottom(who: Outfit) -> None:
    """Trousers, shorts or a skirt, and shoes."""
    kind = who.usual("bottom")
    skirt = "skirt" in kind
    thick = who.girth * (1.0 if who.woman else 0.97)
    scale = (thick, thick, 1.0)
    colour = who.colour("skirts" if skirt else "trousers")
    if skirt and who.cloth is not None and who.rng.random() < 0.35:
        colour = who.cloth
        who.kind.append("dress")
    who.add(f"hips {who.sex}", Bone.PELVIS, colour, scale=(who.girth, who.girth, 1.0), coarsest=1)
    bare = linear(COLOURS["stocking"][0]) if skirt and who.rng.random() < 0.4 else who.skin
    if kind in ("jeans", "trousers"):
        loose = kind == "trousers"
        who.pair("loose thigh" if loose else "thigh", Bone.THIGH, colour, scale=scale, offset=MID_THIGH)
        who.pair("loose shin" if loose else "slim shin", Bone.SHIN, colour, scale=scale, offset=MID_SHIN)
    else:
        slim, coarsest = (0.94 * thick, 0.94 * thick, 1.0), 2 if kind == "shorts" else 1
        who.pair("thigh", Bone.THIGH, bare, scale=slim, offset=MID_THIGH, coarsest=coarsest)
        who.pair("shin", Bone.SHIN, bare, scale=scale, offset=MID_SHIN, gloss=0.08)
    if kind == "shorts":
        who.pair("shorts leg", Bone.THIGH, colour, scale=scale, offset=MID_THIGH)
    if skirt:
        ease = {"coat": 0.84, "": 1.08}.get(who.outer, 0.92)
        wide = who.girth * (0.97 if who.torso == "torso heavy" else ease)
        who.drape(kind, colour, (wide, wide, 1.0))
    narrow = (1.0, 0.88 if who.woman else 1.0, 1.0)
    who.pair("shoe", Bone.FOOT, who.colour("shoes"), scale=narrow, gloss=0.3)
    pale = linear(COLOURS["white" if who.rng.random() < 0.6 else "black"][0])
    who.pair("sole", Bone.FOOT, pale, scale=narrow, coarsest=0)


def _add_bag(who: Outfit) -> None:
    """A backpack, or nothing."""
    if who.usual("bag") == "backpack":
        colour = who.colour("bags")
        back = {"jacket": 0.0, "jacket woman": 0.010, "torso woman": 0.025}.get(who.torso, 0.014)
        who.add("backpack", Bone.CHEST, colour, offset=(back - 0.10 * (who.girth - 1.0), 0.0, 0.0))
        who.add(f"straps {who.torso}", Bone.CHEST, colour, scale=(who.girth, who.girth, 1.0), coarsest=1)


def make_look(seed: int, person: int, height: float) -> Look:
    """The look of a person of a height in m."""
    rng = np.random.default_rng([seed % 2**63, person % 2**63])
    woman = bool(rng.random() < np.clip(0.5 - 3.0 * (height - 1.70), 0.1, 0.9))
    age = str(rng.choice(["young", "grown", "old"], p=[0.35, 0.47, 0.18]))
    girth = float(np.clip(rng.normal({"young": 0.96, "grown": 1.03, "old": 1.06}[age], 0.065), 0.88, 1.22))
    hair = COLOURS["grey" if age == "old" else "hair"]
    skin = rng.choice(len(COLOURS["skin"]), p=SHARES["skin"])
    shares = np.array(SHARES["hair_colour"]) * (np.arange(8) < (8 if skin < 5 else 2)) if age != "old" else np.ones(4)
    tress = rng.choice(len(hair), p=shares / shares.sum())
    who = Outfit(
        rng=rng, woman=woman, age=age, girth=girth, skin=linear(COLOURS["skin"][skin]), hair=linear(hair[tress])
    )
    who.kind += [who.sex, age, f"{girth:.1f}", COLOURS["skin"][skin], hair[tress]]
    _add_head(who)
    _add_top(who)
    _add_bottom(who)
    _add_bag(who)
    parts = np.array(who.parts, PART)
    on_head = parts[parts["bone"] == Bone.HEAD]
    crown = max(part["offset"][2] + part["scale"][2] * top_of(part["mesh"]) for part in on_head)
    return Look(kind=tuple(who.kind), parts=parts, style=_manner(who, height / (CHIN + crown)))


def _manner(who: Outfit, size: float) -> dict[str, float | FloatArray]:
    """The style of a `Look`."""
    rng, old, stout = who.rng, who.age == "old", max(who.girth - 1.0, 0.0)
    return {
        "arm_swing": rng.uniform(0.25, 0.5) * (0.7 if old else 1.0),
        "arm_forward": rng.uniform(-0.05, 0.05),
        "elbow": rng.uniform(0.15, 0.45),
        "arm_aside": rng.uniform(0.06, 0.11) + 0.45 * stout,
        "arm_inward": rng.uniform(0.1, 0.4),
        "size": size,
        "shoulders": (0.88 if who.woman else 1.0) * (0.6 + 0.4 * who.girth),
        "hips": 0.6 + 0.4 * who.girth,
        "track": (0.040 if who.woman else 0.052) + 0.25 * stout,
        "stance": rng.uniform(-0.035, 0.035) * np.array([1.0, -1.0]),
        "stride": rng.uniform(0.95, 1.06) * (0.88 if old else 1.0) * (0.97 if who.girth > 1.12 else 1.0),
        "start": rng.uniform(0.0, 1.0),
        "stoop": rng.uniform(0.03, 0.09) if old else rng.uniform(-0.005, 0.02),
        "glance": rng.normal(0.0, 0.35),
    }
