"""Commands that reproduce the paper's tables."""

from pathlib import Path

from vbbench.cli.showing import making, show
from vbbench.reproduction.work import Work


def table1(
    out: Path = Path("table1"),
    split: tuple[str, ...] = ("sim", "hotel", "eth", "students", "shibuya01", "shibuya02", "street", "motsynth"),
    motsynth: Path | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
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

    study = Table1Study(splits=split, at_hand=AtHand.of(motsynth=motsynth), seed=seed)
    show(table1_report(measure_table1(study, out, making(work))), out, json)


def table2(
    out: Path = Path("table2"),
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    solver: tuple[str, ...] = (),
    every: int = 1,
    seed: int = 0,
    source: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make the paper's Table 2: every solver on Hotel, ETH and Students, under one-step and sequential.

    Args:
        out: Folder for table2.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 2; one whose source is missing is left out.
        solver: Registered names or module:attribute; default: the paper's, here, and map-causal and map-batch.
        every: Only every so-many-th sequence of each split.
        seed: Seed of all random numbers.
        source: Folder that holds the source files; default: the usual places.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    _show_solver_table(2, split, solver, every=every, seed=seed, source=source, out=out, work=work, json=json)


def table3(
    out: Path = Path("table3"),
    split: tuple[str, ...] = ("shibuya01", "shibuya02"),
    solver: tuple[str, ...] = (),
    every: int | None = None,
    seed: int = 0,
    source: Path | None = None,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make the paper's Table 3: every solver on Shibuya, or on simulated crowds where CroHD is missing.

    Args:
        out: Folder for table3.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 3; where its recording is missing, a simulated crowd is lifted in the same way.
        solver: Registered names or module:attribute; default: the paper's, here, and map-causal and map-batch.
        every: Only every so-many-th sequence of each split; default: every one of CroHD, few of a simulated crowd.
        seed: Seed of all random numbers.
        source: CroHD, as for 'vbbench generate shibuya01 --source'; default: the usual places.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    _show_solver_table(3, split, solver, every=every, seed=seed, source=source, out=out, work=work, json=json)


def _show_solver_table(
    table: int,
    split: tuple[str, ...],
    solver: tuple[str, ...],
    *,
    every: int | None,
    seed: int,
    source: Path | None,
    out: Path,
    work: Work,
    json: bool,
) -> None:
    from vbbench.reproduction.tables.solver_report import solver_table_report
    from vbbench.reproduction.tables.solver_tables import COUNTERPARTS, SolverTableStudy, measure_solver_table

    solvers = solver or tuple(COUNTERPARTS)
    study = SolverTableStudy(table=table, splits=split, solvers=solvers, every=every, seed=seed, source=source)
    show(solver_table_report(measure_solver_table(study, out, making(work))), out, json)


def table4(
    out: Path = Path("table4"),
    solver: tuple[str, ...] = ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal"),
    jitter: tuple[float, ...] = (0.0, 1.0, 2.0, 4.0),
    sequences: int | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Make tables and a picture of errors on split street with centre lines and with tracked boxes, beside the paper's.

    Args:
        out: Folder for table4.md, .json and .png, and for datasets and submissions; what it holds is reused.
        solver: Registered names or module:attribute.
        jitter: Standard deviations in px of the hands that draw centre lines; 0 draws them exactly.
        sequences: Number of sequences; default: the scenario's ten.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.tables.table4.report import table4_report
    from vbbench.reproduction.tables.table4.study import Table4Study, measure_table4

    study = Table4Study(solvers=solver, jitter=jitter, sequences=sequences, seed=seed)
    show(table4_report(measure_table4(study, out, making(work))), out, json)


def readings(
    out: Path = Path("readings"),
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    every: int = 1,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
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
