"""Fewer frames of a recording than it has."""

from dataclasses import replace

from vbbench.scene import Scene


def every_frame(scene: Scene, step: int) -> Scene:
    """The scene in every ``step``-th frame from the first one on, with whoever is there in any of them."""
    if step == 1:
        return scene
    positions, present = scene.positions[::step], scene.present[::step].any(axis=0)
    return replace(
        scene,
        dt=step * scene.dt,
        people=scene.people[present],
        positions=positions[:, present],
        heights=scene.heights[present],
    )
