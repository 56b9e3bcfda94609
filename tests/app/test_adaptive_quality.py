"""Quality of a live picture: chosen by frame cost or held by the operator, and reported in status and overlay."""

from types import SimpleNamespace

import pytest

from live.app.adaptive_quality import QualityController
from live.control.events.events import HoldQuality, Tap
from live.render.adaptive_quality import SOFTWARE, quality_steps

PERIOD = 1.0 / 30.0


class FakeRenderer:
    """A renderer that draws nothing; frames of the upper steps take too long."""

    def __init__(self):
        self.steps, self.step, self.mark = quality_steps(SOFTWARE), 0, None

    def has_effect(self, step):
        return self.steps[step].kind not in ("trails", "styles")

    def set_step(self, step):
        self.step = step


@pytest.fixture
def make_watch():
    """A function that creates a quality controller with its session and lets frames pass for some seconds."""

    def make(quality=None, holds=5):
        clock = SimpleNamespace(time=0.0, now=lambda: clock.time)
        session = SimpleNamespace(
            clock=clock,
            options=SimpleNamespace(quality=quality),
            engine=SimpleNamespace(mark=None, event_listeners=[], patch_listeners=[]),
            status=SimpleNamespace(extra_figures={}, notices=[]),
            overload=0.0,
        )
        watch = QualityController(session, FakeRenderer())
        watch.period, late = PERIOD, [0]

        def run(seconds):
            end = clock.time + seconds
            while clock.time < end:
                slow = watch._renderer.step < holds
                took = 2.0 * PERIOD if slow else PERIOD
                late[0] += slow
                clock.time += took
                watch.begin(late[0], took)
                watch.end()

        def hear(step):
            for told in session.engine.event_listeners:
                told(HoldQuality(time=0.0, source="osc", step=step))

        return watch, session, run, hear

    return make


def test_quality_is_chosen_automatically_until_operator_holds_step(make_watch):
    watch, session, run, hear = make_watch()
    run(15.0)
    told = session.status.extra_figures["quality"]()
    assert (told["step"], told["held"], told["changes"]) == (5, None, 3)  # 1 and 2 take nothing from this picture
    hear(0.0)
    run(10.0)
    assert session.status.extra_figures["quality"]() | {"changes": 0} == {
        "step": 0, "of": len(quality_steps(SOFTWARE)), "left_out": [], "held": 0, "changes": 0,
    }  # fmt: skip
    hear(-1.0)
    run(15.0)
    assert watch._renderer.step == 5
    for told in session.engine.event_listeners:
        told(Tap(time=0.0, source="osc"))
    assert watch.controller.held is None


def test_quality_option_holds_step_and_overlay_reports_hold(make_watch):
    watch, session, run, hear = make_watch(quality=15)
    run(5.0)
    last = len(quality_steps(SOFTWARE)) - 1
    assert watch._renderer.step == last
    words = session.status.notices[0]()
    assert words.startswith(f"quality {last} of {last} (held): no trails,")
    hear(0.0)
    run(1.0)
    assert session.status.notices[0]().startswith(f"quality 0 of {last} (held)")


def test_supervisor_overload_keeps_quality_from_rising(make_watch):
    """Frames are in time here: no other cause keeps the quality from rising."""
    watch, session, run, _ = make_watch(holds=1)
    run(15.0)
    assert watch._renderer.step > 0
    session.overload = 0.5
    changes = watch.controller.changes
    run(300.0)
    assert watch.controller.changes == changes
    session.overload = 0.0
    run(60.0)
    assert watch.controller.changes > changes
