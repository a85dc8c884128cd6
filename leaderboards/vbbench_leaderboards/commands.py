"""Commands of the leaderboard: parse, call one library function, print."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Literal

from vbbench.cli.parsing import Further, named

RESULTS = Path("leaderboards/results")
WORK = Path("out/leaderboard")
TEMPLATE = Path(__file__).with_name("template")
Format = Literal["csv", "latex", "markdown", "json", "bibtex"]


def _facts_of_rows() -> dict[str, type]:
    from vbbench_leaderboards.results.result import FACTS

    return dict.fromkeys((*FACTS, "date"), str)


def add(
    submission: Path,
    /,
    dataset: Path,
    truth: Path | None = None,
    results: Path = RESULTS,
    name: str = "",
    about: Annotated[tuple[str, ...], Further(_facts_of_rows)] = (),
    overwrite: bool = False,
) -> None:
    """Score a submission and write its result file.

    In a challenge's results it is taken in for the team --name, if a phase is open: 'vbbench challenge accept'.

    Args:
        submission: Folder with submission.json, poses and positions.
        dataset: The dataset that it answers.
        truth: Folder with the truth tables, if they are not in the dataset.
        results: Folder of the result files.
        name: Name of the solver on the board; default: the one in the submission.
        about: Facts of the row in place of those in submission.json, as NAME=VALUE, or each as an option: --authors;
            --trained-on and --tuned-on ('nothing' is an answer); --delay, the frames that an answer comes after its
            own, or 'offline'; --reference, where it is described; --code, its address; --rerun-by, who else made the
            figures again; --date, its day, YYYY-MM-DD.
        overwrite: Replace an existing result.
    """
    from vbbench_leaderboards.results.folder import challenge_folder_of
    from vbbench_leaderboards.results.result import parse_facts
    from vbbench_leaderboards.submitting import add as write

    facts = parse_facts(named("fact of a row", about, _facts_of_rows()))
    date = facts.pop("date", "")
    challenge = challenge_folder_of(results)
    if challenge is None:
        print(write(submission, dataset, results, truth=truth, overwrite=overwrite, name=name, date=date, **facts))
        return
    from vbbench_leaderboards.challenge.definition import parse_moment
    from vbbench_leaderboards.challenge.submissions import accept

    print(accept(challenge, submission, name, parse_moment(date), **facts))


def try_(
    solver: str,
    /,
    board: str = "sim/sequential-field",
    out: Path | None = None,
    jobs: int = 1,
) -> None:
    """Try a solver on a published board: make its dataset, solve, score, and say where it stands among the others.

    Dataset and answers are kept in out/leaderboard, and a dataset that is there is used again.

    Args:
        solver: A registered name ('vbbench solvers' lists them), or module:attribute of your own.
        board: SPLIT/PROTOCOL-TIER, as in the page's addresses.
        out: Also make the leaderboard's page with it, in this folder; replaced only if it is one.
        jobs: Processes; the answers do not depend on it.
    """
    from vbbench_leaderboards.site.pages import build as make
    from vbbench_leaderboards.site.player import Films
    from vbbench_leaderboards.submitting import TRIED, try_solver

    print(try_solver(solver, board, WORK, jobs=jobs))
    if out is not None:
        make(out, WORK / TRIED, *_folders(None), films=Films(work=WORK, jobs=jobs))
        print(out / "index.html")


def template(folder: Path, /) -> None:
    """Make a folder with templates for a solver, in Python and in another language, and with instructions.

    Args:
        folder: Folder to write into; nothing in it is overwritten.
    """
    from vbbench.folders.replacing import copy_templates

    print(*copy_templates(folder, {path.name: path for path in TEMPLATE.iterdir() if path.is_file()}), sep="\n")


def check(
    results: Path = RESULTS,
    work: Path = WORK,
    dataset: tuple[Path, ...] = (),
    submission: tuple[Path, ...] = (),
) -> None:
    """Check every result file, and score those again whose submission is available.

    Args:
        results: Folder of the result files.
        work: Work folder of 'vbbench leaderboard rerun' with datasets and submissions, if there is one.
        dataset: More dataset folders to score with.
        submission: More submission folders to score again.
    """
    from vbbench_leaderboards.checks import check as verify

    print(verify(results, work=work, datasets=dataset, submissions=submission))


def rerun(
    split: tuple[str, ...] = (),
    solver: tuple[str, ...] = (),
    tier: tuple[str, ...] = (),
    seed: int | None = None,
    by: str = "",
    results: Path = RESULTS,
    work: Path = WORK,
    update: bool = False,
    together: bool = False,
    jobs: int = 1,
    root: Path | None = None,
) -> int:
    """Make the datasets, solve and score every board again with a new seed, and report which results stand.

    Exit status 1 means that something drifted and was not written.

    Args:
        split: Splits; default: all with published boards whose source files are available. 'real' are all families of
            real recordings.
        solver: Solvers; default: all that come with vbbench.
        tier: Tiers; default: those with published boards.
        seed: Seed of the datasets; default: a new one, which is printed. With the boards' own seed (in their records)
            figures must be the same, with any other they must agree within their intervals.
        by: Who makes the figures again, and when; with --update it is written into the rows.
        results: Folder of the result files.
        work: Folder for datasets and submissions; complete ones that the same code made are used again.
        update: Write what drifted and what is new.
        together: Solve with bundled solvers in one process a board, instead of a fresh process for each group of
            sequences that share no moment. Several times as fast.
        jobs: Number of processes; the figures do not depend on it.
        root: Folder with your downloads of real recordings, in folders called like their splits; default:
            $VBBENCH_DATA, then the cache folder.
    """
    from vbbench_leaderboards.checks.rerunning import Rerun

    how: dict[str, Any] = {"seed": seed, "by": by, "update": update, "together": together, "jobs": jobs, "root": root}
    run = Rerun(results=results, work=work, **how)
    drifted = 0
    for outcome in run.boards(split, solver, tier):
        drifted += outcome.is_drift
        print(outcome.text, flush=True)
    return int(drifted > 0)


def export(
    board: tuple[str, ...] = (),
    format: Format = "csv",  # noqa: A002
    results: Path | None = None,
) -> None:
    """Print the tables of boards for papers and programs, or what to cite for them.

    Args:
        board: Boards by name, such as hotel/sequential-field; default: all.
        format: csv, latex (with booktabs), markdown, json, or bibtex for the entries to cite.
        results: Folder of the result files; default: as of 'leaderboard build'.
    """
    from vbbench_leaderboards.results.folder import read_datasets, read_results
    from vbbench_leaderboards.site.export import exported_boards, exported_text

    folders = _folders(results)
    records = read_datasets(*folders)
    boards = exported_boards(read_results(*folders, records=records), records, board)
    print(exported_text(boards, format), end="")


def build(
    out: Path,
    results: Path | None = None,
    work: Path | None = None,
    pictures: str | None = None,
    docs: str = "",
    jobs: int = 1,
) -> None:
    """Make the leaderboard's static site; of a challenge's results the challenge's page.

    Args:
        out: Folder of the site; replaced only if it is one.
        results: Folder of the result files; default: leaderboards/results, if it exists, and those that come with
            vbbench.
        work: Folder of 'leaderboard rerun', for the films of its sequences; default: out/leaderboard, if it exists.
        pictures: Renderer (auto, raster, ...) of what the observer sees behind the boxes; slow, so the
            pictures are kept in the work folder. For 'footage': small copies of the pictures that the camera took;
            mind their licence before you publish the page.
        docs: Address of the documentation, such as ../index.html, to which the page leads.
        jobs: Number of processes; the site does not depend on it.
    """
    from vbbench.generation.footage import FOOTAGE
    from vbbench.pictures.rendering import Backend
    from vbbench_leaderboards.results.folder import challenge_folder_of
    from vbbench_leaderboards.site.pages import build as make
    from vbbench_leaderboards.site.player import Films

    challenge = None if results is None else challenge_folder_of(results)
    if challenge is not None:
        from vbbench_leaderboards.challenge.definition import now
        from vbbench_leaderboards.challenge.standings import build_challenge

        print(build_challenge(out, challenge, now()))
        return
    found = work or (WORK if WORK.is_dir() else None)
    own = pictures == FOOTAGE
    drawn = Backend(name=pictures) if pictures and not own else None
    films = Films(work=found, pictures=drawn, footage=own, jobs=jobs) if found else None
    make(out, *_folders(results), films=films, docs=docs)
    print(out / "index.html")


def _folders(results: Path | None) -> list[Path]:
    """The folder of results that is named; or those found here, and those that come with vbbench."""
    from vbbench_leaderboards.results.folder import published_results

    published = published_results()
    added = [RESULTS] if RESULTS.is_dir() and not RESULTS.samefile(published) else []
    return [results] if results else [*added, published]


def demo(out: Path = Path("vbbench-demo"), full: bool = False, jobs: int = 1) -> None:
    """Generate, solve, score and draw a first result, with a page to open in a browser.

    Args:
        out: Folder to make.
        full: Run every solver that comes with vbbench, under every protocol; minutes.
        jobs: Processes.
    """
    from vbbench_leaderboards.demo import make_demo

    print(make_demo(out, full=full, jobs=jobs))


_NAMED = (add, build, check, export, rerun, template)
COMMANDS: dict[str, Callable[..., Any]] = {one.__name__: one for one in _NAMED} | {"try": try_}

DEMO: dict[str, Callable[..., Any]] = {"": demo}
"""The command without a group."""
