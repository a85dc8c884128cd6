"""The tier `tracked`: a detector that errs as detectors do, and a real tracker behind it."""

from vbbench_generators.tiers.tracking.observing import Tracked, track_people
from vbbench_generators.tiers.tracking.settings import TrackingSettings, get_tracking

__all__ = ["Tracked", "TrackingSettings", "get_tracking", "track_people"]
