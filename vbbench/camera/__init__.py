"""Cameras: the observation (u, v, l) of an upright person, and the way back to the ground plane.

Observation model (paper arXiv 2111.05060, eq. 1, with the true vertical offset h0 − h/2 of the box centre
where the paper prints h/2): a person of height h at z = (right, forward) is seen as a box with centre column u,
centre row v (down positive) and height l, all in px. The camera stands at mount height h0. Pitch is how far its
optical axis points above the horizon, roll how far its right side hangs lower than its left, both in rad; a level
camera has neither.

A camera model is one frozen dataclass, registered under ``vbbench.cameras`` by its ``kind``. `CentralCamera` makes it a
`Camera` once it says which pixel shows which direction and which direction is shown at which pixel.
"""

from vbbench.camera.central import NEAREST, CentralCamera, Focal, MountHeight, PrincipalPoint, Size, Tilt
from vbbench.camera.equirectangular import EquirectangularCamera
from vbbench.camera.interface import Camera, camera_from_dict, camera_to_dict, make_camera
from vbbench.camera.models import PanoramaCamera, PerspectiveCamera

__all__ = [
    "NEAREST",
    "Camera",
    "CentralCamera",
    "EquirectangularCamera",
    "Focal",
    "MountHeight",
    "PanoramaCamera",
    "PerspectiveCamera",
    "PrincipalPoint",
    "Size",
    "Tilt",
    "camera_from_dict",
    "camera_to_dict",
    "make_camera",
]
