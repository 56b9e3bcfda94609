"""A small show of synthetic steps, for tests of the core."""

from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.made_steps import made_steps

PATCH = """camera = {}
name = "test"
seed = 3
reserve = 0
[clock]
bpm = 120
[[group]]
name = "front"
dancers = 5
steps = ["sway", "glide x2", "spin", "phrase"]
travel_step = "glide"
centre = [0.0, 1.5]
size = [8.0, 2.0]
[[group]]
name = "back"
dancers = 4
steps = ["glide", "sway", "spin"]
choose = "random"
travel_step = "glide"
centre = [0.0, -1.5]
size = [8.0, 2.0]
"""

PATCH_WITHOUT_CAMERA = PATCH.replace("camera = {}", "", 1)
"""Its camera has a director."""


def made_graph(threshold=0.2):
    """The motion graph of the synthetic steps."""
    return build_graph(build_library(made_steps()), threshold=threshold)


GRAPH = made_graph()


def made_show(extra="", *, top=False, reserve=0, directed=False, **options):
    """A new show of PATCH with `extra` TOML at its end (`top`: at its beginning) and `reserve` dancers in reserve.

    Its camera stands still unless it is `directed` or `extra` has a camera of its own.
    """
    own = directed or "[camera]" in extra or "[projector]" in extra or "camera." in extra
    patch = (PATCH_WITHOUT_CAMERA if own else PATCH).replace("reserve = 0", f"reserve = {reserve}")
    return assemble(parse_patch(extra + patch if top else patch + extra, "test.toml"), GRAPH, **options)
