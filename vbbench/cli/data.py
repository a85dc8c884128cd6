"""Commands that make and describe datasets: splits, tiers, fetch, generate, merge, info, verify, card."""

from pathlib import Path
from typing import Literal

from tyro.conf import Positional

from vbbench.cli.terminal import say_warning

EngineName = Literal["vbbench", "pysocialforce"]


def splits() -> None:
    """List every split: licence, citation, and whether its source files are on this machine."""
    from vbbench.generation.catalogue import describe_splits

    print(describe_splits())


def tiers() -> None:
    """List every tier: what becomes of exact boxes before solvers see them."""
    from vbbench.generation.tier import describe_tiers

    print(describe_tiers())


def fetch(names: Positional[tuple[str, ...]], /) -> None:
    """Download the source files of splits into $VBBENCH_DATA or the user's cache folder, and check their SHA-256.

    The same command continues an interrupted download.

    Args:
        names: Splits, such as hotel eth students.
    """
    from vbbench.generation.catalogue import fetch_splits

    for path in fetch_splits(names):
        print(path)


def generate(
    split: Positional[str],
    /,
    out: Path,
    source: Path | None = None,
    camera: str | None = None,
    tier: str = "ideal",
    sigma_h: float | None = None,
    look: Literal["motion", "wander", "natural", "follow", "ahead", "glance", "sway"] | None = None,
    observer: Literal["walker", "vehicle", "robot"] = "walker",
    detector: bool = True,
    noise: float | None = None,
    least_track: int | None = None,
    seed: int | Literal["secret"] = 0,
    limit: int | None = None,
    stride: int | None = None,
    dt: float | None = None,
    homography: Path | None = None,
    scenario: str | None = None,
    sequences: str | None = None,
    people: str | None = None,
    engine: EngineName | None = None,
    every: int | None = None,
    longest: int | None = None,
    poses: Path | None = None,
    boxes: Path | None = None,
    person_class: str | None = None,
    bags: Path | None = None,
    cyclists: bool = False,
    interpolated: bool = True,
    jobs: int = 1,
    scheduler: str | None = None,
    tls: Path | None = None,
    withhold_truth: bool = False,
    overwrite: bool = False,
) -> None:
    """Make a dataset folder.

    Args:
        split: Its name; see 'vbbench splits'.
        out: Folder to make.
        source: File, archive or folder with the source files; default: $VBBENCH_DATA, then the cache folder.
        camera: panorama (a cylinder of 360 degrees), equirectangular (a sphere), perspective (90 degrees, 1280x720), or
            one that an installed package registers; default: the tier's (field: KITTI's), or the split's own
            (perspective for sim, street; panorama elsewhere).
        tier: How boxes are corrupted: ideal (exact), noisy, or another one that 'vbbench tiers' lists.
        sigma_h: Standard deviation of people's heights in m, .07 by default; their mean is 1.70 m. Tier field has
            heights of its own.
        look: How the camera turns: motion (along its bearer's past motion), wander (wandering about that), natural (as
            people's heads do: one of the laws follow, ahead, glance and sway in each sequence), or one of these laws
            alone; default: the tier's own.
        observer: Who carries the camera: a walker, one of the people; a vehicle that stands or drives among them; or a
            robot that drives among them and measures its own motion (splits sim, street).
        detector: In tier field, boxes of a detector and tracker; without it, boxes as people draw them.
        noise: Standard deviation in px of columns, tops and bottoms of boxes in tier noisy; default: 1.
        least_track: Fewest frames of a track that counts, in tiers tracked and field; default: 3. The paper's rule,
            tracked in more than three frames, is 4.
        seed: Seed of all random numbers. With --withhold-truth also: secret, a new one that cannot be guessed.
        limit: Make only this many sequences, from the first.
        stride: Of these, make only every so many-th.
        dt: Seconds per frame of your own file (split custom).
        homography: 3x3 image-to-ground homography of your own file in pixels (split custom), or of the camera's
            pictures, instead of its calibration (splits shibuya01 and shibuya02).
        scenario: Scenario of a simulated crowd: a name such as open or plaza, or your own TOML file (split sim).
        sequences: Number of sequences (splits sim and street), or names of recordings with commas between (footage).
        people: Numbers of people, used in turn: 30, or 10:50, or 10:50:10 for steps of ten (splits sim, street).
        engine: Crowd simulator: vbbench, or the library pysocialforce (splits sim, street).
        every: Only every so many frames of footage; default: the split's own.
        longest: Frames after which a sequence of footage is cut; default: the split's own.
        poses: Folder or file of the camera's poses, instead of those of the source (footage).
        boxes: Folder or file of a detector's or tracker's boxes, KITTI's text or any form that 'birdify' reads, instead
            of those of people who drew them (footage).
        person_class: Class of people in these boxes, by number or name, where the file does not show it.
        bags: Folder of the robot's recordings of its wheels and IMU, or of its odometry as JSON (split jrdb).
        cyclists: People on bicycles count, too (split kitti).
        interpolated: Leave out boxes that were interpolated between drawn ones (split jrdb).
        jobs: Processes; the bytes do not depend on it.
        scheduler: Address of a Dask cluster (tcp://...) that does the work instead; then 'vbbench merge OUT'.
        tls: Folder with the certificates (ca.pem, cert.pem, key.pem) of a cluster whose address is tls://...
        withhold_truth: Write the truth tables and the seed to OUT.truth; the dataset keeps their hashes.
        overwrite: Replace an existing dataset.
    """
    from vbbench.camera import make_camera
    from vbbench.cli.asking import as_footage, as_simulation, parse_count
    from vbbench.errors import VbbenchError
    from vbbench.files.dataset_info import describe
    from vbbench.files.withholding import secret_seed
    from vbbench.generation import generate_partitioned
    from vbbench.generation.datasets import generate as make
    from vbbench.generation.datasets import who_knows
    from vbbench.generation.generator import FootageGenerator, Options
    from vbbench.registry import load

    if seed == "secret" and not withhold_truth:
        raise VbbenchError("--seed secret is for --withhold-truth; without it the seed is published")
    if tls and scheduler is None:
        raise VbbenchError("--tls is for a cluster; add --scheduler tls://HOST:PORT")
    of_footage = isinstance(load("generator", split), FootageGenerator)
    options = Options(
        camera=None if camera is None else make_camera(camera),
        tier=tier,
        height_std=sigma_h,
        look=look,
        observer=observer,
        detector=detector,
        noise=noise,
        least_track=least_track,
        seed=secret_seed(out) if seed == "secret" else seed,
        limit=limit,
        stride=stride,
        source=source,
        dt=dt,
        homography=homography,
        simulation=as_simulation(
            scenario, None if of_footage or not sequences else parse_count(sequences), people, engine
        ),
        footage=as_footage(
            sequences if of_footage else None,
            every=every,
            longest=longest,
            poses=poses,
            boxes=boxes,
            person_class=person_class,
            bags=bags,
            cyclists=cyclists or None,
            interpolated=None if interpolated else False,
        ),
    )
    if scheduler is None:
        facts = make(split, out, options, jobs=jobs, withhold_truth=withhold_truth, overwrite=overwrite).info
    else:
        kept = {"withhold_truth": withhold_truth, "overwrite": overwrite}
        facts = generate_partitioned(split, out, options, scheduler=scheduler, tls=tls, **kept)
    doubt = who_knows(split, options.seed) if withhold_truth else None
    if doubt is not None:
        say_warning(doubt.replace("a secret seed", "--seed secret"))
    print(describe(facts))


def merge(folder: Positional[Path], /, out: Path | None = None, overwrite: bool = False) -> None:
    """Merge the partitions that generate or solve made with --scheduler.

    Args:
        folder: The partitioned dataset or submission.
        out: Folder to make; default: the merged files replace the partitions.
        overwrite: Replace an existing dataset or submission in OUT, and the truth beside it.
    """
    from vbbench.parallel.partitions import merge as merge_partitions

    print(merge_partitions(folder, out, overwrite=overwrite))


def info(
    folder: Positional[Path],
    /,
    json: bool = False,
    realism: bool = False,
    plot: Path | None = None,
    truth: Path | None = None,
) -> None:
    """Print a dataset's row of Table 1 and the paper's, its parameters, and how its people walk.

    Args:
        folder: The dataset.
        json: Machine-readable.
        realism: Distributions of speed, nearest distance, acceleration and path efficiency, beside recordings.
        plot: With --realism: PNG file to write; default: realism.png.
        truth: With --realism: folder with the truth tables, where they are kept elsewhere.
    """
    from vbbench.errors import VbbenchError
    from vbbench.files.dataset_info import DatasetInfo, describe, summary_json

    if not realism:
        if plot or truth:
            raise VbbenchError("--plot and --truth belong to --realism; add it")
        facts = DatasetInfo.read(folder)
        print(summary_json(facts) if json else describe(facts))
        return
    from vbbench.files.dataset import Dataset
    from vbbench.realism.drawing import plot_realism_to_file
    from vbbench.realism.report import describe_realism, measure_realism, realism_json

    report = measure_realism(Dataset(folder, truth))
    picture = plot_realism_to_file(report, plot or Path("realism.png"))
    print(realism_json(report, picture) if json else f"{describe_realism(report)}\n{picture}")


def verify(folder: Positional[Path], /, truth: Path | None = None) -> None:
    """Check every checksum and invariant of a dataset.

    Args:
        folder: The dataset.
        truth: Folder with the truth tables, if they are not in the dataset.
    """
    from vbbench.files.verification import verify as check

    print(check(folder, truth))


def card(
    folder: Positional[Path],
    /,
    creator: str | None = None,
    url: str | None = None,
    published: str | None = None,
    contact: str | None = None,
    licence: str | None = None,
    citation: str | None = None,
    overwrite: bool = False,
) -> None:
    """Write the cards of a dataset, README.md and croissant.json, for a folder without them or to publish it.

    Args:
        folder: The dataset.
        creator: Who made it.
        url: Where it is published.
        published: The day, such as 2026-11-30.
        contact: Whom to ask, or to tell of a mistake.
        licence: Of a recording of your own; that of every other split is known.
        citation: How to cite this dataset, or a recording of your own.
        overwrite: Replace its cards.
    """
    from vbbench.files.cards.origin import Publisher
    from vbbench.files.cards.writing import card_dataset

    publisher = Publisher(
        creator=creator, url=url, published=published, contact=contact, licence=licence, citation=citation
    )
    for path in card_dataset(folder, publisher, overwrite=overwrite):
        print(path)


def parts(
    folder: Positional[Path],
    /,
    by: Literal["time", "recording", "seed"] | None = None,
    test: str | None = None,
    out: Path | None = None,
    json: bool = False,
) -> None:
    """Print the official training, validation and test sequences of a dataset.

    Args:
        folder: The dataset.
        by: time cuts each recording in three, with gaps that nobody stays through; recording leaves one out (--test);
            seed looks at the seed of a simulated split: 0 tests, 1 validates, others train. Default: seed for
            simulated splits, time for others.
        test: With --by recording: name of the recording that tests, such as hotel.
        out: JSON file to write the lists to.
        json: Print the lists as JSON.
    """
    from vbbench.files.dataset import Dataset
    from vbbench.folders.replacing import write_text_atomically
    from vbbench.training import parts as find_parts
    from vbbench.training.splitting import describe

    dataset = Dataset(folder)
    found = find_parts(dataset, by, test=test)
    if out is not None:
        write_text_atomically(out, found.to_json())
    print(found.to_json() if json else describe(found, dataset), end="" if json else "\n")
