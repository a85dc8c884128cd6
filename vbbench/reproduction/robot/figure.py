"""The experiment of a robot as a report: a table a recording, every number, and a picture a recording."""

from collections.abc import Iterator
from typing import Any

from vbbench.reproduction.report import Report
from vbbench.reproduction.robot.drift import TABLE_LENGTHS, Drift
from vbbench.reproduction.robot.measuring import Course, Robot, Row
from vbbench.reproduction.robot.picture import plot_course
from vbbench.scoring.metrics import METRICS
from vbbench.table import Table

NAME = "figure-robot"
PLACES = ("dx_rel", "dx")
"""Metrics of people's places: as seen from the camera, and on the map."""


def robot_report(found: Robot) -> Report:
    """A table and a picture for each recording."""
    return Report(
        name=NAME,
        title=f"A camera whose motion nobody tells: drift over the distance gone; {_conditions(found)}",
        facts=tuple(_facts(found)),
        tables=[_table(course) for course in found.courses],
        values=robot_values(found),
        pictures={course.recording.name: plot_course(course, found.study) for course in found.courses},
        whole=not found.missing,
    )


def _conditions(found: Robot) -> str:
    return f"simulated robot in tier {found.study.tier}, seed {found.study.seed}"


def _facts(found: Robot) -> Iterator[str]:
    yield (
        "The paper's experiment on JRDB: nothing is known of how the robot moves, so that nothing is expected of the "
        "observer, and an extended Kalman filter of the robot's odometry is the reference. No figure of it is quoted."
    )
    yield (
        "Drift over L m is how far a way leads astray on every stretch of L m, in per cent of L, as in KITTI's "
        "odometry benchmark (Geiger, Lenz, Urtasun, CVPR 2012), with 5 to 40 m instead of 100 to 800 m: mean (median) "
        "over all stretches, one from every frame. Where the map lies and how it is turned does not count."
    )
    yield (
        "Protocol sequential gives the camera's first two poses and everybody's first two places, so that whoever "
        "arrives later corrects the map; cold-start gives where the map begins, and nothing else, as on a robot."
    )
    labels = " and ".join(METRICS[name].label for name in PLACES)
    yield f"{labels}: of people as seen from the camera, and on the map; capped mean (median) over sequences."
    yield from found.missing


def _table(course: Course) -> Table:
    gone = course.metres[course.metres >= 1.0]
    stands = len(course.metres) - len(gone)
    ways = f"{len(gone)} sequences, {gone.min():.0f} to {gone.max():.0f} m" if len(gone) else "no sequence that moves"
    standing = f", and {stands} in which the camera stands or hardly moves" if stands else ""
    figures = [f"drift over {length:g} m" for length in TABLE_LENGTHS]
    head = ["way", "protocol", *figures, "turned over 10 m", *(METRICS[name].label for name in PLACES)]
    return Table(
        title=f"{course.recording.title}: {ways}{standing}",
        facts=[course.recording.about],
        head=head,
        rows=[_cells(row) for row in course.rows],
        names=2,
    )


def _cells(row: Row) -> list[str]:
    by_length = {one.length: one for one in row.drifts}
    shifts = [_share(by_length[length]) for length in TABLE_LENGTHS]
    turn = by_length[10.0].turn
    turned = f"{10.0 * turn.mean():.3f} rad" if len(turn) else "–"
    places = [_metres(row, name) for name in PLACES]
    return [row.title, row.protocol or "–", *shifts, turned, *places]


def _share(one: Drift) -> str:
    return f"{100.0 * one.mean:.1f} % ({100.0 * one.quantile(0.5):.1f})" if len(one.shift) else "–"


def _metres(row: Row, metric: str) -> str:
    own = row.summaries.get(metric)
    return "–" if own is None else f"{own.capped:.2f} ({own.median:.2f})"


def robot_values(found: Robot) -> dict[str, Any]:
    """Every figure: a recording with its rows, each with drift at every length and all metrics."""
    return {
        "seed": found.study.seed,
        "tier": found.study.tier,
        "missing": list(found.missing),
        "recordings": [
            {
                "name": course.recording.name,
                "metres": course.metres.tolist(),
                "shown": course.example.sequence.index,
                "rows": [
                    {
                        "way": row.title,
                        "protocol": row.protocol or None,
                        "drift": [one.to_dict() for one in row.drifts],
                        "figures": {name: own.to_dict() for name, own in row.summaries.items()},
                    }
                    for row in course.rows
                ],
            }
            for course in found.courses
        ],
    }
