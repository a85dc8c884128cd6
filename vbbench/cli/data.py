"""Commands that make and describe datasets: splits, tiers, fetch, generate, info, verify, card, parts."""

from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal, get_type_hints

from vbbench.cli.parsing import Further, named
from vbbench.cli.terminal import say_warning


def splits() -> None:
    """List every split: licence, citation, and whether its source files are on this machine."""
    from vbbench.generation.generator import describe_splits

    print(describe_splits())


def tiers() -> None:
    """List every tier: what becomes of exact boxes before solvers see them."""
    from vbbench.generation.tier import describe_tiers

    print(describe_tiers())


def fetch(names: tuple[str, ...], /) -> None:
    """Download the source files of splits into $VBBENCH_DATA or the user's cache folder, and check their SHA-256.

    Args:
        names: Splits, such as hotel eth students.
    """
    from vbbench.generation.generator import fetch_splits

    for path in fetch_splits(names):
        print(path)


def _options_of_splits() -> dict[str, Any]:
    from vbbench.generation.options_file import WrittenOptions

    return get_type_hints(WrittenOptions)


def generate(
    split: str,
    /,
    out: Path,
    source: Path | None = None,
    camera: str | None = None,
    tier: str | None = None,
    sigma_h: float | None = None,
    dt: float | None = None,
    homography: Path | None = None,
    sequences: str | None = None,
    every: int | None = None,
    seed: int | Literal["secret"] | None = None,
    limit: int | None = None,
    options: Annotated[tuple[str, ...], Further(_options_of_splits)] = (),
    jobs: int = 1,
    scheduler: str | None = None,
    withhold_truth: bool = False,
    overwrite: bool = False,
) -> None:
    """Make a dataset folder.

    Some splits and tiers have more options: --observer (walker, vehicle, robot), --stride; of simulated crowds
    --scenario and --people (30, 10:50, 10:50:10); of footage --longest, --poses, --boxes, --bags, --person-class; and
    others (docs/commands-data.md).

    Args:
        split: Its name; see 'vbbench splits'.
        out: Folder to make.
        source: File, archive or folder with the source files; default: $VBBENCH_DATA, then the cache folder.
        camera: panorama, equirectangular, perspective or a registered model; of a car, panorama or names of its cameras
            with commas between; default: the tier's, or the split's.
        tier: How boxes are corrupted; see 'vbbench tiers'; default: ideal (exact).
        sigma_h: Standard deviation of people's heights in m; default: .07, or the tier's.
        dt: Seconds per frame of your own file.
        homography: File with the 3x3 image-to-ground homography of a file in pixels, or of the camera's pictures.
        sequences: Number of sequences (simulated), or names of recordings with commas between (footage).
        every: Only every so many frames; default: the split's own.
        seed: Seed of all random numbers; default: 0. With --withhold-truth also: secret, one that nobody can guess.
        limit: Make only this many sequences, from the first.
        options: A TOML file of options, or a dataset.json, whose options are taken; and single ones as NAME=VALUE.
        jobs: Processes; the bytes do not depend on it.
        scheduler: Address of a Dask cluster (tcp://...) that does the work instead.
        withhold_truth: Write the truth tables and the seed to OUT.truth; the dataset keeps their hashes.
        overwrite: Replace an existing dataset.
    """
    from vbbench.errors import VbbenchError
    from vbbench.files.dataset_info import describe
    from vbbench.files.withholding import secret_seed
    from vbbench.generation.datasets import generate as make
    from vbbench.generation.datasets import who_knows
    from vbbench.generation.options_file import read_options

    if seed == "secret" and not withhold_truth:
        raise VbbenchError("--seed secret is for --withhold-truth; without it the seed is published")
    number = secret_seed(out) if seed == "secret" else seed
    given = {"camera": camera, "tier": tier, "sigma_h": sigma_h, "dt": dt, "seed": number}
    given |= {"sequences": sequences, "every": every, "limit": limit}
    written = read_options(options, split, seed=number).with_given(**given)
    wanted = written.options(split, source=source, homography=homography)
    kept = {"withhold_truth": withhold_truth, "overwrite": overwrite}
    facts = make(split, out, wanted, jobs=jobs, scheduler=scheduler, **kept).info
    doubt = who_knows(split, wanted.seed) if withhold_truth else None
    if doubt is not None:
        say_warning(doubt.replace("a secret seed", "--seed secret"))
    print(describe(facts))


def info(folder: Path, /, json: bool = False) -> None:
    """Print a dataset's row of Table 1 and the paper's, and its parameters.

    Args:
        folder: The dataset.
        json: Machine-readable.
    """
    from vbbench.files.dataset_info import DatasetInfo, describe, summary_json

    facts = DatasetInfo.read(folder)
    print(summary_json(facts) if json else describe(facts))


def verify(folder: Path, /, truth: Path | None = None) -> None:
    """Check every checksum and invariant of a dataset.

    Args:
        folder: The dataset.
        truth: Folder with the truth tables, if they are not in the dataset.
    """
    from vbbench.files.verification import verify as check

    print(check(folder, truth))


def _facts_of_publishers() -> dict[str, type]:
    from vbbench.files.cards.subject import Publisher

    return dict.fromkeys((field.name for field in fields(Publisher)), str)


def card(
    folder: Path,
    /,
    about: Annotated[tuple[str, ...], Further(_facts_of_publishers)] = (),
    overwrite: bool = False,
) -> None:
    """Write the cards of a dataset, README.md and croissant.json, for a folder without them or to publish it.

    Args:
        folder: The dataset.
        about: What only you know, as NAME=VALUE, or each as an option: --creator; --url, where it is published, and
            --published, the day, such as 2026-11-30; --contact, whom to ask; --licence and --citation of a recording of
            your own.
        overwrite: Replace its cards.
    """
    from vbbench.files.cards.subject import Publisher
    from vbbench.files.cards.writing import card_dataset

    for path in card_dataset(
        folder, Publisher(**named("fact of a card", about, _facts_of_publishers())), overwrite=overwrite
    ):
        print(path)


def parts(
    folder: Path,
    /,
    by: Literal["time", "recording", "seed"] | None = None,
    test: str | None = None,
    json: bool = False,
) -> None:
    """Print the official training, validation and test sequences of a dataset.

    Args:
        folder: The dataset.
        by: time cuts each recording in three, with gaps that nobody stays through; recording holds one out (--test);
            seed looks at the seed of a simulated split: 0 tests, 1 validates, others train. Default: seed for
            simulated splits, time for others.
        test: With --by recording: name of the recording that tests, such as hotel.
        json: Print the lists as JSON.
    """
    from vbbench.files.dataset import Dataset
    from vbbench.training import parts as find_parts
    from vbbench.training.splitting import describe

    dataset = Dataset(folder)
    found = find_parts(dataset, by, test=test)
    print(found.to_json() if json else describe(found, dataset), end="" if json else "\n")
