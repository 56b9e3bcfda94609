"""`live steps show STEP --reach OUT.svg|OUT.png`: where one measure of a step can lead, as a picture."""

from pathlib import Path

from live.app.option_values import writable_file
from live.app.whole_file import write_whole
from live.base.errors import PersonError
from live.cli.pictures.reach_picture import PngCanvas, SvgCanvas, draw_reach
from live.cli.steps.steps_library import find_step, named_steps
from live.graph.motion_graph import build_graph
from live.graph.select.candidates import find_candidates
from live.graph.select.reach import Reach, reach_of
from live.graph.step_library import build_library

ANY_POSE_M = 1e3
"""Which measures can follow which does not matter for how far each leads."""


def check_picture(to: Path) -> None:
    """PersonError unless the picture could be written."""
    if to.suffix.lower() not in (".svg", ".png"):
        raise PersonError(f"--reach {to}: a name that ends in .svg or .png expected", f"--reach {to.stem}.svg")
    writable_file(to, "--reach")


def reach_of_step(name: str, library: Path | None) -> Reach:
    """The reach of the step called `name`, at its own tempo; PersonError if there is none."""
    step = find_step(named_steps(library), name)
    beats = step.clips[0].beats_per_measure
    own = build_library([clip for clip in step.clips if clip.beats_per_measure == beats])
    graph = build_graph(own, threshold=ANY_POSE_M, prune=False)
    return reach_of(graph, find_candidates(graph), 0, beats * 60.0 / step.clips[0].bpm)


def write_reach(name: str, library: Path | None, to: Path) -> None:
    """Draw the reach of the step called `name` and write the picture."""
    check_picture(to)
    canvas = SvgCanvas() if to.suffix.lower() == ".svg" else PngCanvas()
    draw_reach(reach_of_step(name, library), canvas)
    write_whole(canvas.data(), to, "--reach")
