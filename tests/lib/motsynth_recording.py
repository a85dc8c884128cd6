"""A made recording in the layout of MOTSynth's annotations: people walk, a camera moves and turns among them.

`recording` has places (x, y, height) and the game's angles; `as_published` makes of it what the published files have.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray

WIDTH, HEIGHT, FOV, FPS = 1920, 1080, 50.0, 20
FOCAL = 0.5 * HEIGHT / np.tan(np.radians(0.5 * FOV))
MOUNT_HEIGHT, PITCH = 1.8, -3.0
"""m above the ground, and degrees."""
GROUND = np.array([-1200.0, 350.0, 28.0])
"""A place in the game's world."""
# right, forward and up of each joint, as a share of the person's height; ankles 0.08 m above the sole
_SHARES = np.array(
    [(0.0, 0.0, 1.0), (0.0, 0.0, 0.93), (0.0, 0.0, 0.87)]
    + [(side * x, 0.0, z) for side in (1, -1) for x, z in ((0.05, 0.83), (0.11, 0.82), (0.13, 0.63), (0.14, 0.48))]
    + [(0.0, 0.0, z) for z in (0.55, 0.6, 0.66, 0.72, 0.78)]
    + [(side * 0.06, 0.0, z) for side in (1, -1) for z in (0.53, 0.29, 0.0)]
)


def heights(people: int) -> FloatArray:
    """Of the people, in m."""
    return 1.6 + 0.03 * np.arange(people)


def camera_track(frames: int) -> tuple[FloatArray, FloatArray]:
    """Positions [T, 3] in m and angles [T, 3] (pitch, roll, yaw) in degrees."""
    time = np.arange(frames) / FPS
    positions = GROUND + np.stack([0.8 * time, 0.3 * np.sin(1.5 * time), np.full(frames, MOUNT_HEIGHT)], axis=-1)
    angles = np.stack([PITCH + 0.3 * np.sin(2.0 * time), np.zeros(frames), -90.0 + 8.0 * np.sin(2.5 * time)], axis=-1)
    return positions, angles


def walkers(frames: int, people: int) -> FloatArray:
    """Places [T, K, 2] in m in the game's world."""
    rng, time = np.random.default_rng(3), np.arange(frames)[:, None, None] / FPS
    start = GROUND[:2] + rng.uniform([7.0, -3.0], [18.0, 3.0], (people, 2))
    return start + time * rng.uniform(-0.6, 0.6, (people, 2))


def recording(frames: int = 60, people: int = 6, pose_shift: int = 0) -> dict[str, Any]:
    """The values of an annotation file; ``pose_shift``: poses are written so many frames too late."""
    extra = 10
    positions, angles = camera_track(frames + 2 * extra)
    world, tall = walkers(frames + 2 * extra, people), heights(people)
    info = {"seq_name": "000", "fps": FPS, "img_width": WIDTH, "img_height": HEIGHT, "cam_fov": FOV}
    info |= {"fx": 1158, "fy": 1158, "cx": 960, "cy": 540, "sequence_length": frames, "is_moving": 1}
    images, annotations = [], []
    for frame in range(frames):
        posed = frame + extra - pose_shift
        image = {"id": 1000 + frame, "frame_n": frame, "file_name": f"frames/000/rgb/{frame:04d}.jpg"}
        image |= {"width": WIDTH, "height": HEIGHT, "is_moving": 1, "cam_fov": FOV}
        images.append(image | {"cam_world_pos": list(positions[posed]), "cam_world_rot": list(angles[posed])})
        for person in range(people):
            seen = _seen(world[frame + extra, person], tall[person], positions[frame + extra], angles[frame + extra])
            if seen is None:
                continue
            annotations.append(
                {
                    "id": len(annotations),
                    "image_id": 1000 + frame,
                    "category_id": 1,
                    "iscrowd": 0,
                    "area": 100,
                    "ped_id": 10 * person,
                    "num_keypoints": 22,
                    "segmentation": {"size": [HEIGHT, WIDTH], "counts": "abc"},
                    **seen,
                }
            )
    return {"info": info, "images": images, "annotations": annotations}


def as_published(values: dict[str, Any], sequence: int = 42) -> dict[str, Any]:
    """The same recording as published files have it, after the one real record that is known.

    Places are (x, -height, y), angles about these axes, in this order, both right-handed; ``frame_n`` counts from 1;
    intrinsics are text, and stand with every image.
    """
    name, info = f"{sequence:03d}", {"fx": "1158", "fy": "1158", "cx": "960", "cy": "540"}
    info |= {"img_height": HEIGHT, "img_width": WIDTH, "seq_name": name, "is_night": 0, "weather": "CLEAR"}
    info |= {"is_moving": 1, "cam_fov": FOV, "fps": FPS, "sequence_length": len(values["images"]), "time": "11"}
    ids = {image["id"]: 10_000 * sequence + n for n, image in enumerate(values["images"])}
    images = [
        {"file_name": f"frames/{name}/rgb/{n:04d}.jpg", "id": ids[image["id"]], "frame_n": n}
        | {"cam_world_pos": _y_down(image["cam_world_pos"]), "cam_world_rot": _about_fixed_axes(image["cam_world_rot"])}
        | {"ignore_mask": [0, 0, 0, 0], "height": HEIGHT, "width": WIDTH, "version": "1.0"}
        | {"description": f"MOTSynth 2021 Dataset - Sequence #{sequence}", **info}
        for n, image in enumerate(values["images"], 1)
    ]
    extra = {"model_id": "12", "attributes": [0] * 11, "is_blurred": 0}
    annotations = [row | extra | {"image_id": ids[row["image_id"]]} for row in values["annotations"]]
    return {"info": info, "licenses": [], "images": images, "annotations": annotations, "categories": []}


def _y_down(place: list[float]) -> list[float]:
    x, y, height = place
    return [round(float(number), 4) for number in (x, -height, y)]


def _about_fixed_axes(angles: list[float]) -> list[float]:
    """Degrees about x, then y, then z of (x, -height, y) that turn a camera (right, down, forward) into this one."""
    turned = _axes(np.array(angles))[[0, 2, 1]] * [[1.0], [-1.0], [1.0]]
    about = (
        np.arctan2(turned[2, 1], turned[2, 2]),
        -np.arcsin(turned[2, 0]),
        np.arctan2(turned[1, 0], turned[0, 0]),
    )
    return [round(float(np.degrees(angle)), 5) for angle in about]


def _axes(angles: FloatArray) -> FloatArray:
    """[3, 3] right, down and forward as columns, from pitch, roll and yaw in degrees; roll lowers the right side."""
    pitch, roll, yaw = np.radians(angles)
    forward = np.array([-np.sin(yaw) * np.cos(pitch), np.cos(yaw) * np.cos(pitch), np.sin(pitch)])
    level = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    below = np.cross(forward, level)
    right = np.cos(roll) * level + np.sin(roll) * below
    return np.stack([right, np.cross(forward, right), forward], axis=-1)


def _seen(place: FloatArray, tall: float, position: FloatArray, angles: FloatArray) -> dict[str, Any] | None:
    """Box and joints of a person; ``None`` outside the picture. The axes are written out, unlike in the reader."""
    joints = np.append(place, GROUND[2]) + _SHARES * tall * [1.0, 1.0, 1.0 - 0.08 / tall] + [0.0, 0.0, 0.08]
    camera = (joints - position) @ _axes(angles)
    pixels = np.array([0.5 * WIDTH, 0.5 * HEIGHT]) + FOCAL * camera[:, :2] / camera[:, 2:]
    if (camera[:, 2] < 0.5).any() or not ((pixels > 0) & (pixels < [WIDTH, HEIGHT])).all():
        return None
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    sole = 0.08 * FOCAL / camera[18, 2]
    flags = np.full((22, 1), 2.0)
    return {
        "bbox": [*low, high[0] - low[0], high[1] + sole - low[1]],
        "keypoints": np.hstack([pixels, flags]).reshape(-1).tolist(),
        "keypoints_3d": np.hstack([camera, flags]).reshape(-1).tolist(),
    }


def write(folder: Path, values: dict[str, Any], name: str = "000") -> Path:
    """Write the values as ``folder/annotations/NAME.json``; return ``folder``."""
    (folder / "annotations").mkdir(parents=True, exist_ok=True)
    (folder / "annotations" / f"{name}.json").write_text(json.dumps(values))
    return folder
