"""Commands that show something: plot, render, view."""

from pathlib import Path

from vbbench.cli.terminal import say
from vbbench.errors import one_line


def plot(
    folder: Path,
    /,
    sequence: int,
    out: Path,
    estimate: tuple[Path, ...] = (),
    frame: int | None = None,
) -> None:
    """Draw a sequence: the bird's-eye view next to the observer's view.

    Args:
        folder: The dataset.
        sequence: Number of the sequence.
        out: File to write: .png, .pdf or .svg.
        estimate: Submission to draw over the truth; or several, each in the colour of its solver.
        frame: Frame to show; default: one in the middle.
    """
    from vbbench.files.dataset import Dataset
    from vbbench.pictures.plotting import plot_to_file

    print(plot_to_file(Dataset(folder), sequence, out, submissions=estimate, frame=frame))


def render(
    folder: Path,
    /,
    sequence: int,
    out: Path,
    backend: str = "auto",
    footage: bool = False,
    estimate: Path | None = None,
) -> None:
    """Film a sequence: the observer's view, with boxes and ids, next to the bird's-eye view.

    Args:
        folder: The dataset, of any split.
        sequence: Number of the sequence.
        out: An .mp4 file, or a folder for one PNG file per frame; an interrupted one is continued.
        backend: Renderer: raster (auto), pyrender or module:attribute of your own.
        footage: Show the pictures that the camera itself took, or a plain ground where there are none; no renderer, and
            no truth, is needed.
        estimate: Submission to draw over the truth.
    """
    from vbbench.errors import VbbenchError
    from vbbench.files.dataset import Dataset
    from vbbench.pictures.rendering import AUTO, Backend, render_to_file

    if footage and backend != AUTO:
        raise VbbenchError("--footage needs no renderer; remove --backend")
    path = render_to_file(
        Dataset(folder),
        sequence,
        out,
        backend=Backend(name=backend),
        footage=footage,
        submission=estimate,
        announce=announce,
    )
    print(path)


def view(
    folder: Path,
    /,
    sequence: int,
    estimate: tuple[Path, ...] = (),
    out: Path | None = None,
    footage: bool = False,
) -> None:
    """Record a sequence for the rerun viewer, and open it if there is a display (extra `viewer`).

    Args:
        folder: The dataset.
        sequence: Number of the sequence.
        estimate: Submissions to show next to the truth.
        out: The .rrd file to write, and not to open; default: named after split and sequence, and opened.
        footage: Record the pictures that the camera itself took.
    """
    from vbbench.files.dataset import Dataset
    from vbbench.pictures.viewer import record_to_file
    from vbbench.pictures.viewer.marks import Opened, how_to_open, open_viewer

    path = record_to_file(Dataset(folder), sequence, out, submissions=estimate, footage=footage)
    print(path)
    opened = open_viewer(path) if out is None else None
    if opened is not Opened.SHOWN:
        announce(f"open it with: {how_to_open(path)}" + (f" ({opened.value})" if opened else ""))


def announce(text: str) -> None:
    """Print progress on stderr, on one line."""
    say(one_line(text))
