"""``vb-cv``: view birdification with constant-velocity motion (VB-CV of arXiv 2111.05060)."""

from dataclasses import dataclass

import numpy as np

from vbbench_baselines.cascade import Answer, Birdifier, Task
from vbbench_baselines.ego_motion import fit_pose
from vbbench_baselines.localisation import localise


@dataclass(kw_only=True)
class ConstantVelocityBirdifier(Birdifier):
    """Squared norms about constant velocity, with both stages in closed form: no samples, no messages."""

    def _minimise(self, task: Task) -> Answer:
        pose, factors = task.pose, task.factors
        if np.isnan(pose[2]):
            pose = fit_pose(*factors)
        return Answer(pose, localise(pose, *factors[:4]), factors, factors)
