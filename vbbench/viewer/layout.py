"""How the viewer lays a recording out: world and ego view on the left, map, errors and words on the right."""

from typing import Any

from vbbench.frame_errors import LABELS, UNITS
from vbbench.renderer import picture_size
from vbbench.viewer.ego import ego_root
from vbbench.viewer.estimates import ERRORS
from vbbench.viewer.ground import MAP, WORLD
from vbbench.viewer.take import Take
from vbbench.viewer.words import FACTS, NOW

_PICTURES = {"picture": "What the observer sees", "depth": "Depth", "ids": "Ids"}


def layout(take: Take, *, pictures: bool) -> Any:
    """The blueprint of a recording; ``pictures`` says whether there are rendered ones."""
    import rerun.blueprint as rrb

    root = ego_root(take)
    hidden = [f"- /{root}/{name}" for name in ("depth", "ids")]
    world = rrb.Spatial3DView(origin=f"/{WORLD}", contents=["$origin/**", *hidden], name="World")
    views = [_ego_view(rrb, take, name) for name in (_PICTURES if pictures else ["picture"])]
    ego = rrb.Tabs(*views, active_tab=0) if len(views) > 1 else views[0]
    wide = picture_size(take.dataset.info.camera)[0] > 2.5 * picture_size(take.dataset.info.camera)[1]
    left = rrb.Vertical(world, ego, row_shares=[3, 1] if wide else [1, 1])
    words = rrb.Horizontal(
        rrb.TextDocumentView(origin=f"/{NOW}", name="Frame"), rrb.TextDocumentView(origin=f"/{FACTS}", name="Facts")
    )
    right = [rrb.Spatial2DView(origin=f"/{MAP}", name="Map"), *_plots(rrb, take), words]
    shares = [3, 2, 1] if len(right) == 3 else [3, 1]
    return rrb.Blueprint(
        rrb.Horizontal(left, rrb.Vertical(*right, row_shares=shares), column_shares=[3, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed"),
    )


def _ego_view(rrb: Any, take: Take, shown: str) -> Any:
    root = ego_root(take)
    hidden = [f"- $origin/{name}" for name in _PICTURES if name != shown]
    width, height = picture_size(take.dataset.info.camera)
    bounds = rrb.VisualBounds2D(x_range=(-0.01 * width, 1.01 * width), y_range=(-0.01 * height, 1.01 * height))
    contents = ["$origin/**", *hidden]
    return rrb.Spatial2DView(origin=f"/{root}", contents=contents, visual_bounds=bounds, name=_PICTURES[shown])


def _plots(rrb: Any, take: Take) -> list[Any]:
    """Errors over time, where there are any: all four side by side, all submissions in each."""
    if not any(answer.errors for answer in take.estimates):
        return []
    views = [
        rrb.TimeSeriesView(origin=f"/{ERRORS}/{key}", name=f"{LABELS[key]} ({unit})") for key, unit in UNITS.items()
    ]
    return [rrb.Grid(*views, grid_columns=2)]
