"""An event that fails half way: the live show, its replay and its standby reach the same state."""

import json

import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock
from live.control.events import events
from live.control.events.event import ControlEvent
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter, read_journal
from live.show.journal.replay import first_start, run_from
from live.show.show import Show
from live.show.view.status import Status
from live.supervisor.recovery import Recovery
from live.supervisor.state_follower import StateFollower
from tests.show.journal.test_replay import MADE

BAD = events.SetParameter(time=2.0, source="osc", address="/dance/motion/warp", value=(0.4,), group="*")


@pytest.fixture
def failing_event(monkeypatch):
    """An injected fault: SetParameter takes effect, causes a Spread as well, and then raises an exception."""
    apply = Show.apply

    def poisoned(show: Show, event: ControlEvent) -> bool:
        done = apply(show, event)
        if isinstance(event, events.SetParameter):
            apply(show, events.PlaceElement(time=event.time, source="osc", kind="spread"))
            raise ZeroDivisionError("half way")
        return done

    monkeypatch.setattr(Show, "apply", poisoned)


def engine_with(path, *, forgiving):
    show, clock, inbox = MADE.start(), ManualClock(), EventQueue()
    writer = JournalWriter(path, {"origin": 0.0, **MADE.header(show, tempo=None)})
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    engine = Engine(show, clock=clock, inbox=inbox, status=status, journal=writer)
    engine.refuse_failing = forgiving
    return engine, clock, inbox, writer


def test_show_replay_and_standby_refuse_failing_event_alike(failing_event, tmp_path):
    engine, clock, inbox, writer = engine_with(tmp_path / "a.jsonl", forgiving=True)
    for frame in range(1, 271):
        clock.set(frame / 30)
        if frame == 70:
            inbox.put(BAD)
        engine.frame(lambda view: None)
    writer.close(engine.ticks.index)
    assert engine.failed_events == 1
    assert "ZeroDivisionError: half way" in engine.show.refusals.last_reason
    journal = read_journal(tmp_path / "a.jsonl")
    start = first_start(journal, MADE)
    found = run_from(start, journal, loaded=MADE)
    assert (found.different, found.failed, found.problems) == (0, 1, [])
    assert found.measures >= 3
    following = StateFollower(MADE)
    for row in (tmp_path / "a.jsonl").read_text().splitlines():
        if not json.loads(row).get("end"):
            following.add_line(row)
    heir = Recovery(following).run().show
    assert following.refused == 1
    assert engine.show.state_hash() == start.show.state_hash()
    assert (following.differences, heir.refusals.last_reason) == (0, engine.show.refusals.last_reason)


def test_failing_event_is_raised_without_refusal_mode(failing_event, tmp_path):
    engine, *_ = engine_with(tmp_path / "a.jsonl", forgiving=False)
    with pytest.raises(ZeroDivisionError, match="half way"):
        engine.apply(BAD)
