"""The split `demo`: made crowds, for a first look where no recording is at hand."""

from vbbench.generator import Card, Options
from vbbench_generators.crowd import make_crowd
from vbbench_generators.eligibility import Rules
from vbbench_generators.planning import plan_reprojection
from vbbench_generators.reprojection import Reprojection

SCENES, PEOPLE, FRAMES, DT = 3, 16, 60, 0.4


class DemoSplit:
    """Made crowds seen by each of their people; needs no source."""

    card = Card(
        name="demo",
        title="Made crowds crossing a square (no recording)",
        licence="Apache-2.0, like vbbench",
        citation="none; made by vbbench",
        sources=(),
        caution="made crowds, not people: for trying things out, not for comparing solvers",
    )

    def plan(self, options: Options) -> Reprojection:
        """Make the crowds and lay out their sequences."""
        scenes = [make_crowd(options.seed, index, PEOPLE, FRAMES, DT) for index in range(SCENES)]
        rules = Rules(min_others=3, min_frames=5)
        return plan_reprojection(self.card, rules, scenes, options, {"crowd": [SCENES, PEOPLE, FRAMES]})
