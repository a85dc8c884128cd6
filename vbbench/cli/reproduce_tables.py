"""Commands that reproduce the paper's tables."""

from pathlib import Path

from tyro.conf import OmitArgPrefixes

from vbbench.cli.showing import making, show
from vbbench.reproduction.work import Work


def table1(
    out: Path = Path("table1"),
    split: tuple[str, ...] = ("sim", "hotel", "eth", "students", "shibuya01", "shibuya02", "street", "motsynth"),
    motsynth: Path | None = None,
    seed: int = 0,
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make a table and a picture of sequences, frames and people of every split, beside the paper's.

    Args:
        out: Folder for table1.md, .json and .png; where the labels of Shibuya are missing, also for simulated
            recordings; what it holds is reused.
        split: Of the paper's Table 1.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.at_hand import AtHand
    from vbbench.reproduction.tables.table1 import Table1Study, measure_table1, table1_report

    at_hand = AtHand(folders={} if motsynth is None else {"motsynth": motsynth})
    study = Table1Study(splits=split, at_hand=at_hand, seed=seed)
    show(table1_report(measure_table1(study, out, making(work))), out, json)


def table4(
    out: Path = Path("table4"),
    solver: tuple[str, ...] = ("vb-sf", "vb-cv"),
    sequences: int | None = None,
    seed: int = 0,
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make a table of errors on split street with exact and with tracked boxes, beside the paper's.

    Args:
        out: Folder for table4.md, datasets and submissions; what it holds is reused.
        solver: Registered names or module:attribute.
        sequences: Number of sequences; default: the scenario's ten.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.tables.table4 import Table4Study, measure_table4, table4_report

    study = Table4Study(solvers=solver, sequences=sequences, seed=seed)
    show(table4_report(measure_table4(study, out, making(work))), out, json)


def readings(
    out: Path = Path("readings"),
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    every: int = 1,
    seed: int = 0,
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make a table and a picture of the errors under every reading of the paper, beside the paper's.

    Args:
        out: Folder for readings.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 2.
        every: Only every so-many-th sequence of each split.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.readings.figure import readings_report
    from vbbench.reproduction.readings.study import ReadingsStudy, measure_readings

    study = ReadingsStudy(splits=split, every=every, seed=seed)
    show(readings_report(measure_readings(study, out, making(work))), out, json)
