"""Tiers: corruption of exact boxes by noise, by occlusion, and by a detector and its tracker."""
