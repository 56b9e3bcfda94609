"""Shows of any size for the benches: the project's own steps, on a stage that grows with the dancers."""

import math

from live.graph.motion_graph import MotionGraph
from live.show.assembly import assemble
from live.show.loader import LoadedShow, load_show
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import DEFAULT_PATCH
from live.show.show import Show


def crowd_patch(patch: Patch, dancers: int) -> Patch:
    """The patch with `dancers` dancers in its groups, two square metres and a bit for each."""
    groups = len(patch.group)
    width = max(patch.stage.width, math.sqrt(4.0 * dancers * 1.5))
    depth = max(patch.stage.depth, width / 1.5)
    sizes = [dancers // groups + (1 if i < dancers % groups else 0) for i in range(groups)]
    sections = [
        group.model_copy(
            update={
                "dancers": count,
                "formation": "grid",
                "centre": (0.0, (i - (groups - 1) / 2) * depth / groups),
                "size": (min(width * 0.9, 200.0), depth / groups * 0.8),
            }
        )
        for i, (group, count) in enumerate(zip(patch.group, sizes, strict=True))
        if count
    ]
    stage = patch.stage.model_copy(update={"width": width, "depth": depth})
    return patch.model_copy(update={"group": tuple(sections), "stage": stage})


def crowd(dancers: int, loaded: LoadedShow | None = None) -> Show:
    """A fresh show of the default patch with `dancers` dancers."""
    loaded = loaded or load_show(DEFAULT_PATCH)
    graph: MotionGraph = loaded.graph
    return assemble(crowd_patch(loaded.patch, dancers), graph)
