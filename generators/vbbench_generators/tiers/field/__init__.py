"""The tier `field`: trajectories seen by a camera as real as those of footage, by a recipe with a source per value."""
