"""Commands that show something: plot, demo."""

from pathlib import Path

from tyro.conf import Positional


def plot(
    folder: Positional[Path],
    /,
    sequence: int,
    out: Path,
    estimate: Path | None = None,
    frame: int | None = None,
    truth: Path | None = None,
) -> None:
    """Draw a sequence: the bird's-eye view beside what the observer sees.

    Args:
        folder: The dataset.
        sequence: Number of the sequence.
        out: PNG file to write.
        estimate: Submission to draw over the truth.
        frame: Frame to show; default: one in the middle.
        truth: Folder with the truth tables, where they are kept elsewhere.
    """
    from vbbench.dataset import Dataset
    from vbbench.plotting import plot_to_file

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
