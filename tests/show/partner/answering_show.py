"""A small show of generated steps in which a follower answers a leader."""

from functools import cache
from pathlib import Path

import numpy as np

from live.clock.ticks import TICK
from live.show.assembly import assemble
from live.show.partner.example_bank import ExampleBank
from live.show.partner.partner_sources import load_example_bank
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch
from live.show.show import Show
from tests.show.made_show import GRAPH, PATCH

FILE = Path("test.toml")
DUET = """
[motion]
warp_beats = 0.0
[[partner]]
name = "duet"
leader = "front & 1"
follower = "back & 6"
"""
LEADER, FOLLOWER = 0, 5


@cache
def patch_of(extra: str) -> Patch:
    """PATCH with `extra` appended."""
    return parse_patch(PATCH + extra, "test.toml")


@cache
def bank_of(extra: str) -> ExampleBank | None:
    """The example bank of the partners in `extra`."""
    return load_example_bank(patch_of(extra), FILE, GRAPH.library)


def answering_show(extra: str = DUET, seed: int = 3) -> Show:
    """A new show with the partners of `extra`."""
    return assemble(patch_of(extra), GRAPH, seed=seed, answers=bank_of(extra))


def run(show: Show, seconds: float, *, drawn: bool = False) -> np.ndarray:
    """Positions of all joints at each tick of the next `seconds`, (ticks, A, J, 3); `drawn`: with extra renders."""
    view, out = show.view(), []
    first = round(show.time / TICK) + 1
    for tick in range(first, first + round(seconds / TICK)):
        show.tick(tick * TICK)
        if drawn:
            show.fill(show.view(), (tick + 0.7) * TICK)
            show.fill(show.view(), (tick + 0.2) * TICK)
        show.fill(view, tick * TICK)
        out.append(view.joint_position.copy())
    return np.array(out)


def hip_distance(position: np.ndarray, one: int = LEADER, other: int = FOLLOWER) -> np.ndarray:
    """Horizontal distance between the hips of two dancers [m], (ticks,)."""
    return np.hypot(*np.moveaxis(position[:, one, 0, ::2] - position[:, other, 0, ::2], -1, 0))


def max_joint_speed(position: np.ndarray, row: int) -> float:
    """The largest speed of any joint of a dancer between two ticks [m/s]."""
    return float(np.linalg.norm(np.diff(position[:, row], axis=0), axis=-1).max() / TICK)
