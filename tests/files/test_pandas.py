"""Tables as data frames, for notebooks; `pandas` is an extra."""

import sys
from pathlib import Path

import numpy as np
import pytest

from tests.lib.answers import submit, true_answers
from vbbench import Dataset, score
from vbbench.cli import main
from vbbench.errors import MissingExtraError, UnknownNameError, VbbenchError


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    folder = tmp_path_factory.mktemp("pandas") / "data"
    assert main(["generate", "demo", "--out", str(folder), "--limit", "3"]) == 0
    return Dataset(folder)


def test_every_table_of_a_dataset_is_a_frame(dataset: Dataset) -> None:
    for name, facts in dataset.info.tables.items():
        assert len(dataset.to_pandas(name)) == facts["rows"]
    frames = dataset.to_pandas("observations").groupby("sequence").frame.max() + 1
    assert frames.tolist() == [sequence.frames for sequence in dataset.sequences()]
    first = dataset.to_pandas("truth/poses").query("sequence == 0")[["x", "y", "yaw"]]
    np.testing.assert_allclose(first, dataset.truth(dataset.sequence(0)).poses)


def test_a_score_is_a_frame_with_a_row_for_each_sequence(dataset: Dataset, tmp_path: Path) -> None:
    result = score(submit(tmp_path / "answer", dataset.folder, true_answers(dataset.folder, 0.1)), dataset.folder)
    table = result.to_pandas()
    assert table.index.tolist() == list(result.per_sequence.sequence)
    for name, figures in result.per_sequence.figures.items():
        if name in table:
            np.testing.assert_array_equal(table[name], figures)
    assert table["dx"].mean() == pytest.approx(result.summaries["dx"].mean)


def test_what_cannot_be_is_one_line(dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'truth/poses'"):
        dataset.to_pandas("truth/pose")
    kept = tmp_path / "kept"
    assert main(["generate", "demo", "--out", str(kept), "--limit", "2", "--withhold-truth"]) == 0
    with pytest.raises(VbbenchError, match="has no truth"):
        Dataset(kept).to_pandas("truth/poses")
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(MissingExtraError, match=r"Dataset.to_pandas needs pandas: .*pip install 'vbbench\[pandas\]'"):
        dataset.to_pandas("sequences")
