"""The frame loop: ticks, events, stalls, and equal states at any frame rate."""

import math

import pytest

from live.base.event_queue import EventQueue
from live.base.fault_isolation import Bulkhead, FaultLog
from live.base.processing_budget import FLOODED_PER_SECOND
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events.events import Blackout, CallStep, PlaceElement, SetParameter
from live.show.engine import EVENTS_PER_FRAME, HELD_EVENTS, Engine
from live.show.view.status import Status
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import made_show

LEVEL = "/dance/light/level"


def made_engine(**options):
    show, clock, inbox = made_show(), ManualClock(), EventQueue()
    status = Status(show, rejected=dict, memory=lambda: 1.0)
    return Engine(show, clock=clock, inbox=inbox, status=status, **options), clock, inbox, status


def skip_render(view):
    pass


def test_flooded_values_are_limited_per_frame_and_events_are_not():
    """The sender has its own thread; the frame pays only for the values that it applies."""
    engine, clock, inbox, _ = made_engine()
    lane, musician = inbox.add_queue(), inbox.add_queue()
    acted = []
    engine.event_listeners.append(lambda event: acted.append((type(event).__name__, clock.now())))
    for frame in range(300):
        clock.set(frame / 60)
        for number in range(120):
            lane.put(SetParameter(time=clock.now(), source="osc", address=LEVEL, value=(0.5,)), number % 60)
        if frame == 0 or frame == 200:
            musician.put(PlaceElement(time=clock.now(), source="osc", kind="attract", points=((1.0, 1.0),)))
        engine.frame(skip_render)
    values = [at for name, at in acted if name == "SetParameter"]
    assert len([at for at in values if at >= 1.0]) <= 4.0 * FLOODED_PER_SECOND + 8
    assert max(values.count(at) for at in set(values) if at >= 1.0) <= 4
    assert [at for name, at in acted if name == "PlaceElement"] == [0.0, 200 / 60]


@pytest.mark.long
def test_same_events_give_same_states_at_any_frame_rate():
    """Events are stamped with ticks: applied at those, shows at 25, 60 and 144 frames/s are identical."""
    results = []
    for fps in (25, 60, 144):
        engine, clock, _, _ = made_engine(lead=0.0)
        gather = PlaceElement(time=3.0, source="test", kind="attract", points=((2.0, 1.0),))
        pending = [(200, gather), (420, Blackout(time=6.5, source="test", on=True))]
        hashes = {}
        for frame in range(1, 10 * fps + 1):
            # apply each event exactly when its tick is the last one run, as a replay does
            target = frame / fps
            while pending and pending[0][0] * TICK <= target:
                tick, event = pending.pop(0)
                if engine.ticks.time < tick * TICK:
                    clock.set(max(clock.now(), tick * TICK))
                    engine.frame(skip_render)
                engine.apply(event)
            clock.set(max(clock.now(), target))
            engine.frame(skip_render)
            if frame % fps == 0:
                hashes[frame // fps] = engine.show.state_hash()
        results.append(hashes)
    assert results[0] == results[1] == results[2]


def test_stall_skips_and_counts_ticks():
    engine, clock, _, status = made_engine()
    clock.set(1.0)
    engine.frame(skip_render)
    assert status.skipped_ticks > 0  # the very first frame came a second late
    skipped, ticks = status.skipped_ticks, status.ticks
    clock.set(1.1)
    engine.frame(skip_render)
    assert status.skipped_ticks == skipped
    clock.set(5.0)
    engine.frame(skip_render)
    assert status.skipped_ticks - skipped > 3.8 * 64 - 2
    assert status.ticks - ticks < 20
    assert engine.ticks.time <= 5.0 + TICK


def test_flooded_events_are_spread_over_frames():
    engine, clock, inbox, status = made_engine()
    for _ in range(EVENTS_PER_FRAME + 100):
        inbox.put(Blackout(time=0.0, source="osc", on=False))
    clock.set(0.02)
    engine.frame(skip_render)
    assert status.events_accepted == EVENTS_PER_FRAME
    engine.frame(skip_render)
    assert status.events_accepted == EVENTS_PER_FRAME + 100


def test_render_failure_is_reported_once_and_show_continues():
    engine, clock, _, status = made_engine()
    told = []
    engine.on_error = told.append

    def fail(view):
        raise RuntimeError("no card")

    for frame in range(1, 11):
        clock.set(frame / 60)
        engine.frame(fail)
    assert len(told) == 1
    assert status.faults == 10
    assert status.ticks == 11
    engine.on_error = None
    with pytest.raises(RuntimeError, match="no card"):
        engine.frame(fail)


def test_view_is_one_tick_ahead_of_clock():
    engine, clock, _, _ = made_engine()
    seen = []
    clock.set(1 / 60)
    engine.frame(lambda view: seen.append((view.time, view.beat)))
    assert seen[0][0] == pytest.approx(1 / 60 + TICK)
    assert seen[0][1] == pytest.approx(2.0 * seen[0][0])


def test_offline_engine_runs_every_tick_at_any_rate():
    """Two frames a second are a slow film of the same dance."""
    states = []
    for fps in (2, 50):
        engine, clock, _, status = made_engine(stall=math.inf, lead=0.0)
        for frame in range(1, 6 * fps + 1):
            clock.set(frame / fps)
            engine.frame(skip_render)
        states.append(engine.show.state_hash())
        assert status.ticks == 6 * 64
        assert status.skipped_ticks == 0
    assert states[0] == states[1]


def test_refused_event_is_not_counted_as_accepted():
    engine, clock, inbox, status = made_engine()
    inbox.put(CallStep(time=0.0, source="osc", name="moonwalk"))
    inbox.put(CallStep(time=0.0, source="osc", name="spin"))
    clock.set(0.02)
    engine.frame(skip_render)
    assert status.events_accepted == 1
    assert status.snapshot(0.02)["events_rejected"] == {"not in this show": 1}


@mostly_long("lead", [0.0, 0.02, 0.113], quick=[0])
def test_view_time_includes_the_display_latency(lead):
    """Display and projector take `lead`: the frame shows the beat that sounds when the frame is visible."""
    engine, clock, _, _ = made_engine(lead=lead)
    for _ in range(60):
        clock.advance(0.021)
        engine.frame(skip_render)
        assert engine.view.time == pytest.approx(clock.now() + lead)
        assert engine.view.beat == pytest.approx(engine.show.timeline.beat_at(clock.now() + lead))
    engine.lead = lead + 0.05  # the projector turns out to be slower
    clock.advance(0.021)
    engine.frame(skip_render)
    assert engine.view.time == pytest.approx(clock.now() + lead + 0.05)


@pytest.mark.long
def test_listener_and_source_errors_do_not_affect_frames_or_state():
    """Event and patch listeners, event sources, and figures for the overlay."""
    engine, clock, inbox, status = made_engine()
    plain, plain_clock, plain_inbox, _ = made_engine()
    engine.bulkhead = Bulkhead(faults := FaultLog())
    told = []

    def fails(*values):
        raise IndexError("made by a test")

    def fails_late(time):
        yield from ()
        fails()

    for row in (engine.event_listeners, engine.event_sources, engine.patch_listeners):
        row.append(fails)
    engine.event_sources.append(fails_late)
    engine.event_listeners.append(told.append)
    engine.overlay = engine.guides = True
    status.notices.append(fails)
    status.extra_figures["made"] = fails
    for frame in range(1, 60):
        for inbox_of in (inbox, plain_inbox):
            if frame == 20:
                inbox_of.put(Blackout(time=frame / 30, source="test", on=True))
        for clock_of, one in ((clock, engine), (plain_clock, plain)):
            clock_of.set(frame / 30)
            one.frame(skip_render)
    assert len(told) == 1
    assert engine.show.state_hash() == plain.show.state_hash()
    assert faults.total >= 5
    assert status.snapshot(2.0)["made"] is None


def test_event_source_error_is_raised_without_bulkhead():
    engine, clock, _, _ = made_engine()
    engine.event_sources.append(lambda time: [][1])
    clock.set(0.1)
    with pytest.raises(IndexError):
        engine.frame(skip_render)


def test_held_input_acts_in_order_once_it_is_released_and_clock_and_blackout_at_once():
    """After a first start kernels are still being compiled: a frame must not wait for them, and nothing is lost."""
    engine, clock, inbox, _ = made_engine()
    busy = [True]
    engine.holding = lambda: busy[0]
    acted = []
    engine.event_listeners.append(lambda event: acted.append(type(event).__name__))
    inbox.put(PlaceElement(time=0.0, source="osc", kind="attract", points=((1.0, 1.0),)))
    inbox.put(Blackout(time=0.0, source="keys", on=True))
    inbox.put(CallStep(time=0.0, source="osc", name="no such step"))
    for frame in range(5):
        clock.set(frame / 60)
        engine.frame(skip_render)
    assert acted == ["Blackout"]
    busy[0] = False
    inbox.put(PlaceElement(time=0.1, source="osc", kind="spread"))
    clock.set(0.1)
    engine.frame(skip_render)
    assert acted == ["Blackout", "PlaceElement", "CallStep", "PlaceElement"]
    assert engine.holding is None


def test_a_flood_of_held_input_is_released_and_not_lost():
    engine, clock, inbox, _ = made_engine()
    engine.holding = lambda: True
    acted = []
    engine.event_listeners.append(acted.append)
    count = 0
    while engine.holding is not None and count < 3 * HELD_EVENTS:
        for _ in range(256):
            inbox.put(CallStep(time=clock.now(), source="osc", name="no such step"))
            count += 1
        clock.set(clock.now() + 1 / 60)
        engine.frame(skip_render)
    while inbox:
        clock.set(clock.now() + 1 / 60)
        engine.frame(skip_render)
    assert len(acted) == count
    assert inbox.dropped == 0
