"""Makes up the people of a scene: a look and a manner each, from the seed and the person's id alone."""

import numpy as np

from vbbench.geometry import FloatArray
from vbbench_renderers.people import palette
from vbbench_renderers.people.bones import CHIN, Bone
from vbbench_renderers.people.dressing import add_bag, add_bottom, add_head, add_top
from vbbench_renderers.people.looks import Look, crown_of
from vbbench_renderers.people.palette import linear
from vbbench_renderers.people.wardrobe import Outfit


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
