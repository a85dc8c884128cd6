"""Commands that reproduce the whole paper, and studies that are not of it."""

from pathlib import Path

from vbbench.cli.evaluation import ProtocolName
from vbbench.cli.showing import making, show
from vbbench.reproduction.work import Work


def everything(
    out: Path = Path("reproduced"),
    study: tuple[str, ...] = (),
    every: int = 10,
    kitti: Path | None = None,
    poses: Path | None = None,
    jrdb: Path | None = None,
    bags: Path | None = None,
    motsynth: Path | None = None,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
) -> None:
    """Make every table and figure of the paper, and one page that shows them all beside what the paper prints.

    A study that is done is kept: run the command again after an interruption.

    Args:
        out: Folder for index.html, and a folder for each study.
        study: Names of studies, such as table2 figure-sigma; default: all.
        every: In tables of recordings, only every so-many-th sequence, of Shibuya every sixth of these.
        kitti: Folder of KITTI's tracking benchmark; default: searched in the usual places.
        poses: Folder of the poses of KITTI's camera, as for 'vbbench generate kitti --poses'.
        jrdb: Folder of JRDB, as for 'vbbench generate jrdb --source'.
        bags: Folder of JRDB's rosbags, which tell how the robot moved.
        motsynth: Folder or file of MOTSynth's annotations, as for 'vbbench generate motsynth --source'.
        seed: Seed of all random numbers.
        work: Where the work is done.
    """
    from vbbench.reproduction.everything import reproduce_all
    from vbbench.reproduction.studies import Downloads, the_parts

    downloads = Downloads(kitti=kitti, poses=poses, jrdb=jrdb, bags=bags, motsynth=motsynth)
    parts = the_parts(every=every, seed=seed, only=study, downloads=downloads)
    print(reproduce_all(parts, out, making(work)))


def transfer(
    kitti: Path,
    poses: Path | None = None,
    out: Path = Path("transfer"),
    every: tuple[int, ...] = (4, 1),
    split: str = "eth-15fps",
    smooth: float = 0.0,
    protocol: tuple[ProtocolName, ...] = ("sequential", "one-step"),
    solver: tuple[str, ...] = (),
    limit: int = 60,
    seed: int = 0,
    work: Work = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Say how alike tier field and KITTI rank solvers: a table, every number as JSON, and a picture.

    Args:
        kitti: Folder of KITTI's tracking benchmark, as for 'vbbench generate kitti --source'.
        poses: Folder of the camera's poses, as for 'vbbench generate kitti --poses'.
        out: Folder for transfer.md, .json and .png, and for datasets and submissions; what it holds is reused.
        every: Every how many frames of KITTI: 4, 1, or both.
        split: Whose people tier field shows; where KITTI's frames lie between theirs, they follow smooth curves.
        smooth: Metres (root mean square) by which people may leave where they were recorded, so that walks are smooth.
        protocol: Which truth a solver is given, and when.
        solver: Further solvers to rank beside the installed ones and their variants: names or module:attribute.
        limit: Most sequences of tier field.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.transfer.figure import transfer_report
    from vbbench.reproduction.transfer.study import TransferStudy, measure_transfer
    from vbbench.reproduction.transfer.variants import Variant, registered_variants

    variants = registered_variants() | {name: Variant(solver=name) for name in solver}
    study = TransferStudy(
        kitti=kitti,
        poses=poses,
        variants=variants,
        every=every,
        split=split,
        smooth=smooth,
        protocols=protocol,
        limit=limit,
        seed=seed,
    )
    show(transfer_report(study, measure_transfer(study, out, making(work))), out, json)
