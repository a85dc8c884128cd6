"""JSON files of the leaderboard: of a published form, sealed by a digest, with blocks of numbers.

A block holds columns of numbers as text that is small. It is a JSON object: ``columns`` (names), ``rows`` (how many),
``encoding`` (how to read it) and ``data``.
"""

import base64
import binascii
import hashlib
import json
import zlib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Literal

import msgspec
import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.json_text import canonical_digest, read_json
from vbbench_leaderboards.results.forms import ENCODING, FORMAT_VERSION, LARGEST_COUNT, form_of

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

    Raises
    ------
    FileError
        If it is missing, damaged, or is of another form; the first fault is named with its place in the file.
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

    Raises
    ------
    FileError
        If they are of another form.
    """
    sealed = {**values, "digest": digest(values)}
    _check(json.loads(json.dumps(sealed)), kind, path)
    return _lines(sealed) + "\n"


def digest(values: Values) -> str:
    """SHA-256 over the canonical text: no digest, keys sorted, no spaces, each block by what it unfolds to."""
    return canonical_digest({name: _unfolded(value) for name, value in values.items() if name != "digest"})


def encode(columns: Mapping[str, Any]) -> Block:
    """The block of columns [N]; numbers are rounded to float32."""
    table = np.array(list(columns.values()), dtype="<f4")
    planes = np.frombuffer(table.tobytes(), np.uint8).reshape(-1, _WIDTH).T
    data = base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    return {"columns": list(columns), "rows": table.shape[1], "encoding": ENCODING, "data": data}


def decode(block: Block) -> dict[str, FloatArray]:
    """Columns by name, as `encode` took them.

    Raises
    ------
    ValueError
        If the data is damaged, or does not hold as many numbers as it declares.
    """
    table = np.frombuffer(_planes(block), np.uint8).reshape(_WIDTH, -1).T.copy().view("<f4")
    columns = table.reshape(len(block["columns"]), block["rows"]).astype(np.float64)
    return dict(zip(block["columns"], columns, strict=True))


def whole_columns(
    columns: Mapping[str, FloatArray], names: Iterable[str], path: Path, place: str
) -> dict[str, IntArray]:
    """The columns of those names as whole numbers.

    Raises
    ------
    FileError
        If one holds anything but whole numbers from 0 on; ``place`` is where in the file ``path`` they stand.
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
        raise FileError(
            path,
            f"$.format_version: is {quoted(version)}, this vbbench reads {FORMAT_VERSION}; make it again: "
            "'vbbench leaderboard add' for your solver, 'vbbench leaderboard rerun --update' for those that "
            "come with vbbench",
        )
    try:
        msgspec.convert(values, form_of(kind))
    except UnicodeEncodeError as error:
        raise FileError(path, "a text has half of a surrogate pair; write whole characters") from error
    except msgspec.ValidationError as error:
        raise FileError(path, f"{error}; see docs/files.md") from error
