"""Commands that reproduce the paper's figures."""

from pathlib import Path

from tyro.conf import OmitArgPrefixes

from vbbench.cli.evaluation import ProtocolName
from vbbench.cli.showing import making, show
from vbbench.reproduction.work import Work


def figure_sigma(
    out: Path = Path("figure-sigma"),
    solver: tuple[str, ...] = (),
    protocol: ProtocolName = "one-step",
    camera: str | None = None,
    tier: str = "ideal",
    sequences: int = 500,
    seed: int = 0,
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
    json: bool = False,
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
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.camera import make_camera
    from vbbench.reproduction.sigma.figure import sigma_report
    from vbbench.reproduction.sigma.study import SigmaStudy, compared_solvers, measure_sigma

    study = SigmaStudy(
        solvers=solver or tuple(compared_solvers()),
        protocol=protocol,
        camera=None if camera is None else make_camera(camera),
        tier=tier,
        sequences=sequences,
        seed=seed,
    )
    show(sigma_report(measure_sigma(study, out, making(work))), out, json)


def figure_posterior(
    out: Path = Path("figure-posterior"),
    split: str = "eth",
    every: int = 1,
    seed: int = 0,
    work: OmitArgPrefixes[Work] = Work(),  # noqa: B008  frozen
    json: bool = False,
) -> None:
    """Draw posteriors of observer and people, their entropy by number of people and directions, and the worst cases.

    Args:
        out: Folder for figure-posterior.md, .json, .csv and pictures, and for a dataset and a submission; what it
            holds is reused.
        split: Of a recording; the paper's is eth.
        every: Only every so-many-th sequence.
        seed: Seed of all random numbers.
        work: Where the work is done.
        json: Print every number as JSON instead of the tables.
    """
    from vbbench.reproduction.posterior.figure import posterior_report
    from vbbench.reproduction.posterior.study import PosteriorStudy, measure_posterior

    study = PosteriorStudy(split=split, every=every, seed=seed)
    show(posterior_report(measure_posterior(study, out, making(work))), out, json)
