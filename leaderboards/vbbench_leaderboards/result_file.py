"""Result files: one JSON a result, ``SPLIT/PROTOCOL-TIER/SOLVER.json`` below the folder of results."""

from pathlib import Path

import numpy as np

from vbbench.errors import FileError
from vbbench.estimate import LARGEST
from vbbench.protocol import get_protocol
from vbbench.scoring.scorecard import DRIFTS, METRICS, PerSequence
from vbbench_leaderboards.block import Block, decode, encode, whole_columns
from vbbench_leaderboards.json_file import Values, object_text, read_object, write_object
from vbbench_leaderboards.result import FORMAT_VERSION, Board, Result

SCHEMA = "result"
COUNTS = ("sequence", "frames", "positions", "posed", "placed")
FIGURES = (*METRICS, *DRIFTS)
LARGEST_FIGURE = 10 * LARGEST
"""No error is larger: answers and truth lie within ± `LARGEST` on each axis, and drift is over 2/3 s or more."""


def read_result(path: Path) -> Result:
    """Read a result file.

    Raises
    ------
    FileError
        If it does not keep to the schema, was changed by hand, or was scored under another version of its protocol.
    """
    values = read_object(path, SCHEMA)
    protocol = values["protocol"].partition("/")[0]
    known = get_protocol(protocol).id
    if values["protocol"] != known:
        raise FileError(
            path, f"$.protocol: is {values['protocol']}, this vbbench scores {known}; solve and add it anew"
        )
    return _result(values, protocol, _per_sequence(values["per_sequence"], path))


def write_result(result: Result, results: Path) -> Path:
    """Write the file of a result below the folder ``results``, whole or not at all, and return its path.

    Raises
    ------
    FileError
        If the result does not keep to the schema.
    """
    return write_object(_values(result), results / result.path, SCHEMA)


def result_text(result: Result, results: Path) -> str:
    """The text that `write_result` writes; raises what that does."""
    return object_text(_values(result), results / result.path, SCHEMA)


def _values(result: Result) -> Values:
    own, board = result.per_sequence, result.board
    columns = {**{name: getattr(own, name) for name in COUNTS}, **{name: own.figures[name] for name in FIGURES}}
    return {
        "format_version": FORMAT_VERSION,
        "solver": {
            "name": result.solver,
            "version": result.version,
            "reference": result.reference,
            "link": result.link,
        },
        "dataset": {
            "id": result.dataset,
            "split": board.split,
            "tier": board.tier,
            "camera": result.camera,
            "seed": result.seed,
        },
        "protocol": result.protocol_id,
        "made_with": {"vbbench": result.package_version, "hardware": result.hardware},
        "submission": result.submission,
        "score": result.score,
        "per_sequence": encode(columns),
    }


def _result(values: Values, protocol: str, per_sequence: PerSequence) -> Result:
    solver, dataset = values["solver"], values["dataset"]
    return Result(
        board=Board(split=dataset["split"], tier=dataset["tier"], protocol=protocol),
        solver=solver["name"],
        version=solver["version"],
        reference=solver["reference"],
        link=solver["link"],
        dataset=dataset["id"],
        camera=dataset["camera"],
        seed=dataset["seed"],
        package_version=values["made_with"]["vbbench"],
        hardware=values["made_with"]["hardware"],
        submission=values["submission"],
        score=values["score"],
        per_sequence=per_sequence,
    )


def _per_sequence(block: Block, path: Path) -> PerSequence:
    columns = decode(block)
    figures = {name: columns[name] for name in FIGURES}
    if not all(((values >= 0) & (values <= LARGEST_FIGURE) | np.isnan(values)).all() for values in figures.values()):
        raise FileError(path, f"$.per_sequence: a figure is below 0 or above {LARGEST_FIGURE:.0f}, where none can be")
    return PerSequence(**whole_columns(columns, COUNTS, path, "$.per_sequence"), figures=figures)
