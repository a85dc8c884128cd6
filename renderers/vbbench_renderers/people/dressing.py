"""Invents people from only the seed and the person's id: an outfit, garment by garment, and a way of walking."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.meshes import Pattern
from vbbench_renderers.people import palette
from vbbench_renderers.people.body import MID_TORSO
from vbbench_renderers.people.looks import Look, crown_of
from vbbench_renderers.people.palette import linear
from vbbench_renderers.people.skeleton import CHIN, FOREARM, SHIN, THIGH, UPPER_ARM, Bone
from vbbench_renderers.people.wardrobe import Outfit

MID_ARM, MID_FOREARM, WRIST = (0.0, 0.0, -0.5 * UPPER_ARM), (0.0, 0.0, -0.5 * FOREARM), (0.0, 0.0, -FOREARM)
MID_THIGH, MID_SHIN = (0.0, 0.0, -0.5 * THIGH), (0.0, 0.0, -0.5 * SHIN)
PATTERN_OF = {
    "plain": Pattern.PLAIN,
    "rings": Pattern.RINGS,
    "checks": Pattern.CHECKS,
    "blocks": Pattern.LOWER_HALF,
    "stripes": Pattern.STRIPES,
}
WOMENS_HAIR = {"hair long": 0.3, "hair bob": 0.2, "hair tied": 0.3, "hair swept": 0.1, "hair curly": 0.1}
MENS_HAIR = {"hair short": 0.4, "hair crew": 0.25, "hair swept": 0.22, "hair curly": 0.07, "hair receding": 0.06}
OLD_MENS_HAIR = {"hair short": 0.4, "hair receding": 0.35, "bald": 0.25}
UNDER_HATS = ({"hair short": 0.5, "hair crew": 0.5}, {"hair long": 0.5, "hair tied": 0.5})


def add_head(who: Outfit) -> None:
    """Head, neck, hair, hat."""
    sex = "woman" if who.woman else "man"
    width = 1.0 + 0.25 * (who.girth - 1.0)
    who.add(f"head {sex}", Bone.HEAD, who.skin, scale=(1.0, width, 1.0), gloss=0.12)
    who.add("eyes", Bone.HEAD, linear(palette.WHITE), scale=(1.0, width, 1.0), gloss=0.3, coarsest=0)
    thick = (0.86 if who.woman else 1.0) * (0.9 + 0.1 * who.girth)
    who.add("neck", Bone.NECK, who.skin, scale=(thick, thick, 1.0), gloss=0.1, coarsest=1)
    hats = ("none", "cap", "beanie", "sun hat", "fedora", "head scarf")
    shares = (0.78, 0.05, 0.05, 0.05, 0.0, 0.07) if who.woman else (0.76, 0.12, 0.08, 0.0, 0.04, 0.0)
    hat = who.choose(hats, shares)
    if hat == "head scarf":
        colour = who.colour(palette.TOPS)
        who.add("scarf", Bone.HEAD, colour, scale=(1.0, width, 1.0))
        who.add("wrap", Bone.HEAD, colour, scale=(1.0, width, 1.0), coarsest=1)
        return
    usual = WOMENS_HAIR if who.woman else OLD_MENS_HAIR if who.age == "old" else MENS_HAIR
    shares_of = usual if hat == "none" else UNDER_HATS[who.woman]
    hair = who.choose(tuple(shares_of), tuple(shares_of.values()))
    if hair != "bald":
        who.add(hair, Bone.HEAD, who.hair, scale=(1.0, width, 1.0), gloss=0.25)
    if hair == "hair tied":
        who.add(who.choose(("bun", "pony tail")) if hat == "none" else "pony tail", Bone.HEAD, who.hair, gloss=0.25)
    if not who.woman and who.choose(("shaven", "beard"), (0.78, 0.22)) == "beard":
        who.add("beard", Bone.HEAD, 0.8 * who.hair, scale=(1.0, width, 1.0))
    _add_hat(who, hat, width)


def _add_hat(who: Outfit, hat: str, width: float) -> None:
    scale = (1.0, width, 1.0)
    if hat in ("cap", "beanie"):
        colour = who.colour(palette.TOPS)
        who.add(hat, Bone.HEAD, colour, scale=scale)
        if hat == "cap":
            who.add("peak", Bone.HEAD, colour, coarsest=1)
    elif hat in ("sun hat", "fedora"):
        colour = who.colour(("d9c69a", "e9e2d0", "3a2e26", "7a6a52"))
        who.add("crown", Bone.HEAD, colour, scale=scale)
        who.add("wide brim" if hat == "sun hat" else "narrow brim", Bone.HEAD, colour)


def add_top(who: Outfit) -> None:
    """Shirt, sweater, jacket or coat, with its sleeves and the hands."""
    kinds = ("tee", "shirt", "sweater", "hoodie", "jacket", "coat", "suit")
    shares = (0.24, 0.2, 0.14, 0.08, 0.12, 0.14, 0.02) if who.woman else (0.24, 0.2, 0.12, 0.12, 0.14, 0.08, 0.1)
    kind = who.choose(kinds, shares)
    outer = kind in ("jacket", "coat", "suit", "hoodie")
    colour = who.colour(palette.COATS if outer and kind != "hoodie" else palette.TOPS)
    pattern = PATTERN_OF["plain" if outer else who.choose(tuple(PATTERN_OF), (0.58, 0.14, 0.12, 0.09, 0.07))]
    second = who.colour(palette.TOPS) if pattern else colour
    who.torso = base = ("jacket woman" if who.woman else "jacket") if outer else _torso(who)
    who.cloth, who.outer = None if outer else colour, kind if outer else ""
    scale, offset = (who.girth, who.girth, 1.0), (0.0, 0.0, MID_TORSO)
    who.add(base, Bone.CHEST, colour, scale=scale, offset=offset, second=second, pattern=pattern)
    if kind in ("jacket", "coat", "suit"):
        shirt = who.colour(palette.TOPS[:2] if kind == "suit" else palette.TOPS)
        cut = "buttoned" if kind == "suit" or who.rng.random() < 0.4 else "open"
        who.add(f"{cut} {base}", Bone.CHEST, shirt, scale=(who.girth, 1.0, 1.0), coarsest=1)
        if kind == "suit" and not who.woman:
            who.add(f"tie {base}", Bone.CHEST, who.colour(palette.TOPS), scale=(who.girth, 1.0, 1.0), coarsest=0)
    if kind == "coat":
        scale = (who.girth, who.girth * (0.94 if who.woman else 1.0), float(who.rng.uniform(0.9, 1.35)))
        who.drape("coat hem", colour, scale)
    if kind == "hoodie":
        who.add("hood", Bone.CHEST, colour, coarsest=1)
    if kind in ("coat", "suit", "shirt"):
        who.add("collar", Bone.CHEST, colour, scale=(0.95, 0.9 if who.woman else 1.0, 1.0), coarsest=1)
    short = kind == "tee" or (kind == "shirt" and who.rng.random() < 0.3)
    _add_arms(who, colour, second, pattern if pattern in (Pattern.RINGS, Pattern.CHECKS) else Pattern.PLAIN, short)


def _torso(who: Outfit) -> str:
    if who.girth > 1.12:
        return "torso heavy"
    return "torso woman" if who.woman else "torso man"


def _add_arms(who: Outfit, colour: FloatArray, second: FloatArray, pattern: Pattern, short: bool) -> None:
    thick = who.girth * (0.86 if who.woman else 1.0)
    scale = (thick, thick, 1.0)
    if short:
        who.pair("upper arm", Bone.UPPER_ARM, who.skin, scale=scale, offset=MID_ARM, gloss=0.1, coarsest=1)
        more = {"second": second, "pattern": pattern, "coarsest": 2}
        who.pair("short sleeve", Bone.UPPER_ARM, colour, scale=scale, offset=MID_ARM, **more)
        who.pair("forearm", Bone.FOREARM, who.skin, scale=scale, offset=MID_FOREARM, gloss=0.1)
    else:
        more = {"second": second, "pattern": pattern, "scale": scale}
        who.pair("sleeve", Bone.UPPER_ARM, colour, offset=MID_ARM, **more)
        who.pair("forearm sleeve", Bone.FOREARM, colour, offset=MID_FOREARM, **more)
    size = 0.92 if who.woman else 1.0
    for side, name in enumerate(("left hand", "right hand")):
        who.add(name, Bone.FOREARM + side, who.skin, scale=(size, size, size), offset=WRIST, gloss=0.1)


def add_bottom(who: Outfit) -> None:
    """Trousers, shorts or a skirt, and shoes."""
    sex = "woman" if who.woman else "man"
    kinds = ("jeans", "trousers", "shorts", "short skirt", "pencil skirt", "long skirt")
    shares = (0.38, 0.2, 0.06, 0.14, 0.08, 0.14) if who.woman else (0.46, 0.4, 0.14, 0.0, 0.0, 0.0)
    kind = who.choose(kinds, shares)
    thick = who.girth * (1.0 if who.woman else 0.97)
    scale = (thick, thick, 1.0)
    colour = who.colour(palette.SKIRTS if "skirt" in kind else palette.TROUSERS)
    if "skirt" in kind and who.cloth is not None and who.rng.random() < 0.35:
        colour = who.cloth
        who.kind.append("dress")
    who.add(f"hips {sex}", Bone.PELVIS, colour, scale=(who.girth, who.girth, 1.0), coarsest=1)
    bare = linear(palette.STOCKING) if "skirt" in kind and who.rng.random() < 0.4 else who.skin
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
    if "skirt" in kind:
        ease = {"coat": 0.84, "jacket": 0.92, "hoodie": 0.92, "suit": 0.92, "": 1.08}[who.outer]
        wide = who.girth * (0.97 if who.torso == "torso heavy" else ease)
        who.drape(kind, colour, (wide, wide, 1.0))
    _add_shoes(who, kind)


def _add_shoes(who: Outfit, bottom: str) -> None:
    pump = who.woman and bottom not in ("jeans", "shorts") and who.rng.random() < 0.6
    colour = who.colour(palette.SHOES)
    width = 0.88 if who.woman else 1.0
    who.pair("pump" if pump else "shoe", Bone.FOOT, colour, scale=(1.0, width, 1.0), gloss=0.3)
    if not pump:
        pale = linear(palette.WHITE if who.rng.random() < 0.6 else palette.BLACK)
        who.pair("sole", Bone.FOOT, pale, scale=(1.0, width, 1.0), coarsest=0)


def add_bag(who: Outfit) -> str:
    """Add something to carry, or nothing; return which."""
    shares = (0.42, 0.18, 0.2, 0.2) if who.woman else (0.52, 0.28, 0.16, 0.04)
    bag = who.choose(("none", "backpack", "shoulder bag", "tote"), shares)
    if bag == "none":
        return bag
    colour = who.colour(palette.BAGS)
    wide = (who.girth, who.girth, 1.0)
    side = 0 if who.rng.random() < 0.5 else 1
    if bag == "backpack":
        back = {"jacket": 0.0, "jacket woman": 0.010, "torso woman": 0.025}.get(who.torso, 0.014)
        who.add("backpack", Bone.CHEST, colour, offset=(back - 0.10 * (who.girth - 1.0), 0.0, 0.0))
        who.add(f"straps {who.torso}", Bone.CHEST, colour, scale=wide, coarsest=1)
    if bag == "shoulder bag":
        who.add(f"{('left', 'right')[side]} strap {who.torso}", Bone.CHEST, colour, scale=wide, coarsest=1)
        out = 0.205 if who.torso.startswith("jacket") else 0.190
        who.add("pouch", Bone.PELVIS, colour, offset=(-0.02, out * (1 - 2 * side) * who.girth, -0.02))
    if bag == "tote":
        bag = ("left tote", "right tote")[side]
        who.add("tote", Bone.FOREARM + side, colour, offset=(0.0, 0.0, -FOREARM + 0.02))
    return bag


def make_look(seed: int, person: int, height: float) -> Look:
    """The look of a person of a height in m."""
    rng = np.random.default_rng([seed % 2**63, person % 2**63])
    woman = bool(rng.random() < np.clip(0.5 - 3.0 * (height - 1.70), 0.1, 0.9))
    age = str(rng.choice(["young", "grown", "old"], p=[0.35, 0.47, 0.18]))
    girth = float(np.clip(rng.normal({"young": 0.96, "grown": 1.03, "old": 1.06}[age], 0.065), 0.88, 1.22))
    hair = palette.GREY if age == "old" else palette.HAIR
    skin = rng.choice(len(palette.SKIN), p=palette.SKIN_SHARES)
    shares = np.array(palette.HAIR_SHARES) * (np.arange(8) < (8 if skin < 5 else 2)) if age != "old" else np.ones(4)
    tress = rng.choice(len(hair), p=shares / shares.sum())
    who = Outfit(rng=rng, woman=woman, age=age, girth=girth, skin=linear(palette.SKIN[skin]), hair=linear(hair[tress]))
    who.kind += ["woman" if woman else "man", age, f"{girth:.1f}", palette.SKIN[skin], hair[tress]]
    add_head(who)
    add_top(who)
    add_bottom(who)
    bag = add_bag(who)
    size = height / (CHIN + crown_of(tuple(who.parts), Bone.HEAD))
    manner = _manner(who, bag, size)
    return Look(kind=tuple(who.kind), parts=tuple(who.parts), style=manner)


def _manner(who: Outfit, bag: str, size: float) -> dict[str, FloatArray]:
    """One row of a `Style`."""
    rng, old = who.rng, who.age == "old"
    swing = np.full(2, rng.uniform(0.25, 0.5) * (0.7 if old else 1.0))
    forward, elbow = np.full(2, rng.uniform(-0.05, 0.05)), np.full(2, rng.uniform(0.15, 0.45))
    aside = np.full(2, rng.uniform(0.06, 0.11) + 0.45 * max(who.girth - 1.0, 0.0))
    inward = np.full(2, rng.uniform(0.1, 0.4))
    if "tote" in bag:
        side = int(bag == "right tote")
        swing[side] *= 0.3
        elbow[side] = 0.1
    elif rng.random() < 0.12:
        who.add("phone", Bone.FOREARM + 1, linear(palette.BLACK), offset=(0.02, 0.025, -0.27), gloss=0.5, coarsest=1)
        swing[1], forward[1], elbow[1], inward[1] = 0.03, 0.35, 1.75, 0.35  # looks at a phone
    elif rng.random() < 0.08:
        swing[:], forward[:], elbow[:], inward[:], aside[:] = 0.08, -0.26, 0.60, 0.55, 0.20  # hands in pockets
    return {
        "size": np.array(size),
        "shoulders": np.array((0.88 if who.woman else 1.0) * (0.6 + 0.4 * who.girth)),
        "hips": np.array(0.6 + 0.4 * who.girth),
        "track": np.array((0.040 if who.woman else 0.052) + 0.25 * max(who.girth - 1.0, 0.0)),
        "stance": rng.uniform(-0.035, 0.035) * np.array([1.0, -1.0]),
        "stride": np.array(rng.uniform(0.95, 1.06) * (0.88 if old else 1.0) * (0.97 if who.girth > 1.12 else 1.0)),
        "start": np.array(rng.uniform(0.0, 1.0)),
        "stoop": np.array(rng.uniform(0.03, 0.09) if old else rng.uniform(-0.005, 0.02)),
        "glance": np.array(rng.normal(0.0, 0.35)),
        "arm_swing": swing,
        "arm_forward": forward,
        "arm_aside": aside,
        "arm_inward": inward,
        "elbow": elbow,
    }
