"""The plan of what is asked for: whatever makes sequences of a split, in files or in memory, makes those of it."""

from vbbench.errors import VbbenchError
from vbbench.generation.footage import FOOTAGE
from vbbench.generation.generator import Generator, Options, Plan
from vbbench.generation.thinning import thinned
from vbbench.registry import load


def planned(split: str, options: Options) -> Plan:
    """The plan of a split with these options.

    Raises
    ------
    VbbenchError
        If the split or an option is wrong, its sources are missing or wrong, or there is no sequence.
    """
    generator: Generator = load("generator", split)
    plan = thinned(generator.plan(options), options.stride)
    if not len(plan):
        raise VbbenchError(f"{split}: no person of the source is seen with enough others to make a sequence")
    return plan


def is_endless(plan: Plan) -> bool:
    """Whether it builds sequences of any number: that is so where each brings its own scene, but for footage."""
    return not plan.scenes and plan.info.tier != FOOTAGE
