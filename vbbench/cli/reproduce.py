"""The command that reproduces the paper's tables and figures, and a study that is not of it."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

from vbbench.cli.evaluation import ProtocolName
from vbbench.cli.parsing import Further, named


@dataclass(frozen=True, kw_only=True)
class Study:
    """What is measured; a study refuses what it does not read.

    Args:
        split: Only these splits.
        solver: Registered names or module:attribute, in place of a study's own; figure-robot and transfer add them to
            theirs.
        protocol: Which truth solvers are given, and when.
        every: Only every so-many-th sequence; of transfer, every so-many-th frame.
        sequences: Number of simulated sequences; of transfer, at most.
        seed: Of all random numbers; default: 0.
    """

    split: tuple[str, ...] | None = None
    solver: tuple[str, ...] | None = None
    protocol: tuple[ProtocolName, ...] | None = None
    every: int | None = None
    sequences: int | None = None
    seed: int | None = None


def _own_downloads() -> dict[str, type]:
    return dict.fromkeys(("kitti", "poses", "jrdb", "bags", "motsynth", "argoverse2", "nuscenes"), Path)


@dataclass(frozen=True, kw_only=True)
class Work:
    """Where and how it is made.

    Args:
        out: Folder for the report, and for datasets and submissions; what it holds is reused. Default: named after the
            study, or reproduced.
        jobs: Processes; the numbers do not depend on it.
        scheduler: Address of a Dask cluster (tcp://...) that makes datasets and submissions instead.
        overwrite: Generate and solve everything again.
        json: Print every number of one study as JSON instead of its tables.
    """

    out: Path | None = None
    jobs: int = 1
    scheduler: str | None = None
    overwrite: bool = False
    json: bool = False


def reproduce(
    names: tuple[str, ...],
    /,
    study: Study = Study(),
    downloads: Annotated[tuple[str, ...], Further(_own_downloads)] = (),
    work: Work = Work(),
) -> None:
    """Make the paper's tables and figures again. The paper's numbers stand next to those measured here.

    table1               sequences, frames and people of every split
    table2, table3       every solver on Hotel, ETH and Students, and on Shibuya
    table4               errors on street with centre lines and with tracked boxes
    figure-trajectories  true and estimated trajectories, an example of every split
    figure-sigma         errors over the number of people, for several spreads of heights
    figure-keypoints     camera poses from static points at a distance, and those from people
    figure-posterior     posteriors of observer and people, and their entropy
    figure-robot         how far a camera drifts without known motion: a simulated robot, KITTI, JRDB
    readings, transfer   errors under every reading of the paper; whether tier field ranks solvers as KITTI does
    all                  a page of all but transfer, of every tenth sequence

    Args:
        names: Studies; several make one page.
        study: What is measured.
        downloads: Your own, as NAME=FOLDER, or each as an option: --kitti, KITTI's tracking benchmark; --poses, its
            camera's poses; --jrdb; --bags, JRDB's rosbags; --motsynth; --argoverse2; --nuscenes.
        work: Where and how.
    """
    from vbbench.errors import VbbenchError
    from vbbench.reproduction.grid import Making
    from vbbench.reproduction.report import shown, write_report
    from vbbench.reproduction.studies import chosen_studies, reproduce_all

    options = {name: value for name, value in asdict(study).items() if value is not None}
    options |= named("download", downloads, _own_downloads())
    studies = chosen_studies(names, options)
    making = Making(jobs=work.jobs, scheduler=work.scheduler, overwrite=work.overwrite)
    if len(studies) > 1:
        if work.json:
            raise VbbenchError("--json is of one study, and a page writes that of each; remove it")
        print(reproduce_all(studies, work.out or Path("reproduced"), making))
        return
    ((name, only),) = studies.items()
    out = work.out or Path(name)
    report = only.run(out, making)
    print(shown(report, write_report(report, out), as_json=work.json))
