"""Commands that show something: plot, demo."""

from pathlib import Path

from tyro.conf import Positional

from vbbench.cli.evaluation import ProtocolName


def plot(
    folder: Positional[Path],
    /,
    sequence: int,
    out: Path,
    estimate: Path | None = None,
    frame: int | None = None,
    truth: Path | None = None,
    posterior: bool = False,
    solver: str = "vb-cv",
    protocol: ProtocolName = "one-step",
) -> None:
    """Draw a sequence: the bird's-eye view beside what the observer sees, or beside where the observer may be.

    Args:
        folder: The dataset.
        sequence: Number of the sequence.
        out: PNG file to write.
        estimate: Submission to draw over the truth.
        frame: Frame to show; default: one in the middle.
        truth: Folder with the truth tables, where they are kept elsewhere.
        posterior: Draw the posterior of the observer's place as --solver sees it, instead of the ego view.
        solver: With --posterior: a registered name or module:attribute of your own.
        protocol: With --posterior: what the solver is given.
    """
    from vbbench.dataset import Dataset
    from vbbench.errors import VbbenchError
    from vbbench.plotting import plot_posterior_to_file, plot_to_file

    if posterior:
        if estimate is not None:
            raise VbbenchError("--posterior draws what --solver estimates; leave --estimate out")
        options = {"solver": solver, "protocol": protocol, "frame": frame}
        print(plot_posterior_to_file(Dataset(folder, truth), sequence, out, **options))
        return
    print(plot_to_file(Dataset(folder, truth), sequence, out, submission=estimate, frame=frame))


def demo(out: Path = Path("vbbench-demo"), jobs: int = 1) -> None:
    """Generate, solve with every bundled solver under every protocol, score, and draw pictures.

    Uses the real Hotel recording where its source is at hand, and made crowds otherwise.

    Args:
        out: Folder to make.
        jobs: Processes.
    """
    from vbbench.demo import run_demo

    print(run_demo(out, jobs=jobs))
