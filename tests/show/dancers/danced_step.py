"""One sketched step danced in moods, for tests of moods and of steps at their limits."""

import numpy as np

from live.clock.ticks import TICK
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.library.step_folder import sketched_steps
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from tests.places import ROOT

PATCH = """
name = "hostile"
seed = 5
reserve = 0
[clock]
bpm = {bpm}
beats_per_measure = {beats}
[stage]
width = 60.0
depth = 6.0
[motion]
mirror = "never"
warp_beats = 0.0
amplitude = 0.0
"""
GROUP = """
[[group]]
name = "g{number}"
dancers = 1
steps = ["{step}"]
centre = [{x}, 0.0]
size = [1.0, 1.0]
mood = {{ {mood} }}
"""


def danced_step(text, *, bpm=112, beats=4, seconds=6.0, moods=("",)):
    """Joints at every tick after two seconds, (T, A, J, 3) [m]: one dancer for each of `moods` in the step `text`."""
    clips = sketched_steps({"step.toml": text})
    patch = PATCH.format(bpm=bpm, beats=beats) + "".join(
        GROUP.format(number=number, step=clips[0].step, x=2.0 * (number - len(moods) / 2), mood=mood)
        for number, mood in enumerate(moods)
    )
    show = assemble(parse_patch(patch, "hostile.toml"), build_graph(build_library(clips)))
    found = []
    for tick in range(round((2.0 + seconds) / TICK)):
        time = (tick + 1) * TICK
        show.tick(time)
        if tick * TICK >= 2.0:
            position, _ = show.dancers.pose(show.span.fraction(show.clock.beat), time)
            found.append(position.astype(np.float64))
    return np.array(found)


def shipped(name):
    """The text of a common step."""
    return (ROOT / "patches" / "steps" / f"{name}.toml").read_text(encoding="utf-8")
