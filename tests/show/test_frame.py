"""The order of a frame: which stages a tick passes, and that each can be out of service."""

import pytest

from live.clock.ticks import TICK
from live.show.circuit_breakers import EFFECTS, Stage
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import made_show

PLAN = [
    "DESK", "AUDIENCE", "CAPTURE", "DESK", "SCORE", "DESK", "EDITS", "CAPTURE", "SELECTION", "INTERRUPTS", "MEASURE",
]  # fmt: skip
MOTION = [
    "STEERING",
    "STEERING",
    "PARTNERS",
    "CORRECTION",
    "DANCERS",
    "CAPTURE",
    "PARTNERS",
    "EXPRESSION",
    "SPRINGS",
    "CLOTH",
    "LIGHT",
    "OUTSIDE",
]
LINE = [
    "DESK", "SCORE", "DESK", "CORRECTION", "DANCERS", "EDITS", "MEASURE", "SCORE", "PARTNERS", "DESK", "VARIATION",
    "SELECTION", "STEERING", "CORRECTION", "REACTIONS", "DESK", "AUDIENCE",
]  # fmt: skip


def stages_of_ticks(show, ticks):
    """The stages that each of these ticks enters, in order."""
    entered, enter, rows = [], show.breakers.enter, []

    def record(stage):
        entered.append(Stage(stage).name)
        return enter(stage)

    show.breakers.enter = record
    for tick in ticks:
        entered.clear()
        show.tick(tick * TICK)
        rows.append(list(entered))
    return rows


def test_tick_passes_stages_in_order():
    """At 120 bpm a measure has 128 ticks."""
    rows = stages_of_ticks(made_show(), range(1, 140))
    assert rows[9] == ["TICK", "CLOCK", "MEASURE", *PLAN, *MOTION]
    assert rows[127] == ["TICK", "CLOCK", "MEASURE", *LINE, *PLAN, *MOTION]
    assert {name for row in rows for name in row} == {stage.name for stage in EFFECTS} | {"OUTSIDE"}


@mostly_long("times", [1, 2], quick=[0])
@pytest.mark.parametrize("stage", EFFECTS, ids=lambda stage: stage.name.lower())
def test_show_continues_without_a_stage(stage, times):
    show = made_show()
    for _ in range(times):
        show.breakers.trip(stage.name.lower(), "a test")
    for tick in range(1, 300):
        show.tick(tick * TICK)
    assert show.span.number == 2
