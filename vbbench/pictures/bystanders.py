"""People of a scene whom an observer does not see."""

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.sequence import Sequence


def unseen(sequence: Sequence, persons: IntArray, people: IntArray, positions: FloatArray) -> FloatArray:
    """Where people are who are there without a box, the observer left out.

    Parameters
    ----------
    sequence : what the observer sees.
    persons : [T, K] who is behind each of its tracks.
    people, positions : [N] and [frames of the scene, N, 2] in m, all of the scene.

    Returns
    -------
    [T, N, 2] in m, NaN where somebody is seen or absent.
    """
    places = positions[sequence.first_frame : sequence.first_frame + sequence.frames].copy()
    frame, track = np.nonzero(sequence.observed)
    seen = persons[frame, track]
    column = np.searchsorted(people, seen).clip(max=len(people) - 1)
    known = people[column] == seen
    places[frame[known], column[known]] = np.nan
    places[:, people == sequence.observer] = np.nan
    return np.asarray(places)
