"""Colours of skin, hair and clothes, written as sRGB and used as linear RGB."""

import numpy as np

from vbbench.geometry import FloatArray

SKIN = ("f0cdb5", "e8bd9f", "e3b394", "d8a07c", "c98f6b", "b57a55", "96603f", "7a4a30", "5d3724", "472a1d")
SKIN_SHARES = (0.14, 0.17, 0.16, 0.14, 0.10, 0.08, 0.07, 0.06, 0.05, 0.03)
HAIR = ("17130f", "241a13", "38261a", "553721", "7a5230", "a67c46", "c9a466", "8c3f20")
HAIR_SHARES = (0.24, 0.22, 0.20, 0.13, 0.09, 0.06, 0.04, 0.02)
GREY = ("8e8c88", "b9b7b2", "d9d7d2", "6b6966")
TOPS = (
    "f2f1ec", "e4e2da", "1d1f24", "2b2e36", "c9c9c6", "1a2238", "41454d", "d5cdbb", "16171b", "5d6168",
    "24324f", "3a567f", "6f93b8", "8fb0a0", "3f5d46", "6d7440", "b7a47c", "7d2b2f", "b23a3a", "d9763f", "e2b23c",
    "c98fa3", "6b4a78", "8a8d92", "4f7f8c", "efe3c8", "30584e", "a0522f",
)  # fmt: skip
COATS = ("1b1c20", "26292f", "2c3446", "5a4a38", "8a6e4c", "b39a73", "4a4f3a", "6e2f2c", "7e8288", "39424a", "a63f32")
TROUSERS = (
    "1a1b1f",
    "24262c",
    "232f47",
    "2e4163",
    "3f5a85",
    "6d8bb0",
    "5c5246",
    "8d7d63",
    "b9ab8d",
    "3c4038",
    "54585e",
)
SKIRTS = ("1d1e23", "2c3550", "7c2f3a", "b5656b", "4b6a5a", "c7a25a", "8d8f96", "5a3d5c", "d8cfbe", "3d6f8f")
SHOES = ("17171a", "241f1c", "3d2a1e", "5b3d28", "e6e4df", "c9c7c2", "30333a", "8a2f2c", "35507a")
BAGS = ("16171a", "2a2c31", "5a3a24", "7a5433", "2d3d5a", "6c2b2b", "4d5a3c", "b08d57", "8a8c90", "c25b33")
WHITE, BLACK, STOCKING = "eeece6", "141416", "3a3230"


def linear(code: str) -> FloatArray:
    """Linear RGB [3] of a colour written as six hexadecimal digits of sRGB (IEC 61966-2-1)."""
    srgb = np.array([int(code[i : i + 2], 16) for i in (0, 2, 4)]) / 255.0
    return np.asarray(np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4))
