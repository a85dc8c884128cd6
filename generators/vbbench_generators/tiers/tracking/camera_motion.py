"""How a turning camera moves everything in its picture, which a tracker takes off before it looks for people.

Trackers for moving cameras estimate one motion of the whole picture from its background, frame by frame: BoT-SORT
(Aharon et al. 2022) by sparse optical flow, others by correlation. What is far moves by the camera's turn alone: a
direction d of the camera (right, down, forward) becomes R d, in a panorama a shift of the columns, in a perspective
picture the homography K R K⁻¹. Here the turn is the true one with an error, as if it had been found in the picture.
"""

import numpy as np

from vbbench.camera import Camera
from vbbench.geometry import FloatArray, shorter_way, wrap_angle


def estimated_turns(yaw: FloatArray, camera: Camera, std: float, rng: np.random.Generator) -> FloatArray:
    """Rotations [T, 3, 3] of directions of the camera (right, down, forward), from the frame before to each frame.

    Parameters
    ----------
    yaw : [T] in rad, of a camera that keeps its tilt; a NaN counts as no turn.
    camera : whose directions they are.
    std : error of each turn, in px in the middle of the picture.
    rng : draws it.
    """
    left = np.nan_to_num(wrap_angle(np.diff(yaw, prepend=yaw[:1])))
    left = left + std / camera.focal * rng.standard_normal(len(yaw))
    sin, cos, zero = np.sin(left), np.cos(left), np.zeros_like(left)
    level = np.stack([cos, zero, sin, zero, zero + 1.0, zero, -sin, zero, cos], axis=-1).reshape(-1, 3, 3)
    tilt: FloatArray = camera.to_level(np.eye(3))  # rows: the camera's axes in the frame of a level one
    turned: FloatArray = tilt @ level @ tilt.T
    return turned


def carried(boxes: FloatArray, rotation: FloatArray, camera: Camera) -> FloatArray:
    """Where boxes [N, 4] (centre column, centre row, width, height) px stand after the camera has turned.

    NaN for those that are behind a camera whose picture has borders.
    """
    if camera.cylinder is not None and camera.period is not None and rotation[1, 1] == 1.0:
        moved = boxes.copy()
        moved[:, 0] += np.arctan2(rotation[0, 2], rotation[0, 0]) * camera.period / (2.0 * np.pi)
        return moved
    half = 0.5 * boxes[:, 3]
    rows = np.stack([boxes[:, 1] - half, boxes[:, 1] + half])
    ends = np.stack([np.broadcast_to(boxes[:, 0], rows.shape), rows], axis=-1)
    top, foot = camera.pixels(camera.directions(ends) @ rotation.T)
    across = shorter_way(foot[:, 0] - top[:, 0], camera.period)
    height = np.hypot(across, foot[:, 1] - top[:, 1])
    width = boxes[:, 2] * height / boxes[:, 3]
    return np.stack([top[:, 0] + 0.5 * across, 0.5 * (top[:, 1] + foot[:, 1]), width, height], axis=-1)
