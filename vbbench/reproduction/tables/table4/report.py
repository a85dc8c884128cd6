"""Table 4 as a report: both inputs beside the paper's, their ratio, what the rule of tracks changes, and a picture."""

from collections.abc import Iterator
from itertools import product
from typing import Any

from vbbench.paper import COLUMNS, PROTOCOLS, the_paper
from vbbench.reproduction.report import Report
from vbbench.reproduction.tables.table4.picture import plot_table4
from vbbench.reproduction.tables.table4.study import LEAST_TRACK, SPLIT, Table4
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import Summary
from vbbench.table import Table

NAME = "table4"
CONDITIONS = (
    "Input `cline` is a whole box, with Gaussian jitter on column, top and bottom, of everybody of whom a quarter or "
    "more shows: the paper's centre lines were drawn by hand. Input `tracked` are boxes of a simulated detector, "
    f"linked by a tracker. The paper keeps who is tracked in more than three frames: {LEAST_TRACK} frames or more. "
    "Without that rule, tracks of 3 frames count as well. Under true ids every box belongs to the person behind it, as "
    "if the tracker confused nobody."
)
WAYS = (
    "Figures are means over sequences, in brackets the mean over frames ± standard deviation over frames, as the paper "
    "averages. Of the paper only means are quoted; its text estimates one frame after the other (`sequential`), but "
    "its Table 2 is reached under `one-step` alone."
)
WHY = (
    "What differs: the paper's errors are so large with either input that the tracker adds little to them; with centre "
    "lines that are exact, nearly nothing is left of ours, and any error of boxes is a large multiple of it. The ratio "
    "falls with the jitter of the centre lines, with ids that are right, and with a solver that learns no heights "
    "(`vb-sf-literal`), which is off by more to begin with."
)
LOST = (
    "Under `sequential` the paper's solvers lose their way in 400 frames with either input. Tracks that break help "
    "them: the first two positions of every new track are given. Ratios under this protocol say nothing of boxes."
)
RATIOS = (
    "Errors with boxes of the tracker (the paper's rule) by those with centre lines: means over sequences / over "
    "frames. Last two columns: the same with true ids."
)


def table4_report(found: Table4) -> Report:
    """The rows of both protocols, their ratios, and what the rule of tracks leaves out."""
    study, paper = found.study, _printed()
    return Report(
        name=NAME,
        title=f"Table 4: split {SPLIT}, seed {study.seed}, {found.sequences} sequences",
        facts=(CONDITIONS, WAYS, WHY, LOST),
        tables=[*(_errors(found, protocol) for protocol in PROTOCOLS), _ratios(found), _rule(found)],
        values={
            "sequences": found.sequences,
            "seed": study.seed,
            "paper": {**paper, "ratio": _paper_ratio()},
            "inputs": [{**vars(source), "name": source.name, **vars(own)} for source, own in found.counts.items()],
            "rows": [
                {
                    "protocol": row.protocol,
                    "solver": row.solver,
                    "input": row.input.name,
                    "figures": {metric: summary.to_dict() for metric, summary in row.summaries.items()},
                }
                for row in found.rows
            ],
            "ratios": list(_ratio_values(found)),
        },
        pictures={"": plot_table4(found, paper)},
    )


def _printed() -> dict[str, dict[str, float]]:
    """The paper's rows: input → metric → mean."""
    rows = {name: the_paper().select(SPLIT, tier) for name, tier in {"cline": "ideal", "tracked": "tracked"}.items()}
    return {name: {metric: row.figures[metric] for metric in COLUMNS} for name, (row,) in rows.items()}


def _paper_ratio() -> dict[str, float]:
    lines, tracks = _printed().values()
    return {metric: tracks[metric] / lines[metric] for metric in COLUMNS}


def _errors(found: Table4, protocol: str) -> Table:
    head = ["solver", "input", *(METRICS[metric].label for metric in COLUMNS)]
    rows = [["the paper", name, *(f"{value:.3f}" for value in own.values())] for name, own in _printed().items()]
    rows += [
        [f"`{row.solver}`", row.input.label, *(_cell(row.summaries[metric]) for metric in COLUMNS)]
        for row in found.rows
        if row.protocol == protocol
    ]
    return Table(title=f"Errors, {protocol}", head=head, rows=rows, names=2)


def _cell(own: Summary) -> str:
    places = 4 if own.mean < 0.1 else 3 if own.mean < 1.0 else 2
    return f"{own.mean:.{places}f} ({own.frame_mean:.{places}f} ± {own.frame_std:.{places}f})"


def _ratios(found: Table4) -> Table:
    plain = [METRICS[metric].label.partition(" ")[0] for metric in COLUMNS]
    rows = [["the paper", "", "by hand", *(f"{value:.2f}" for value in _paper_ratio().values()), "", ""]]
    for ratio in _ratio_values(found):
        jitter = f"{ratio['jitter']:g} px" if ratio["jitter"] else "exact"
        cells = [_pair(ratio["tracked"][metric]) for metric in COLUMNS]
        cells += [_pair(ratio["linked"][metric]) for metric in COLUMNS[:2]]
        rows.append([f"`{ratio['solver']}`", ratio["protocol"], jitter, *cells])
    return Table(
        title="The ratio of the two rows",
        facts=(RATIOS,),
        head=["solver", "protocol", "cline", *plain, *(f"{label}, true ids" for label in plain[:2])],
        rows=rows,
        names=3,
    )


def _pair(own: dict[str, float]) -> str:
    return " / ".join(f"{value:.2f}" if value < 10.0 else f"{value:.0f}" for value in own.values())


def _ratio_values(found: Table4) -> Iterator[dict[str, Any]]:
    """Of every protocol, solver and jitter: with the tracker's ids and with true ones, metric by metric."""
    paper, _, linked = found.study.tracks
    for protocol, solver, line in product(PROTOCOLS, dict.fromkeys(found.study.solvers), found.study.lines):
        row = found.times(protocol, solver, paper, line), found.times(protocol, solver, linked, line)
        facts = {"protocol": protocol, "solver": solver, "jitter": line.jitter}
        yield {**facts, "tracked": row[0], "linked": row[1]}


def _rule(found: Table4) -> Table:
    """What tracks there are with the paper's rule and without, and what that changes."""
    with_rule, without, _ = found.study.tracks
    head = ["", f"{LEAST_TRACK} frames or more", "3 frames or more", "change"]
    rows = []
    for name in ("boxes", "tracks", "people", "switches", "nobody"):
        kept, all_ = (vars(found.counts[source])[name] for source in (with_rule, without))
        rows.append([_COUNTED[name], f"{kept:,}", f"{all_:,}", _change(kept, all_)])
    for protocol, solver in product(PROTOCOLS, dict.fromkeys(found.study.solvers)):
        kept, all_ = (found.figures(protocol, solver, source)["dx"].mean for source in (with_rule, without))
        name = f"{METRICS['dx'].label}, {protocol}, `{solver}`"
        rows.append([name, f"{kept:.4f}", f"{all_:.4f}", _change(kept, all_)])
    return Table(title="The paper's rule of tracks", head=head, rows=rows)


_COUNTED = {
    "boxes": "boxes",
    "tracks": "tracks",
    "people": "people, summed over sequences",
    "switches": "tracks that go over to somebody else, times",
    "nobody": "boxes of nobody",
}


def _change(kept: float, before: float) -> str:
    return f"{kept / before - 1.0:+.1%}" if before else ""
