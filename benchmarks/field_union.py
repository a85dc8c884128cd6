"""Constants of tier `field` fitted on the union of real families, and tested on each family that is left out.

``python -m benchmarks.field_union`` measures boxes against truth, in each family and in the tier with today's
constants, scales the constants by the ratio, and ranks the variants of `benchmarks.family_ranks`, whose folder it
shares. ``--page docs/transfer.md`` writes the tables; ``--smoke`` needs no recordings.

Residuals are shares of a box's height: the column less the run's median; the foot row less the run's tilt and mount
height and each frame's median; the logarithm of the height less the run's near edge. σ is 1.4826 times the median of
their size. T fits p + (1 − p) exp(−τ/T) to their correlation. A miss lies between a track's first and last box.
"""

import argparse
import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from scipy.optimize import least_squares

from benchmarks.families.places import Places
from benchmarks.family_ranks import FAMILIES, SPLIT, STRIDE, Real, Solved, apart
from vbbench.files.dataset import Dataset
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, runs_of_true, shorter_way
from vbbench.registry import load
from vbbench.reproduction.agreement import LEVEL, SEED, Errors, spearman
from vbbench.reproduction.grid import Making
from vbbench.reproduction.transfer import people_as_text
from vbbench.sequence import Sequence
from vbbench_generators.tiers.field import FieldRecipe, get_field

DRAWN, FOUND = SETTINGS = ("drawn, vehicle", "found, vehicle")
"""The settings of `benchmarks.family_ranks` that are fitted, each on the families with such boxes."""
CUES, EDGES = ("column", "foot", "height"), (0.1, 0.9)
NAMES = (*CUES, *(f"{cue}_time" for cue in CUES), "nearest", "farthest", "missed", "gap")
"""What is measured: shares of the height; s; the quantiles `EDGES` of runs' near edges in m; a share of boxes; s."""
BORDER, REACH, VISIBLE, FEWEST = 2.0, (3.0, 40.0), 0.5, 20
"""Boxes that count are so many px inside the picture, so many m away and so visible; a run has so many."""
LONGEST_LAG, PAIRS = 3.0, 100
"""Of correlations, in s; pairs of residuals that each needs."""
FACTORS, FINE, DRAWS = (0.25, 4.0), 0.1, 1000
"""Least and greatest change of a constant; seconds a frame where the tier is measured; draws of intervals."""
SEEDS, RANKS = (1, 2), ("today's, fitted; seeds 1, 2", "change")
RECIPE = "vbbench_generators.tiers.field.tier.get_field"

Make = Callable[[Places], Dataset]
Sources = dict[str, tuple[str, Make]]
Constants = dict[str, float]


def _films(every: int, limit: int | None = None) -> Make:
    options = Options(limit=limit, footage=FootageOptions(every=every))
    return lambda places: Making().dataset("street-film", places.cache / "dataset", options)


SOURCES: Sources = {
    "kitti, labels": (DRAWN, lambda places: places.kitti(1, found=False)),
    "argoverse2": (DRAWN, lambda places: places.own("argoverse2", places.folder("argoverse2/own"), 1)),
    "nuscenes": (DRAWN, lambda places: places.own("nuscenes", places.folder("nuscenes/own"), 5)),
    "kitti, detector": (FOUND, lambda places: places.kitti(1, found=True)),
    "street-film": (FOUND, _films(1)),
}
"""Families with absolute truth, of the recordings before the comma: the setting that they fit, and their dataset."""
SMOKE: Sources = {"sim": (FOUND, lambda places: places.board("sim", "field")), "films": (FOUND, _films(1, 4))}
SMOKE_FAMILIES, SMOKE_RANKED = {"films": Real(_films(4, 4))}, ("cv", "ground-plane", "map-causal")


def residuals(dataset: Dataset, sequence: Sequence) -> tuple[FloatArray, float] | None:
    """[3, T, K] residuals of the `CUES`, NaN without a whole box, and the near edge in m; ``None`` of few boxes."""
    camera, relative = dataset.camera(sequence), dataset.relative_truth(sequence)
    heights = np.broadcast_to(dataset.truth(sequence).heights, relative.shape[:-1])
    (u, v, length), (width, rows) = np.moveaxis(sequence.observations, -1, 0), camera.picture_size
    reach, bottom = np.hypot(relative[..., 0], relative[..., 1]), v + 0.5 * length
    with np.errstate(invalid="ignore", divide="ignore"):
        exact = camera.project_unbounded(relative, heights)
        edges = reach * (1.0 - exact[..., 2] / length)
        whole = np.isfinite(edges) & (reach > REACH[0]) & (reach < REACH[1]) & (sequence.visible >= VISIBLE)
        if camera.period is None:
            sides = np.stack([u, width - u]) - 0.2 * length
            whole &= (np.stack([*sides, bottom - length, rows - 1 - bottom]) > BORDER).all(axis=0)
        if np.count_nonzero(whole) < FEWEST:
            return None
        edge = float(np.median(edges[whole]))
        near = camera.project_unbounded(relative * (1.0 - edge / reach)[..., None], heights)
        column = np.where(whole, shorter_way(u - exact[..., 0], camera.period), np.nan)
        foot = np.where(whole, bottom - near[..., 1] - 0.5 * near[..., 2], np.nan)
        height = np.where(whole, np.log(length / near[..., 2]), np.nan)
    terms = np.stack([np.ones(whole.sum()), (u - 0.5 * width)[whole], length[whole]], axis=-1)
    model, size = terms / length[whole, None], (foot / length)[whole]
    plane = least_squares(lambda x: model @ x - size, np.zeros(3), loss="soft_l1", f_scale=0.03, x_scale="jac")  # type: ignore[misc]
    foot[whole] -= terms @ plane.x
    for t, row in enumerate(whole):
        people = np.count_nonzero(row)
        foot[t] = (foot[t] - np.median(foot[t, row])) * (people / (people - 1)) ** 0.5 if people > 2 else np.nan
    return np.stack([(column - np.nanmedian(column)) / length, foot / length, height]), edge


def deviation(values: FloatArray) -> float:
    """Robust standard deviation about 0, of what is not NaN."""
    return float(1.4826 * np.nanmedian(np.abs(values)))


def memory(runs: list[FloatArray], dt: float, std: float) -> float:
    """Correlation time in s of residuals [T, K], cut off at 3 ``std``."""
    runs = [np.clip(run, -3.0 * std, 3.0 * std) for run in runs]
    variance = np.nanmean(np.concatenate([run.ravel() ** 2 for run in runs]))
    found = []
    for lag in range(1, int(LONGEST_LAG / dt) + 1):
        products = np.concatenate([(run[lag:] * run[:-lag]).ravel() for run in runs])
        products = products[~np.isnan(products)]
        if len(products) >= PAIRS:
            found.append((lag * dt, products.mean() / variance, len(products)))
    lags, correlations, counts = np.array(found).T
    times, constant = np.geomspace(0.03, LONGEST_LAG, 60), np.linspace(0.0, 0.95, 20)[:, None, None]
    model = constant + (1.0 - constant) * np.exp(-lags / times[:, None])
    return float(times[((model - correlations) ** 2 @ counts).min(axis=0).argmin()])


def measure(dataset: Dataset) -> Constants:
    """What is measured of a dataset."""
    found = [one for one in (residuals(dataset, sequence) for sequence in dataset.sequences()) if one is not None]
    lost = gaps = boxes = 0
    for sequence in dataset.sequences():
        for inside in map(np.trim_zeros, sequence.observed.T):
            lost, boxes, gaps = lost + int(np.sum(~inside)), boxes + len(inside), gaps + len(runs_of_true(~inside))
    cues = [[rows[cue] for rows, _ in found] for cue in range(len(CUES))]
    spreads = [deviation(np.concatenate([run.ravel() for run in runs])) for runs in cues]
    times = [memory(runs, dataset.info.dt, std) for runs, std in zip(cues, spreads, strict=True)]
    edges, gap = np.quantile([edge for _, edge in found], EDGES), dataset.info.dt * lost / max(gaps, 1)
    return dict(zip(NAMES, [*spreads, *times, *edges, lost / boxes, gap], strict=True))


def pooled(rows: Iterable[Constants]) -> Constants:
    """Medians over families."""
    return dict(zip(NAMES, np.median([list(row.values()) for row in rows], axis=0).tolist(), strict=True))


def fitted(setting: str, wanted: Constants, own: Constants) -> FieldRecipe:
    """Today's recipe, scaled by the ``wanted`` figures over its ``own``; the near edge as wanted."""
    recipe = get_field()
    ratio = {name: float(np.clip(wanted[name] / max(own[name], 1e-9), *FACTORS)) for name in NAMES}
    beyond = EDGES[0] / (EDGES[1] - EDGES[0]) * (wanted["farthest"] - wanted["nearest"])
    edge = {"nearest_edge": max(wanted["nearest"] - beyond, 0.0), "farthest_edge": wanted["farthest"] + beyond}
    ground = replace(recipe.ground, std=recipe.ground.std * ratio["foot"])
    recipe = replace(recipe, body=replace(recipe.body, **edge), ground=ground)
    if setting == DRAWN:
        model, by = recipe.annotator, {"top_std": "height", "column_time": "column_time", "bottom_time": "foot_time"}
        by |= {"column_std": "column", "column_person_std": "column", "bottom_std": "foot", "bottom_person_std": "foot"}
        return replace(recipe, annotator=replace(model, **{n: getattr(model, n) * ratio[cue] for n, cue in by.items()}))
    noise, by = recipe.detector, {"side_std": "column", "bottom_std": "foot", "top_std": "height"}
    by |= {"jitter_memory": "column_time", "score_memory": "gap"}
    odds = [np.log(share / (1.0 - share)) for share in np.clip([wanted["missed"], own["missed"]], 1e-3, 0.9)]
    changed = {"score_best": float(noise.score_best + odds[1] - odds[0])}
    changed |= {name: getattr(noise, name) * ratio[cue] for name, cue in by.items()}
    return replace(recipe, detector=replace(noise, **changed))


def made(places: Places, name: str, setting: str, recipe: FieldRecipe, *, seed: int = 0, fine: bool = False) -> Dataset:
    """A dataset of the tier with a ``recipe``, as `benchmarks.family_ranks` has it, or a ``fine`` one to measure."""
    folder = apart(places, f"{name} {setting}").cache / "dataset"
    options = Options(tier="field", observer="vehicle", detector=setting == FOUND, seed=seed)
    with patch(RECIPE, lambda: recipe):
        if places.smoke:
            return Making().dataset("sim", folder, replace(options, limit=2))
        options = replace(options, source=places.data, stride=STRIDE)
        if not fine:
            return Making().dataset(SPLIT, folder, options)
        people, plan = places.cache / "people.txt", load("generator", SPLIT).plan(Options(source=places.data))
        people.write_text(people_as_text(plan.scenes[0], FINE), encoding="utf-8")
        return Making().dataset("custom", folder, replace(options, source=people, dt=FINE))


def change(tiers: list[Errors], real: Errors, number: int) -> FloatArray:
    """Spearman's ρ of the tiers with family ``number``, and draws of the second's less the first's by blocks."""
    old, new = (one.resampled(2 * DRAWS, SEED)[:DRAWS] for one in tiers[:2])
    theirs = real.resampled(2 * DRAWS, SEED + 1 + number)[:DRAWS]
    means = [spearman(one.means[None], real.means[None])[0] for one in tiers]
    return np.array([*means, *(spearman(new, theirs) - spearman(old, theirs))])


def study(places: Places) -> tuple[dict[str, Constants], dict[str, list[FloatArray]]]:
    """What is measured of families and the tier, and the changes of each family by setting."""
    sources, families, solved = SOURCES, FAMILIES, Solved()
    if places.smoke:
        sources, families = SMOKE, SMOKE_FAMILIES
        solved.variants = {name: solved.variants[name] for name in SMOKE_RANKED}
    known = {name: measure(make(apart(places, f"measured {name}"))) for name, (_, make) in sources.items()}
    own = {setting: measure(made(places, "measured", setting, get_field(), fine=True)) for setting in SETTINGS}

    def recipe(setting: str, out: str) -> FieldRecipe:
        rows = [row for name, row in known.items() if sources[name][0] == setting and name.split(",")[0] != out]
        return fitted(setting, pooled(rows or [own[setting]]), own[setting])

    changes: dict[str, list[FloatArray]] = {}
    for number, (family, real) in enumerate(families.items()):
        theirs, out = solved.errors(real.make(apart(places, family)), real.protocol, real.metric), family.split(",")[0]
        for setting in SETTINGS:
            asked = [("field", get_field(), 0), (f"without {out}", recipe(setting, out), 0)]
            asked += [(f"field {seed}", get_field(), seed) for seed in SEEDS]
            tiers = [made(places, name, setting, one, seed=seed) for name, one, seed in asked]
            errors = [solved.errors(tier, real.protocol, real.metric) for tier in tiers]
            changes.setdefault(family, []).append(change(errors, theirs, number))
    changes["mean"] = list(np.mean(list(changes.values()), axis=0))
    return known | {f"tier, {setting}": row for setting, row in own.items()}, changes


def tables(measured: Mapping[str, Constants], changes: Mapping[str, list[FloatArray]]) -> list[list[str]]:
    """Both as lines of Markdown."""
    rows = {"measured on boxes": [*(f"{cue}: σ, T" for cue in CUES), "near edge", "missed, for"]}
    for name, row in measured.items():
        cues = [f"{row[cue]:.3f}, {row[f'{cue}_time']:.2f} s" for cue in CUES]
        edge, missed = "{nearest:.2f} to {farthest:.2f} m".format(**row), f"{100.0 * row['missed']:.1f} %"
        rows[name] = [*cues, edge, f"{missed}, {row['gap']:.2f} s" if row["gap"] else missed]
    ranks = {"family left out": [f"{setting}: {what}" for setting in SETTINGS for what in RANKS]}
    for name, found in changes.items():
        ranks[name] = []
        for one in found:
            low, high = np.nanquantile(one[-DRAWS:], LEVEL)
            values = "{:.2f}, {:.2f}; {:.2f}, {:.2f}".format(*one[:-DRAWS])
            ranks[name] += [values, f"{one[1] - one[0]:+.2f} [{low:+.2f} to {high:+.2f}]"]
    lines = [[f"| {' | '.join([name, *cells])} |" for name, cells in both.items()] for both in (rows, ranks)]
    return [
        [head, re.sub(r"[^|]+", " --- ", head), *map(partial(re.sub, r"\b0\.", "."), rest)] for head, *rest in lines
    ]


def main() -> None:
    """Measure, solve, write and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--data", type=Path, default=os.environ.get("VBBENCH_DATA"))
    parser.add_argument("--out", type=Path, default=Path("out/family-ranks"))
    parser.add_argument("--page", type=Path)
    parser.add_argument("--smoke", action="store_true", help="few simulated people, no recordings")
    asked = parser.parse_args()
    found = tables(*study(Places(data=asked.data and Path(asked.data), cache=asked.out, smoke=asked.smoke)))
    for rows in found:
        print("\n".join(rows), end="\n\n")
        if asked.page is not None:
            title, page = re.escape(rows[0].split(" | ")[0]), asked.page.read_text("utf-8")
            own = rf"(?m)^{title} .*\n(?:\|.*\n)+"
            asked.page.write_text(re.sub(own, lambda _, r=rows: "\n".join([*r, ""]), page), encoding="utf-8")  # type: ignore[misc]


if __name__ == "__main__":
    main()
