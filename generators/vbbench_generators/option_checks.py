"""Refuses what no split can be made of."""

from vbbench.errors import VbbenchError
from vbbench.generator import Options
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
    if not 0.0 <= options.height_std <= 0.3:
        raise VbbenchError(f"--sigma-h is the spread of people's heights in m, 0 to 0.3, not {options.height_std}")
    if options.limit is not None and options.limit < 1:
        raise VbbenchError(f"--limit must be at least 1, not {options.limit}")
    if options.seed < 0:
        raise VbbenchError(f"--seed must be 0 or more, not {options.seed}")
