"""The crowd engine, to be imported from here: the social force model, many scenes side by side, compiled."""

from vbbench_generators.crowds.social_force.engine import simulate, simulate_many
from vbbench_generators.crowds.social_force.model import Crowd, GroupForces, HelbingMolnar, Model, Moussaid, WallForce

__all__ = ["Crowd", "GroupForces", "HelbingMolnar", "Model", "Moussaid", "WallForce", "simulate", "simulate_many"]
