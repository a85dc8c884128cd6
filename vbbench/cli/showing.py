"""How commands of studies do their work, and what they show."""

from pathlib import Path
from typing import TYPE_CHECKING

from vbbench.reproduction.work import Work

if TYPE_CHECKING:
    from vbbench.reproduction.making import Making
    from vbbench.reproduction.report import Report


def making(work: Work) -> "Making":
    """What makes datasets and submissions."""
    from vbbench.reproduction.making import Making

    return Making(**vars(work))


def show(report: "Report", out: Path, as_json: bool) -> None:
    """Write a report's files and print what it found."""
    from vbbench.reproduction.report import shown, write_report

    print(shown(report, write_report(report, out), as_json=as_json))
