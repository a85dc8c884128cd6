"""A row added to the table of metrics, from outside of the packages: everything that tells metrics has it."""

import html
import json
import re
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest
from matplotlib.text import Text

from tests.leaderboards.site.test_pages import site_of
from tests.lib.answers import submit, true_answers
from tests.lib.board_results import BOARD, result
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.pictures.plotting import plot_sequence
from vbbench.scoring import score
from vbbench.scoring.comparison import compare
from vbbench.scoring.metrics import METRICS, Metric, position_error, rotation_error
from vbbench_leaderboards.results.sealed_json import form_of
from vbbench_leaderboards.site.pages import board_page, site_files

NEW = {
    "degrees": Metric(
        symbol="Δr°",
        name="heading in degrees",
        unit="°",
        meaning="Δr in degrees.",
        over="frames",
        function=lambda poses, true_poses: np.degrees(rotation_error(poses, true_poses)),
    ),
    "astray": Metric(
        symbol="astray",
        name="share of people astray",
        unit="%",
        meaning="The share of people who are more than 15 cm from their true places.",
        over="people",
        function=lambda positions, _poses, true, _true_poses: 100.0 * (position_error(positions, true) > 0.15),
    ),
    "seconds": Metric(
        symbol="time",
        name="time between",
        unit="s",
        meaning="The time over which drift is measured.",
        over="seconds",
        function=lambda start, _end, _true_start, _true_end, seconds: np.full(len(start), seconds),
    ),
}
"""One over frames, one over people and one over seconds."""


@pytest.fixture
def new_metrics(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, metric in NEW.items():
        monkeypatch.setitem(METRICS, name, metric)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("metric") / "data"
    write_dataset(folder, Crowd(scenes=8))
    return folder


@pytest.fixture(scope="module")
def answers(data: Path) -> tuple[Path, Path]:
    good, bad = (submit(data.with_name(f"{noise}"), data, true_answers(data, noise)) for noise in (0.1, 0.2))
    return good, bad


@pytest.mark.usefixtures("new_metrics")
def test_score_tells_it_as_json_text_and_per_sequence(data: Path, answers: tuple[Path, Path]) -> None:
    result = score(answers[0], data)
    told = json.loads(result.to_json())
    assert {"degrees", "astray"} < set(told["metrics"])
    assert "seconds" in told["drift"]
    assert told["metrics"]["degrees"]["mean"] == pytest.approx(np.degrees(told["metrics"]["dr"]["mean"]))
    assert 0 < told["metrics"]["astray"]["mean"] < 100
    assert told["drift"]["seconds"]["mean"] == pytest.approx(round(1 / Dataset(data).info.dt) * Dataset(data).info.dt)
    heads = [line[:12].split() for line in result.table().splitlines()]
    assert all([metric.symbol, metric.unit] in heads for metric in NEW.values())
    rows = result.to_csv().splitlines()
    assert rows[0].split(",")[-3:] == list(NEW)
    figures = result.per_sequence.figures
    assert [float(cell) for cell in rows[1].split(",")[-3:]] == [figures[name][0] for name in NEW]


@pytest.mark.usefixtures("new_metrics")
def test_compare_tells_it(data: Path, answers: tuple[Path, Path]) -> None:
    result = compare(*answers, data)
    told = json.loads(result.to_json())
    assert told["metrics"]["astray"]["difference"] < 0
    assert told["metrics"]["astray"]["p_value"] < 0.05
    assert told["drift"]["seconds"]["difference"] == 0
    assert all(any(line.startswith(metric.symbol) for line in result.table().splitlines()) for metric in NEW.values())


@pytest.mark.usefixtures("new_metrics")
def test_pictures_and_reports_tell_it(data: Path, answers: tuple[Path, Path]) -> None:
    dataset = Dataset(data)
    sequence = next(one for one in dataset.sequences() if one.observed[3].any())
    truth = dataset.truth(sequence)
    estimate = Estimate(poses=truth.poses + 0.1, positions=truth.positions)
    words = {text.get_text() for text in plot_sequence(dataset, sequence.index, estimate, frame=3).findobj(Text)}
    assert any("Δr° = 5.730 °" in text and "astray = 0.000 %" in text and "time" not in text for text in words)


@pytest.mark.usefixtures("new_metrics")
def test_boards_rank_by_it_and_show_it() -> None:
    results = [result(solver, np.tile(np.linspace(0.0, far, 10), 20)) for solver, far in (("near", 0.1), ("far", 0.5))]
    site = site_of(*results)
    assert [site.rankings[BOARD]["astray"].places[row.solver].rank for row in results] == [1, 2]
    table = board_page(site, BOARD)
    assert all(f'<th scope="col" class="num" data-column="{name}">' in table for name in ("degrees", "astray"))
    assert '<th scope="col" class="num more" data-column="seconds">' in table
    assert all(table.count(f'data-column="{name}" data-value="') == len(results) for name in NEW)
    ranked = json.loads(html.unescape(re.findall(r'data-ranks="([^"]*)"', table)[0]))
    assert set(ranked) == set(METRICS)
    pages = dict(site_files(site))
    assert all(f'id="def-{name}">{metric.meaning}' in pages["index.html"] for name, metric in NEW.items())


@pytest.mark.usefixtures("new_metrics")
def test_result_files_must_have_it() -> None:
    form = form_of("result")
    score = get_type_hints(form)["score"]
    assert {*NEW, "dx"} - {"seconds"} <= set(get_type_hints(score)["metrics"].__struct_fields__)
    assert "seconds" in get_type_hints(score)["drift"].__struct_fields__
