"""The picture of a whole map: what is on it, at which scale, and what it leaves out."""

from typing import Any

import numpy as np
import pytest
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

from vbbench.estimate import Estimate
from vbbench.geometry import BoolArray
from vbbench.pictures.plotting.style import save_picture
from vbbench.pictures.plotting.whole_map import plot_map

FRAMES, PEOPLE, DT = 200, 5, 0.1


def estimate(way: tuple[float, float] = (20.0, 4.0), **changes: Any) -> Estimate:
    """A camera that goes ``way`` m, and people who walk beside it."""
    share = np.linspace(0.0, 1.0, FRAMES)[:, None]
    poses = np.column_stack([share * way, np.full(FRAMES, np.arctan2(way[1], way[0]))])
    beside = np.stack([np.linspace(-4.0, 4.0, PEOPLE), np.linspace(3.0, -3.0, PEOPLE)], axis=-1)
    values: dict[str, Any] = {
        "poses": poses,
        "positions": poses[:, None, :2] + beside,
        "pose_covariances": np.tile(np.diag([0.25, 0.04, 0.01]), (FRAMES, 1, 1)),
        "position_covariances": np.tile(np.diag([0.09, 0.01]), (FRAMES, PEOPLE, 1, 1)),
    }
    return Estimate(**values | changes)


def drawn(answer: Estimate, lost: BoolArray | None = None, observed: BoolArray | None = None) -> Figure:
    seen = np.ones((FRAMES, PEOPLE), bool) if observed is None else observed
    return plot_map(answer, seen, DT, "walk", ["a fact"], np.zeros(FRAMES, bool) if lost is None else lost)


def parts(figure: Figure) -> dict[str, Any]:
    (axes,) = figure.axes
    return {gid: artist for artist in axes.get_children() if (gid := artist.get_gid())}


def words(figure: Figure) -> list[str]:
    (legend,) = figure.legends
    return [text.get_text() for text in legend.get_texts()]


@pytest.mark.parametrize("way", [(20.0, 4.0), (3.0, 60.0), (200.0, 0.0), (0.0, 0.0)])
def test_all_of_the_path_is_on_the_map_at_equal_scales(way: tuple[float, float]) -> None:
    answer = estimate(way)
    figure = drawn(answer)
    (axes,) = figure.axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    for x, y in answer.poses[:, :2]:
        assert left < x < right
        assert low < y < high
    box = axes.get_window_extent()
    assert box.width / (right - left) == pytest.approx(box.height / (high - low), rel=1e-6)
    assert max(figure.get_size_inches()) < 13.0


def test_the_scale_bar_is_as_long_as_it_says_and_times_stand_next_to_the_path() -> None:
    figure = drawn(estimate())
    bar = parts(figure)["scale-bar"].get_xdata()
    texts = {text.get_text() for text in figure.axes[0].texts}
    assert {f"{bar[1] - bar[0]:g} m (grid)", "0 s", "10 s", "18 s"} <= texts


def test_ellipses_are_of_two_standard_deviations() -> None:
    found = parts(drawn(estimate()))
    for gid, lengths in (("camera-ellipses", (2.0, 0.8)), ("people-ellipses", (1.2, 0.4))):
        ellipses = found[gid]
        assert isinstance(ellipses, EllipseCollection)
        np.testing.assert_allclose(ellipses.get_widths()[0], lengths[0])
        np.testing.assert_allclose(ellipses.get_heights()[0], lengths[1])
        assert ellipses.get_angles()[0] % 180.0 == pytest.approx(0.0)
    np.testing.assert_allclose(found["people-ellipses"].get_offsets(), estimate().positions[-1])
    wide = np.tile(np.diag([1e4, 0.01]), (FRAMES, PEOPLE, 1, 1))  # would cover the map
    assert len(parts(drawn(estimate(position_covariances=wide)))["people-ellipses"].get_offsets()) == 0


def test_paths_are_whole_and_dotted_where_they_are_not_usable() -> None:
    answer, lost = estimate(), np.zeros(FRAMES, bool)
    lost[50:80] = lost[150:] = True
    figure = drawn(answer, lost)
    found = parts(figure)
    assert isinstance(found["lost-path"], LineCollection)
    assert [len(path.vertices) for path in found["lost-path"].get_paths()] == [31, 51]
    assert [len(path.vertices) for path in found["path"].get_paths()] == [50, 71]
    assert "not usable" in words(figure)
    assert "not usable" not in words(drawn(answer))


def test_who_is_seen_for_a_time_has_a_path_of_that_time() -> None:
    seen = np.zeros((FRAMES, PEOPLE), bool)
    seen[10:60, 1] = seen[5:6, 2] = True
    answer = estimate()
    found = parts(drawn(answer, observed=seen))
    assert [len(path.vertices) for path in found["people"].get_paths()] == [50, 1]
    np.testing.assert_allclose(found["places"].get_offsets(), answer.positions[[59, 5], [1, 2]])
    seen[70:90, 1] = seen[120:140, 1] = True  # after one second, and after three
    found = parts(drawn(answer, observed=seen))
    assert [len(path.vertices) for path in found["people"].get_paths()] == [70, 20, 1]


def test_a_map_without_people_and_without_covariances_is_drawn(tmp_path: Any) -> None:
    figure = drawn(
        estimate(pose_covariances=None, position_covariances=None), observed=np.zeros((FRAMES, PEOPLE), bool)
    )
    assert set(parts(figure)) >= {"path", "start", "end", "scale-bar"}
    assert not any("σ" in word for word in words(figure))
    save_picture(figure, tmp_path / "map.png")
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"
