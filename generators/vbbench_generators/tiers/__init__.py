"""Tiers: what becomes of exact boxes, by noise, by people who hide one another, and by a detector and its tracker."""
