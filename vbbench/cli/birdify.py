"""The command that makes a map of a user's own boxes: birdify."""

from pathlib import Path

from tyro.conf import Positional

from vbbench.cli.views import announce


def birdify(
    boxes: Positional[Path],
    /,
    camera: Path,
    out: Path,
    odometry: Path | None = None,
    solver: str = "map-causal",
    film: bool = False,
    no_film: bool = False,
    overwrite: bool = False,
) -> None:
    """Make a map of where a camera and the people around it were, from their boxes alone.

    Args:
        boxes: MOTChallenge text or CSV with a header; a tracker links boxes without ids.
        camera: TOML file with the picture's size, focal length, mount height and frame rate; see docs/own.md.
        out: Folder to make: poses, positions, map.png, film.mp4, report.md.
        odometry: TUM file of the observer's own measurement of its motion.
        solver: A registered name or module:attribute of your own.
        film: Make a film, however long; without it films have 300 frames at most.
        no_film: Make no film.
        overwrite: Replace a folder that birdify made.
    """
    from vbbench.birdify.birdify import birdify as make
    from vbbench.errors import VbbenchError

    if film and no_film:
        raise VbbenchError("--film and --no-film exclude each other; keep one of them")
    wanted = True if film else (False if no_film else None)
    made = make(
        boxes, camera, out, odometry=odometry, solver=solver, film=wanted, overwrite=overwrite, announce=announce
    )
    print(f"{made.folder}: {made.report.summary()}")
