"""JSON files of the leaderboard: of a published form, sealed by a digest, with blocks of numbers.

A block holds columns of numbers as text that is small. It is a JSON object: ``columns`` (names), ``rows`` (how many),
``encoding`` (how to read it) and ``data``.

Forms of the leaderboard's JSON files: the type and range of every key. `docs/files.md` describes the keys in words.

A key that a form lacks is refused. Metrics are those of `METRICS`, so a new one touches no form.
"""

import base64
import binascii
import hashlib
import json
import zlib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import UNSET, Meta, Struct, UnsetType, defstruct

from vbbench.camera import camera_from_dict
from vbbench.errors import FileError, VbbenchError, quoted
from vbbench.files.dataset_checks import PUBLIC, TABLES
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.json_text import canonical_digest, read_json
from vbbench.protocol import PROTOCOLS
from vbbench.scoring.metrics import METRICS, section

FORMAT_VERSION = 2
"""Of result files and dataset records."""

ENCODING = (
    "base64 of zlib of little-endian float32, column after column, NaN = none; "
    "first the lowest byte of every number, then every second, third and highest byte"
)

COUNTS = ("sequence", "scene", "first_frame", "last_frame", "frames", "positions", "posed", "placed")
"""Whole numbers of each sequence in a result; a record has the first six."""

LARGEST_COUNT = 10**9
"""The largest number of anything."""

SOLVER_NAME, SPLIT_NAME = r"[A-Za-z0-9][A-Za-z0-9._+-]{0,39}", r"[a-z0-9][a-z0-9-]{0,39}"
"""Expressions for names: of solvers and teams, of splits and challenges."""

_PLAIN = r"[^\x00-\x1f\x7f\ud800-\udfff]"
_LINE = rf"^{_PLAIN}*\Z"
_FILLED = rf"^{_PLAIN}*[^\x00-\x20\x7f\ud800-\udfff]{_PLAIN}*\Z"

Line80 = Annotated[str, Meta(max_length=80, pattern=_LINE)]
Line500 = Annotated[str, Meta(max_length=500, pattern=_LINE)]
Statement = Annotated[str, Meta(min_length=1, max_length=500, pattern=_FILLED)]
Note = Annotated[str, Meta(min_length=1, max_length=1000, pattern=_LINE)]
WebAddress = Annotated[str, Meta(max_length=500, pattern=r"^(https?://[^\s<>\"'\ud800-\udfff]+)?\Z")]
Day = Annotated[str, Meta(pattern=r"^[0-9]{4}-(0[1-9]|1[0-2])-(0[1-9]|[12][0-9]|3[01])\Z")]
Sha256 = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]
DatasetId = Annotated[str, Meta(pattern=r"^[0-9a-f]{16}\Z")]
SolverName = Annotated[str, Meta(pattern=rf"^{SOLVER_NAME}\Z")]
SplitName = Annotated[str, Meta(pattern=rf"^{SPLIT_NAME}\Z")]
TierName = Annotated[str, Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,39}\Z")]
ProtocolId = Annotated[str, Meta(pattern=rf"^({'|'.join(PROTOCOLS)})/[1-9][0-9]*\Z")]
Count = Annotated[int, Meta(ge=0, le=LARGEST_COUNT)]
Number = Annotated[int, Meta(ge=1, le=LARGEST_COUNT)]
Average = Annotated[float, Meta(ge=0.0, le=1e9)]
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
Figure = Annotated[float, Meta(ge=0.0, le=1e7)] | None
Angle = Annotated[float, Meta(ge=0.0, le=3.1415927)] | None
PARTS: tuple[Literal["metrics"], Literal["drift"]] = ("metrics", "drift")
CameraKind = Literal["panorama", "perspective"]


class Form(Struct, forbid_unknown_fields=True):
    """An object that has no key but those of its fields."""


class SolverForm(Form):
    """Who made a result, and how: see `About`."""

    name: SolverName
    version: Line80
    reference: Line500
    code: WebAddress
    authors: Statement
    date: Day
    delay: Annotated[int, Meta(ge=0, le=10**6)] | Literal["offline"]
    trained_on: Statement
    tuned_on: Statement
    rerun_by: Line500


class SolvedForm(Form):
    """The dataset of a result; its seed is null where it is withheld."""

    id: DatasetId
    split: SplitName
    tier: TierName
    camera: CameraKind
    seed: int | None


class MadeWithForm(Form):
    """Program and machine of a result."""

    vbbench: Annotated[str, Meta(min_length=1, max_length=80, pattern=_LINE)]
    hardware: Line500


class ScoreForm(Form, kw_only=True):
    """Scores as ``vbbench score --json`` prints them, but for metrics, under the solver's name on the board."""

    dataset: DatasetId
    protocol: Literal[PROTOCOLS]  # type: ignore[valid-type]
    protocol_version: Annotated[int, Meta(ge=1, le=10**6)]
    solver: SolverName
    solver_version: Line80
    split: SplitName
    sequences: Number
    sequences_in_dataset: Number
    frames: Number
    positions: Count
    fallback_frames: Count | None
    coverage: Share
    pose_coverage: Share
    position_coverage: Share
    failure_policy: Literal["refuse", "hold"]
    seconds_per_frame: Annotated[float, Meta(ge=0.0, le=1e6)] | None
    ranked_by: Literal["capped"]
    caution: Note | UnsetType = UNSET
    truth: Literal["poses", "relative"] | UnsetType = UNSET


class ResultBlockForm(Form):
    """Counts and metrics of every scored sequence: columns of numbers as text; see `encode`."""

    columns: list[str]
    rows: Annotated[int, Meta(ge=1, le=10**6)]
    encoding: Literal[ENCODING]  # type: ignore[valid-type]
    data: Annotated[str, Meta(pattern=r"^[A-Za-z0-9+/]+=*\Z")]

    def __post_init__(self) -> None:
        if self.columns != self.wanted():
            raise ValueError(f"Expected the columns {', '.join(self.wanted())}")

    def wanted(self) -> list[str]:
        """The names of the columns."""
        return [*COUNTS, *METRICS]


class RecordBlockForm(ResultBlockForm):
    """Counts of every sequence that a protocol scores."""

    def wanted(self) -> list[str]:
        """The names of the columns."""
        return [*COUNTS[:6]]


class PastForm(Form):
    """Earlier figures of a row: of each metric the capped mean and the ends of its interval."""

    date: Day
    version: Line80
    vbbench: Annotated[str, Meta(min_length=1, max_length=80, pattern=_LINE)]
    dataset: DatasetId
    protocol: ProtocolId
    capped: Annotated[
        dict[Annotated[str, Meta(pattern=r"^[a-z][a-z0-9_]{0,39}\Z")], tuple[Figure, Figure, Figure]],
        Meta(min_length=1, max_length=40),
    ]


class ResultForm(Form, kw_only=True):
    """A result file, but for its score."""

    format_version: Literal[2]
    solver: SolverForm
    dataset: SolvedForm
    protocol: ProtocolId
    made_with: MadeWithForm
    submission: Annotated[
        dict[Annotated[str, Meta(pattern=r"^(poses|positions)\.(parquet|csv)\Z")], Sha256],
        Meta(min_length=2, max_length=2),
    ]
    per_sequence: ResultBlockForm
    history: Annotated[list[PastForm], Meta(min_length=1, max_length=200)] | UnsetType = UNSET
    digest: Sha256

    def __post_init__(self) -> None:
        _check_seed(self.dataset.seed, "$.dataset.seed")


class CountsForm(Form):
    """The row of the paper's Table 1, as ``vbbench info --json`` prints it."""

    split: SplitName
    camera: CameraKind
    tier: TierName
    sequences: Number
    mean_frames: Average
    people_min: Count
    people_mean: Average
    people_max: Count
    observations: Count
    id: DatasetId


def _named(name: str, kind: Any, optional: Iterable[str], required: Iterable[str] = ()) -> Any:
    """The form of an object with keys of one type, whatever letters they have."""
    names = {key.replace("/", "_").replace("-", "_"): key for key in (*required, *optional)}
    fields = [(field, kind) if key in required else (field, kind | UnsetType, UNSET) for field, key in names.items()]
    return defstruct(name, fields, rename=names, kw_only=True, forbid_unknown_fields=True)


def _summary(name: str, figure: Any) -> Any:
    """The form of a metric's summary over sequences, with figures of such a type."""
    single = ("capped", "mean", "std", "frame_mean", "frame_std", "median", "p95")
    figures = [(key, figure) for key in single] + [(key, tuple[figure, figure]) for key in ("capped_ci95", "ci95")]
    others = [("failure_rate", Share | None), ("blocks", Average | None)]
    return defstruct(name, [*figures, *others], bases=(Form,))


SummaryForm, AngleSummaryForm = _summary("SummaryForm", Figure), _summary("AngleSummaryForm", Angle)
TablesForm = _named("TablesForm", Sha256, [name for name in TABLES if name not in PUBLIC], PUBLIC)
"""Every table of the dataset, the truth's among them, and its SHA-256."""
ScoredForm = _named("ScoredForm", RecordBlockForm, PROTOCOLS)
"""The scored sequences by protocol, but for protocols that its truth does not allow or that are younger."""


class RecordForm(Form, kw_only=True):
    """A record of a board's dataset."""

    format_version: Literal[2]
    id: DatasetId
    split: SplitName
    tier: TierName
    title: Annotated[str, Meta(min_length=1, max_length=500, pattern=_LINE)]
    camera: dict[str, Any]
    seed: int | None
    dt: Annotated[float, Meta(gt=0.0, le=1000.0)]
    command: Annotated[str, Meta(max_length=1000, pattern=rf"^vbbench generate {_PLAIN}+\Z")]
    counts: CountsForm
    caution: Note | None
    licence: Line500
    citation: Annotated[str, Meta(max_length=1000, pattern=_LINE)]
    tables: TablesForm  # type: ignore[valid-type]
    scored: ScoredForm  # type: ignore[valid-type]
    digest: Sha256

    def __post_init__(self) -> None:
        _check_seed(self.seed, "$.seed")
        try:
            camera_from_dict(self.camera)
        except VbbenchError as error:
            raise ValueError(f"{error} - at `$.camera`") from error


def form_of(kind: Literal["result", "dataset"]) -> type[Form]:
    """The form of a kind of file; that of results has the metrics that there are."""
    if kind == "dataset":
        return RecordForm
    return _result_form(*(tuple((key, row.unit == "rad") for key, row in section(part).items()) for part in PARTS))


@cache
def _result_form(*parts: tuple[tuple[str, bool], ...]) -> type[Form]:
    """A result file's form with these metrics, (key, whether it is an angle), in `PARTS` of the score."""
    forms = [
        defstruct(
            f"{part.title()}Form",
            [(key, AngleSummaryForm if angle else SummaryForm) for key, angle in metrics],
            bases=(Form,),
            kw_only=True,
        )
        for part, metrics in zip(PARTS, parts, strict=True)
    ]
    score = defstruct("MetricScoreForm", list(zip(PARTS, forms, strict=True)), bases=(ScoreForm,), kw_only=True)
    form: type[Form] = defstruct("ScoredResultForm", [("score", score)], bases=(ResultForm,), kw_only=True)  # type: ignore[assignment]
    return form


def _check_seed(seed: int | None, place: str) -> None:
    """Seeds have up to 256 bits, more than a range of msgspec can have."""
    if seed is not None and seed < 0:
        raise ValueError(f"Expected `int` >= 0 - at `{place}`")


_WIDTH = 4
_LARGEST = 1 << 28
"""Bytes that a block may unfold to: no board is larger, and a small file must not fill the memory."""

_DEEPEST = 3
"""Objects in objects that are laid out by lines."""

Values = dict[str, Any]
Block = dict[str, Any]
Kind = Literal["result", "dataset"]


def read_object(path: Path, kind: Kind) -> Values:
    """The object in a JSON file that has the form of its ``kind`` and the digest of its values.

    Raises FileError if it is missing, damaged, or is of another form; the first fault is named with its place in the
    file.
    """
    try:
        values = read_json(path)
    except FileNotFoundError as error:
        raise FileError(path, "the file is missing") from error
    except (OSError, ValueError) as error:
        raise FileError(path, f"cannot be read ({error}); write it again with 'vbbench leaderboard add'") from error
    if not isinstance(values, dict):
        raise FileError(path, "is not a JSON object; write it again with 'vbbench leaderboard add'")
    _check(values, kind, path)
    try:
        fresh = digest(values)
    except ValueError as error:
        raise FileError(path, f"a block's data {error}; write the file again") from error
    if values["digest"] != fresh:
        raise FileError(path, f"$.digest: is {values['digest']}, the contents give {fresh}; it was changed by hand")
    return values


def sealed_text(values: Values, path: Path, kind: Kind) -> str:
    """The text of the file ``path`` that holds ``values`` and their digest.

    Raises FileError if they are of another form.
    """
    sealed = {**values, "digest": digest(values)}
    _check(json.loads(json.dumps(sealed)), kind, path)
    return _lines(sealed) + "\n"


def digest(values: Values) -> str:
    """SHA-256 of the values as JSON with sorted keys and no spaces; packed blocks count by their numbers."""
    return canonical_digest({name: _unfolded(value) for name, value in values.items() if name != "digest"})


def encode(columns: Mapping[str, Any]) -> Block:
    """The block of columns [N]; numbers are rounded to float32."""
    table = np.array(list(columns.values()), dtype="<f4")
    planes = np.frombuffer(table.tobytes(), np.uint8).reshape(-1, _WIDTH).T
    data = base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    return {"columns": list(columns), "rows": table.shape[1], "encoding": ENCODING, "data": data}


def decode(block: Block) -> dict[str, FloatArray]:
    """Columns by name, as `encode` took them.

    Raises ValueError if the data is damaged, or does not hold as many numbers as it declares.
    """
    table = np.frombuffer(_planes(block), np.uint8).reshape(_WIDTH, -1).T.copy().view("<f4")
    columns = table.reshape(len(block["columns"]), block["rows"]).astype(np.float64)
    return dict(zip(block["columns"], columns, strict=True))


def whole_columns(
    columns: Mapping[str, FloatArray], names: Iterable[str], path: Path, place: str
) -> dict[str, IntArray]:
    """The columns of those names as whole numbers.

    Raises FileError if one holds anything but whole numbers from 0 on; ``place`` is where in the file ``path`` they
    stand.
    """
    for name in names:
        values = columns[name]
        if not ((values >= 0) & (values == np.floor(values)) & (values <= LARGEST_COUNT)).all():
            raise FileError(path, f"{place}: {name} must be whole numbers, from 0 to {LARGEST_COUNT}")
    return {name: columns[name].astype(np.int64) for name in names}


def _planes(block: Block) -> bytes:
    size = len(block["columns"]) * block["rows"] * _WIDTH
    if size > _LARGEST:
        raise ValueError(f"{block['rows']} rows are more than any board has")
    try:
        unfold = zlib.decompressobj()
        planes = unfold.decompress(base64.b64decode(block["data"], validate=True), size + 1)
    except (binascii.Error, zlib.error) as error:
        raise ValueError(f"is damaged ({error})") from error
    if len(planes) != size or not unfold.eof or unfold.unused_data:
        raise ValueError(f"does not hold {len(block['columns'])} columns of {block['rows']} numbers")
    return planes


def _unfolded(value: Any) -> Any:
    """A value with the SHA-256 of its unfolded bytes for each block's data: the same with any version of zlib."""
    if not isinstance(value, dict):
        return value
    if "encoding" in value:
        return {**value, "data": hashlib.sha256(_planes(value)).hexdigest()}
    return {name: _unfolded(part) for name, part in value.items()}


def _lines(value: Any, depth: int = 0) -> str:
    """JSON for people and for diffs: a key per line, and what lies deeper than a summary of a metric in one."""
    if depth == _DEEPEST or not isinstance(value, dict):
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    parts = (f"{' ' * (depth + 1)}{json.dumps(name)}: {_lines(part, depth + 1)}" for name, part in value.items())
    return "\n".join(["{", ",\n".join(parts), f"{' ' * depth}}}"])


def _check(values: Values, kind: Kind, path: Path) -> None:
    """Raise FileError at the first fault; another format version explains all others and comes first."""
    version = values.get("format_version", FORMAT_VERSION)
    if version != FORMAT_VERSION:
        wrong = f"$.format_version: is {quoted(version)}, this vbbench reads {FORMAT_VERSION}; make it again"
        how = "'vbbench leaderboard add' for your solver, 'vbbench leaderboard rerun --update' for those that come with"
        raise FileError(path, f"{wrong}: {how} vbbench")
    try:
        msgspec.convert(values, form_of(kind))
    except UnicodeEncodeError as error:
        raise FileError(path, "a text has half of a surrogate pair; write whole characters") from error
    except msgspec.ValidationError as error:
        raise FileError(path, f"{error}; see docs/files.md") from error
