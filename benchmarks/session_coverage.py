"""How sure a session's answers are and how right: the share of truths inside the 95 % regions of its covariances.

    python -m benchmarks.session_coverage [--runs 10] [--seconds 30] [--people 5 20 50]

Crowds are those of `benchmarks.bench_session`, everybody as tall as the prior of heights says.
"""

import argparse

import numpy as np

from benchmarks.bench_session import DT, ODOMETRY, PIXELS, crowd
from vbbench import Session
from vbbench.camera import PanoramaCamera
from vbbench.geometry import FloatArray, wrap_angle
from vbbench_baselines.joint_map import MapCausal

INSIDE = {2: 5.991, 3: 7.815}
"""95 % quantiles of χ² with so many degrees of freedom."""


def inside(error: FloatArray, covariance: FloatArray) -> bool:
    return bool(error @ np.linalg.solve(covariance, error) <= INSIDE[len(error)])


def run(people: int, frames: int, seed: int, odometry: bool) -> FloatArray:
    """Mean Δt and Δx in m of the last second; share of poses, and of positions, inside their regions."""
    session = Session(MapCausal(), PanoramaCamera(), DT, pixel_std=PIXELS, height_std=0.07)
    poses, positions, off, away = [], [], [], []
    for frame, seen in enumerate(crowd(people, frames, seed)):
        answer = session.step_observations(seen.boxes, (seen.motion, ODOMETRY) if odometry and frame else None)
        error = answer.pose - seen.pose
        error[2] = wrap_angle(error[2])
        errors = {track: answer.positions[track] - place for track, place in seen.places.items()}
        if frame >= 2 and answer.pose_covariance is not None:
            poses.append(inside(error, answer.pose_covariance))
            positions += [inside(errors[track], answer.position_covariances[track]) for track in errors]
        off.append(np.linalg.norm(error[:2]))
        away.append(np.mean(np.linalg.norm(list(errors.values()), axis=1)))
    last = round(1.0 / DT)
    return np.array([np.mean(off[-last:]), np.mean(away[-last:]), np.mean(poses), np.mean(positions)])


def main() -> None:
    parser = argparse.ArgumentParser(description="Coverage of a session's covariances.")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--people", type=int, nargs="+", default=[5, 20, 50])
    chosen = parser.parse_args()
    print("odometry  people   Δt m    Δx m   poses inside 95 %   positions inside 95 %")
    for odometry in (True, False):
        for people in chosen.people:
            rows = [run(people, round(chosen.seconds / DT), seed, odometry) for seed in range(chosen.runs)]
            off, away, poses, positions = np.mean(rows, axis=0)
            print(f"{'yes' if odometry else 'no':9s}{people:5d}{off:10.2f}{away:8.2f}{poses:14.0%}{positions:22.0%}")


if __name__ == "__main__":
    main()
