"""Refuses what no split can be made of."""

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options
from vbbench_generators.corruption import TIERS


def check_options(split: str, options: Options) -> None:
    """Check what every split is asked for.

    Raises
    ------
    VbbenchError
        If an option cannot be.
    """
    if options.tier not in TIERS:
        raise VbbenchError(f"split '{split}' offers the tiers {', '.join(TIERS)}, not '{options.tier}'")
