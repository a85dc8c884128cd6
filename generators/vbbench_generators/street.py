"""The split `street`, the paper's photorealistic one: a crowd on a street, people hidden by people."""

from dataclasses import replace
from functools import partial

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options
from vbbench_generators.corruption import corruption_of
from vbbench_generators.sim import SimSplit, SimulationPlan, plan_simulation

SCENARIO = "street"


class StreetSplit:
    """The scenario `street`; needs no source.

    Its tier `ideal` is the paper's input from centre lines: whoever shows enough has a whole and exact box, and whoever
    does not has none. `noisy` adds noise to that; `occluded` and `tracked` are as everywhere.
    """

    card = replace(SimSplit.card, name="street", title="Street: a simulated crowd in which people hide one another")

    def plan(self, options: Options) -> SimulationPlan:
        """Lay out the sequences; nothing is simulated yet."""
        asked = options.simulation
        if asked is not None and asked.scenario is not None:
            raise VbbenchError(f"street is the scenario '{SCENARIO}'; --scenario is for the split 'sim'")
        source = {"ideal": "cline", "noisy": "cline"}.get(options.tier, options.tier)
        corrupting = partial(corruption_of, whole=True)
        return plan_simulation(self.card, options, SCENARIO, corrupting, input=source)
