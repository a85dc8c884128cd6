"""How colours look: to eyes with all cones and with fewer (Machado et al. 2009), in Oklab (Ottosson 2020), on paper."""

from collections.abc import Sequence

import numpy as np

from vbbench.geometry import FloatArray

EYES = {
    "all cones": np.eye(3),
    "no red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
CONES = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566]]
CONES.append([0.0883024619, 0.2817188376, 0.6299787005])
OKLAB = [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099]]
OKLAB.append([0.0259040371, 0.7827717662, -0.8086757660])


def linear(colours: Sequence[str]) -> FloatArray:
    """Linear RGB [N, 3] of ``#rrggbb``."""
    shares = np.array([list(bytes.fromhex(colour[1:])) for colour in colours]) / 255.0
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def least_apart(colours: Sequence[str], eyes: str) -> float:
    """How far the two nearest are apart in Oklab."""
    seen = np.clip(linear(colours) @ np.transpose(EYES[eyes]), 0.0, 1.0)
    lab = np.cbrt(seen @ np.transpose(CONES)) @ np.transpose(OKLAB)
    return float((np.linalg.norm(lab[:, None] - lab[None], axis=-1) + np.eye(len(colours))).min())


def contrast(one: str, other: str) -> float:
    """How many times as light the lighter colour is (WCAG 2.2)."""
    low, high = sorted((linear([one, other]) @ [0.2126, 0.7152, 0.0722]).tolist())
    return float((high + 0.05) / (low + 0.05))
