"""The bones of a person and their lengths."""

from enum import IntEnum

THIGH, SHIN, UPPER_ARM, FOREARM = 0.430, 0.415, 0.290, 0.250
HIP_UP, HIP_ASIDE, SHOULDER_UP, SHOULDER_ASIDE = -0.040, 0.086, 0.434, 0.173
PELVIS, SPINE, CHIN = 0.970, 0.520, 1.530
"""Height of the pelvis when standing, from there to the base of the neck, and of the chin, in m for 1.75 m."""


class Bone(IntEnum):
    """What a limb can hang from; left and right follow one another."""

    PELVIS = 0
    CHEST = 1
    NECK = 2
    HEAD = 3
    UPPER_ARM = 4
    FOREARM = 6
    THIGH = 8
    SHIN = 10
    FOOT = 12
    SKIRT = 14  # and three more


BONES = 18
