"""What can truthfully be said of a made dataset beyond its figures: how it came about, what it is not good for, whom it
shows.

The README and the fields of Croissant's vocabulary for responsible AI say the same, and take it from here.
"""

from dataclasses import dataclass

from vbbench.files.cards.origin import OWN, Origin, Publisher, hub_identifier, said_licence
from vbbench.files.cards.subject import Subject
from vbbench.files.dataset_info import DatasetInfo, given_noise

TASK = (
    "View birdification asks where a moving camera is on the ground plane, which way it looks, and where the people "
    "around it walk. All that a solver gets is the boxes of the people in the camera's pictures, frame by frame, and "
    "a few first positions."
)


@dataclass(frozen=True, kw_only=True)
class Statements:
    """Sentences about a dataset.

    Parameters
    ----------
    kind : what it shows, and how it was seen, on one line.
    collection : how it came about. ``collection_types`` : the same, in the words of Croissant's vocabulary.
    raw : what it was made from.
    preprocessing : what was done to that.
    missing : what is not in it.
    known : what is known of the truth, and where that is.
    limitations, biases : what a figure measured on it does not say.
    privacy : who the people are.
    uses, misuses : what it is for, and what not.
    sharing : whether it may be given to others.
    maintenance : how it stays what it is, and what happens to mistakes.
    """

    kind: str
    collection: str
    collection_types: tuple[str, ...]
    raw: str
    preprocessing: tuple[str, ...]
    missing: str
    known: str
    limitations: tuple[str, ...]
    biases: tuple[str, ...]
    privacy: str
    uses: tuple[str, ...]
    misuses: tuple[str, ...]
    sharing: str
    maintenance: str


def statements_of(subject: Subject) -> Statements:
    """What can be said of a dataset."""
    info, origin, publisher, footage = subject.info, subject.origin, subject.publisher, subject.is_footage
    return Statements(
        kind=_kind(footage, origin.recorded),
        collection=_collection(footage, origin.recorded),
        collection_types=("Secondary Data analysis",) if origin.recorded else ("Software Collection",),
        raw=_raw(info, origin),
        preprocessing=_preprocessing(info, origin, footage),
        missing=_missing(info),
        known=_known(info),
        limitations=_limitations(info, origin, footage),
        biases=_biases(origin.recorded),
        privacy=_privacy(footage, origin.recorded),
        uses=_uses(info),
        misuses=_misuses(origin.recorded),
        sharing=_sharing(said_licence(origin, publisher), origin),
        maintenance=_maintenance(publisher),
    )


def _kind(footage: bool, recorded: bool) -> str:
    if footage:
        return "boxes of people in a real camera's pictures" if recorded else "boxes of people in a game's pictures"
    crowd = "a recorded crowd" if recorded else "simulated crowds"
    return f"{crowd}, seen by a simulated camera"


def _collection(footage: bool, recorded: bool) -> str:
    if footage and recorded:
        return "A camera filmed people; boxes about them were drawn or detected in its pictures. No picture is kept."
    if footage:
        return "A game made pictures of its people and wrote down where they are. No picture is kept."
    if recorded:
        return (
            "The paths of people were recorded and read from pictures by others. Here a simulated camera moves among "
            "these paths, and the boxes are computed that it would see."
        )
    return "A program moves people by forces between them, and computes the boxes that a camera among them would see."


def _raw(info: DatasetInfo, origin: Origin) -> str:
    if origin.files:
        return f"Source files: {'; '.join(f'{path} from {address}' for path, address in origin.files)}."
    if info.sources or origin.recorded:
        return _own_sources(info)
    return "No source files: everything follows from the parameters in dataset.json and the seed."


def _own_sources(info: DatasetInfo) -> str:
    if info.sources:
        return f"{len(info.sources)} source files, whose SHA-256 stand under `definition` in dataset.json."
    return "What it was made from stands under `definition` in dataset.json."


def _preprocessing(info: DatasetInfo, origin: Origin, footage: bool) -> tuple[str, ...]:
    tier = f" {origin.tier}" if origin.tier else ""
    steps = [
        f"Tier `{info.tier}`.{tier} Solvers are given these errors: {given_noise(info)}.",
    ]
    if info.truth in ("whole", "poses"):
        steps.append("Every sequence has its own world: its scene, turned and shifted at random.")
    if not footage:
        given = f"N({info.height_mean:g}, {info.height_std:g}²) m"
        steps.append(f"People's heights are drawn, not measured; solvers are given {given}.")
    grid = info.definition.get("grid")
    if isinstance(grid, float):
        steps.append(f"Places in the source are multiples of {grid:g} m, and were spread within that by the seed.")
    if "import" in info.definition:
        steps.append("Boxes and tracks are those of another program, read by `vbbench import mot`.")
    if info.calibration is not None:
        steps.append(f"Calibration: {info.calibration['summary']}.")
    steps.append("The rules that chose people and frames stand under `definition` in dataset.json.")
    return tuple(steps)


def _missing(info: DatasetInfo) -> str:
    parts = ["A person without a box in a frame has no row there; NaN stands for what was not measured or is not given"]
    limit, stride = (info.definition.get(name) for name in ("limit", "stride"))
    if limit is not None:
        parts.append(f"only the first {limit} sequences were asked for")
    if stride is not None:
        parts.append(f"one of every {stride} sequences was made")
    return "; ".join(parts) + "."


def _known(info: DatasetInfo) -> str:
    if info.seed is None:
        return (
            "The truth and the seed are withheld by whoever made the dataset; the SHA-256 of every truth table "
            "lets people check later that it was not exchanged."
        )
    return {
        "whole": "Truth is in the folder `truth`: the observer's poses, everybody's positions and heights.",
        "poses": "Truth is in the folder `truth`: the observer's poses. Where people are was not measured.",
        "relative": "Truth is in the folder `truth`: where people are as seen from the camera, whose own place was "
        "not measured.",
        "none": "No truth was ever measured.",
    }[info.truth]


def _limitations(info: DatasetInfo, origin: Origin, footage: bool) -> tuple[str, ...]:
    said = [_sentence(info.caution)] if info.caution else []
    said.append("A place is two numbers on a plane: ramps and stairs are not in the data.")
    if not footage:
        said.append("A simulated camera has no lens, no blur and no exposure, unless the tier says otherwise.")
    if info.tier == "ideal":
        said.append("Boxes are exact: figures measured here are a diagnostic, and say little of real cameras.")
    if origin.files:
        said.append("The source is public: whoever has it knows the truth, even where it is not given.")
    if info.scenes:
        said.append("Sequences of one scene share people and time, so that their errors are not independent.")
    return tuple(said)


def _biases(recorded: bool) -> tuple[str, ...]:
    if not recorded:
        return (
            "People move by one program's rules. Whatever real people do that these rules lack is missing here: a "
            "solver that knows the rules has an advantage it would not have outside.",
        )
    return (
        "The people are those of a few recordings: how people walk, how near they come and how tall they are differs "
        "from place to place, and with age, ability, time of day and purpose. None of this was recorded of them.",
    )


def _privacy(footage: bool, recorded: bool) -> str:
    if not recorded:
        return "Nobody: the people are a program's, and no real person can be found in the data."
    filmed = "of real people who were recorded and, as far as vbbench knows, not asked one by one"
    if footage:
        return (
            f"The data hold boxes and, where measured, places {filmed}. There are no names or faces here; with the "
            "pictures of the source, which are not included, people could be recognised. Do not try to."
        )
    return (
        f"The data hold the paths {filmed}. There are no names, faces or pictures here, but whoever knows who was "
        "where and when could recognise a person by the path. Do not try to. Nothing else about them is in the data."
    )


def _uses(info: DatasetInfo) -> tuple[str, ...]:
    uses = ["Testing methods of view birdification, under the protocols of vbbench: `vbbench solve`, `vbbench score`."]
    if info.truth == "whole" and info.seed is not None:
        uses.append(
            "Training and validation, as long as no sequence of a tested scene is used: cut by time or by recording, "
            "never at random."
        )
    return tuple(uses)


def _misuses(recorded: bool) -> tuple[str, ...]:
    said = ["Proof that a robot or vehicle is safe among people: no figure measured here is one."]
    if recorded:
        said.append("Finding, following or identifying real persons, in this recording or in others.")
    return tuple(said)


def _sharing(licence: str, origin: Origin) -> str:
    if origin.licence in OWN:
        return f"The recording belongs to whoever made it, and so does the licence: {_full(licence)}"
    hub = hub_identifier(licence)
    if hub == "unknown":
        return (
            f"Licence of the source: {licence}. Nobody has allowed the source to be passed on, and tables and truth "
            "are made of it: share the command, not the folder."
        )
    if hub == "other":
        return f"Licence of the source: {licence}. The tables are made of it: read it before you pass this folder on."
    if "-sa-" in hub:
        return f"Licence: {_full(licence)} What is made of it may be passed on under the same licence, with credit."
    return f"Licence: {_full(licence)}"


def _maintenance(publisher: Publisher) -> str:
    contact = f" Questions and mistakes: {publisher.contact}." if publisher.contact else ""
    return (
        "The folder never changes: its id stands for all parameters, dataset.json has the SHA-256 of every table, and "
        "`vbbench verify` checks them. A mistake that is mended gives a dataset of another id; the changelog of "
        f"vbbench says so.{contact}"
    )


def _sentence(text: str) -> str:
    """The text as a separate sentence."""
    return f"{text[0].upper()}{_full(text[1:])}"


def _full(text: str) -> str:
    """The text with a full stop."""
    return text if text.endswith(".") else f"{text}."
