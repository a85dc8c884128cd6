"""Commands that reproduce the paper's tables and figures."""

from pathlib import Path

from vbbench.cli.evaluation import ProtocolName


def figure_sigma(
    out: Path = Path("figure-sigma"),
    solver: tuple[str, ...] = (),
    protocol: ProtocolName = "one-step",
    camera: str | None = None,
    tier: str = "ideal",
    sequences: int = 500,
    seed: int = 0,
    jobs: int = 1,
    overwrite: bool = False,
) -> None:
    """Make a table and a picture of errors on split sim by number of people, for several spreads of heights.

    Args:
        out: Folder for figure-sigma.md, .csv and .png, and for datasets and submissions; what it holds is reused.
        solver: Registered names or module:attribute; default: vb-sf, vb-sf with heights from the prior only, and that
            without a prior of the observer's motion.
        protocol: Which truth the solver is given, and when.
        camera: Camera of the observer, as in 'vbbench generate'; default: that of split sim.
        tier: How boxes are corrupted; 'vbbench tiers' lists them.
        sequences: Number of sequences at each spread of heights.
        seed: Seed of all random numbers.
        jobs: Processes; the numbers do not depend on it.
        overwrite: Generate and solve everything again.
    """
    from vbbench.camera import make_camera
    from vbbench.reproduction.sigma import SigmaStudy, compared_solvers
    from vbbench.reproduction.sigma_report import reproduce_sigma

    study = SigmaStudy(
        solvers=solver or tuple(compared_solvers()),
        protocol=protocol,
        camera=None if camera is None else make_camera(camera),
        tier=tier,
        sequences=sequences,
        seed=seed,
    )
    print(reproduce_sigma(study, out, jobs=jobs, overwrite=overwrite))


def table4(
    out: Path = Path("table4"),
    solver: tuple[str, ...] = ("vb-sf", "vb-cv"),
    sequences: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    overwrite: bool = False,
) -> None:
    """Make a table of errors on split street with exact and with tracked boxes, beside the paper's.

    Args:
        out: Folder for table4.md, datasets and submissions; what it holds is reused.
        solver: Registered names or module:attribute.
        sequences: Number of sequences; default: the scenario's ten.
        seed: Seed of all random numbers.
        jobs: Processes; the numbers do not depend on it.
        overwrite: Generate and solve everything again.
    """
    from vbbench.reproduction.table4 import reproduce_table4

    text = reproduce_table4(out, solvers=solver, sequences=sequences, seed=seed, jobs=jobs, overwrite=overwrite)
    print(text)


def readings(
    out: Path = Path("readings"),
    split: tuple[str, ...] = ("hotel", "eth", "students"),
    every: int = 1,
    seed: int = 0,
    jobs: int = 1,
    json: bool = False,
    overwrite: bool = False,
) -> None:
    """Make a table and a picture of the errors under every reading of the paper, beside the paper's.

    Args:
        out: Folder for readings.md, .json and .png, and for datasets and submissions; what it holds is reused.
        split: Of the paper's Table 2.
        every: Only every so-many-th sequence of each split.
        seed: Seed of all random numbers.
        jobs: Processes; the numbers do not depend on it.
        json: Print every figure as JSON instead of the table.
        overwrite: Generate and solve everything again.
    """
    from vbbench.reproduction.readings import ReadingsStudy
    from vbbench.reproduction.readings_report import reproduce_readings

    study = ReadingsStudy(splits=split, every=every, seed=seed)
    table, values = reproduce_readings(study, out, jobs=jobs, overwrite=overwrite)
    print(values if json else table)


def transfer(
    kitti: Path,
    poses: Path | None = None,
    out: Path = Path("transfer"),
    every: tuple[int, ...] = (4, 1),
    split: str = "eth-15fps",
    protocol: tuple[ProtocolName, ...] = ("sequential", "one-step"),
    solver: tuple[str, ...] = (),
    limit: int = 60,
    seed: int = 0,
    jobs: int = 1,
    overwrite: bool = False,
) -> None:
    """Say how alike tier field and KITTI rank solvers: a table, every number as JSON, and a picture.

    Args:
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        poses: Folder of the camera's poses, as for 'vbbench generate kitti --poses'.
        out: Folder for transfer.md, .json and .png, and for datasets and submissions; what it holds is reused.
        every: Every how many frames of KITTI: 4, 1, or both.
        split: Whose people tier field shows; where KITTI's frames lie between theirs, they follow smooth curves.
        protocol: Which truth a solver is given, and when.
        solver: Further solvers to rank beside the installed ones and their variants: names or module:attribute.
        limit: Most sequences of tier field.
        seed: Seed of all random numbers.
        jobs: Processes; the numbers do not depend on it.
        overwrite: Generate and solve everything again.
    """
    from vbbench.reproduction.transfer import TransferStudy
    from vbbench.reproduction.transfer_report import reproduce_transfer
    from vbbench.reproduction.variants import Variant, registered_variants

    variants = registered_variants() | {name: Variant(solver=name) for name in solver}
    study = TransferStudy(
        kitti=kitti,
        poses=poses,
        variants=variants,
        every=every,
        split=split,
        protocols=protocol,
        limit=limit,
        seed=seed,
    )
    print(reproduce_transfer(study, out, jobs=jobs, overwrite=overwrite))
