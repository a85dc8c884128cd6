"""How the viewer lays a recording out: world and ego view on the left, map, errors and words on the right."""

from typing import Any

import numpy as np

from vbbench.pictures.viewer.ego import ego_root
from vbbench.pictures.viewer.estimates import ERRORS
from vbbench.pictures.viewer.ground import MAP, WORLD
from vbbench.pictures.viewer.take import Take
from vbbench.pictures.viewer.words import FACTS, NOW
from vbbench.scoring.metrics import METRICS

_MARGIN = 1.5  # m around everything
_PICTURES = {"picture": "What the observer sees", "depth": "Depth", "ids": "Ids"}


def layout(take: Take, *, pictures: bool) -> Any:
    """The blueprint of a recording; ``pictures`` says whether there are rendered ones."""
    import rerun.blueprint as rrb

    root = ego_root(take)
    hidden = [f"- /{root}/{name}" for name in ("depth", "ids")]
    world = rrb.Spatial3DView(origin=f"/{WORLD}", contents=["$origin/**", *hidden], name="World", **_eye(rrb, take))
    views = [_ego_view(rrb, take, name) for name in (_PICTURES if pictures else ["picture"])]
    ego = rrb.Tabs(*views, active_tab=0) if len(views) > 1 else views[0]
    wide = take.dataset.info.camera.picture_size[0] > 2.5 * take.dataset.info.camera.picture_size[1]
    left = rrb.Vertical(world, ego, row_shares=[3, 1] if wide else [1, 1])
    words = rrb.Horizontal(
        rrb.TextDocumentView(origin=f"/{NOW}", name="Frame"), rrb.TextDocumentView(origin=f"/{FACTS}", name="Facts")
    )
    right = [_map_view(rrb, take), *_plots(rrb, take), words]
    shares = [6, 4, 3] if len(right) == 3 else [2, 1]
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*right, row_shares=shares), column_shares=[3, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed"),
    )


def _ego_view(rrb: Any, take: Take, shown: str) -> Any:
    root = ego_root(take)
    hidden = [f"- $origin/{name}" for name in _PICTURES if name != shown]
    width, height = take.dataset.info.camera.picture_size
    bounds = rrb.VisualBounds2D(x_range=(-0.01 * width, 1.01 * width), y_range=(-0.01 * height, 1.01 * height))
    contents = ["$origin/**", *hidden]
    return rrb.Spatial2DView(origin=f"/{root}", contents=contents, visual_bounds=bounds, name=_PICTURES[shown])


def _plots(rrb: Any, take: Take) -> list[Any]:
    """Errors over time, where there are any: all metrics side by side, all submissions in each."""
    views: list[Any] = []
    for number, key in enumerate(next((answer.errors for answer in take.estimates if answer.errors), {})):
        top = max(float(np.nanmax(answer.errors[key], initial=0.0)) for answer in take.estimates)
        axis, legend = rrb.ScalarAxis(range=(0.0, 1.05 * top or 1.0)), rrb.PlotLegend(visible=number == 0)
        options = {"origin": f"/{ERRORS}/{key}", "name": METRICS[key].label}
        views.append(rrb.TimeSeriesView(**options, axis_y=axis, plot_legend=legend))
    return [rrb.Grid(*views, grid_columns=2)] if views else []


def _map_view(rrb: Any, take: Take) -> Any:
    """The map with everything in sight; rows of the plane are −y."""
    (left, bottom), (right, top) = take.extent[0] - _MARGIN, take.extent[1] + _MARGIN
    bounds = rrb.VisualBounds2D(x_range=(left, right), y_range=(-top, -bottom))
    return rrb.Spatial2DView(origin=f"/{MAP}", visual_bounds=bounds, name="Map")


def _eye(rrb: Any, take: Take) -> dict[str, Any]:
    """Look at the middle of the scene from behind the observer's start, where this rerun lets us choose."""
    if not hasattr(rrb, "EyeControls3D"):
        return {}
    low, high = take.extent
    middle, reach = 0.5 * (low + high), 0.5 * float(np.hypot(*(high - low))) + _MARGIN
    poses = (take.truth or take.sequence.given).poses
    yaw = float(np.nan_to_num(poses[0, 2]))
    back = middle - 1.2 * reach * np.array([np.cos(yaw), np.sin(yaw)])
    eye = rrb.EyeControls3D(position=(*back, 0.9 * reach), look_target=(*middle, 0.0), eye_up=(0.0, 0.0, 1.0))
    return {"eye_controls": eye}
