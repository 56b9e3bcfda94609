"""Tests of a session over a fake Link: committed changes, failures, and machines without Link."""

import sys
import time
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from live.base.event_queue import EventQueue
from live.clock.time_source import ManualClock, SystemClock
from live.clock.timeline import Timeline
from live.control.events.events import BeatHeard, ControlEvent
from live.control.link.link_session import LinkSession, LinkUnavailable, make_link
from tests.control.waiting import wait_for


class FakeLink:
    """Link's interface over one straight timeline; commits are recorded in `committed`."""

    def __init__(self, now: Callable[[], float], tempo: float) -> None:
        self.now = now
        self.bpm, self.beat, self.at = tempo, 0.0, self.micros()
        self.others = 0
        self.enabled = False
        self.startStopSyncEnabled = False
        self.committed: list[str] = []
        self.broken = False

    def micros(self) -> int:
        return round(self.now() * 1e6) + 249_000

    def clock(self) -> "FakeLink":
        return self

    def numPeers(self) -> int:  # noqa: N802 (Link's names)
        return self.others

    def captureSessionState(self) -> "FakeState":  # noqa: N802
        if self.broken:
            raise RuntimeError("no network")
        return FakeState(self)

    def commitSessionState(self, state: "FakeState") -> None:  # noqa: N802
        self.bpm, self.beat, self.at = state.bpm, state.beat, state.at
        self.committed += state.done


class FakeState:
    def __init__(self, link: FakeLink) -> None:
        self.bpm, self.beat, self.at = link.bpm, link.beat, link.at
        self.done: list[str] = []

    def tempo(self) -> float:
        return self.bpm

    def beatAtTime(self, micros: int, _quantum: float) -> float:  # noqa: N802
        return self.beat + (micros - self.at) * self.bpm / 6e7

    def setTempo(self, bpm: float, micros: int) -> None:  # noqa: N802
        self.beat, self.at, self.bpm = self.beatAtTime(micros, 4.0), micros, bpm
        self.done.append("tempo")

    def requestBeatAtTime(self, beat: float, micros: int, _quantum: float) -> None:  # noqa: N802
        self.beat, self.at = beat, micros
        self.done.append("request")

    def forceBeatAtTime(self, beat: float, micros: int, quantum: float) -> None:  # noqa: N802
        self.requestBeatAtTime(beat, micros, quantum)
        self.done[-1] = "force"

    def isPlaying(self) -> bool:  # noqa: N802
        return False

    def timeForIsPlaying(self) -> int:  # noqa: N802
        return 0


def make_session(clock: ManualClock, **how: Any) -> tuple[LinkSession, FakeLink, EventQueue[ControlEvent]]:
    inbox: EventQueue[ControlEvent] = EventQueue()
    session = LinkSession(inbox, clock, tempo=100.0, make=lambda tempo: FakeLink(clock.now, tempo), **how)
    return session, session._link, inbox


def test_show_sets_session_tempo_only_without_peers() -> None:
    clock = ManualClock(5.0)
    session, link, inbox = make_session(clock)
    show = Timeline(tempo=126.0, beats_per_measure=3, beat_origin=2.0, measure_origin=1.0)
    session.set_timeline(show, 126.0)
    for _ in range(100):
        clock.advance(0.02)
        session.poll()
    reading = session.reading
    assert reading is not None
    assert reading.tempo == pytest.approx(126.0)
    assert reading.phase == pytest.approx(show.phase_at(reading.time), abs=1e-3)
    assert not inbox.drain()
    link.others = 1
    link.committed.clear()
    session.set_timeline(Timeline(tempo=90.0, beats_per_measure=3), 90.0)
    for _ in range(100):
        clock.advance(0.02)
        session.poll()
    assert link.committed == []
    assert {event.period for event in inbox.drain() if isinstance(event, BeatHeard)} == {60.0 / 126.0}
    session.set_tempo(97.0)
    clock.advance(0.02)
    session.poll()
    assert link.committed == ["tempo"]
    assert link.bpm == 97.0


def test_beat_is_forced_only_by_manual_resync() -> None:
    clock = ManualClock(5.0)
    session, link, inbox = make_session(clock, mode="lead")
    link.others = 2
    session.set_timeline(Timeline(tempo=126.0, beat_origin=0.5), 126.0)
    for _ in range(100):
        clock.advance(0.02)
        session.poll()
    assert link.committed[:2] == ["tempo", "force"]
    assert "force" not in link.committed[2:]
    session.resync()
    for _ in range(100):
        clock.advance(0.02)
        session.poll()
    assert link.committed.count("force") == 2
    assert not inbox.drain()
    assert session.summary == "off"  # it was never started


def test_peer_joining_between_two_calls_causes_no_jump() -> None:
    """Link adopts the peers' beat and then counts the peers; on a busy machine both may happen during a poll."""
    clock = ManualClock(5.0)
    session, link, inbox = make_session(clock)
    ask = {name: getattr(link, name) for name in ("captureSessionState", "numPeers", "micros")}
    looks = len(ask)

    def come_in_before(count: int) -> None:
        """A peer's session is joined after `count` further calls to Link."""
        left = [count]

        def question(name: str) -> Any:
            if not left[0]:
                link.bpm, link.beat, link.at, link.others = 90.0, 1.7, ask["micros"](), 1
            left[0] -= 1
            return ask[name]()

        for name in ask:
            setattr(link, name, partial(question, name))

    for count in range(2 * looks):
        link.others, link.bpm = 0, 126.0
        come_in_before(count)
        for _ in range(100):
            clock.advance(0.02)
            session.poll()
        heard = [event for event in inbox.drain() if isinstance(event, BeatHeard)]
        assert link.others == 1
        assert heard
        assert not any(event.jump for event in heard), count
        assert {event.period for event in heard} == {60.0 / 90.0}, count


def test_library_failure_is_counted_and_retried() -> None:
    session, link, inbox = make_session(SystemClock())  # type: ignore[arg-type]
    link.others, link.broken = 1, True
    session.start()
    try:
        assert wait_for(lambda: session.faults >= 2, 5.0)
        assert ": " in session.fault, "what it was is told"
        link.broken = False
        assert wait_for(lambda: session.peers == 1, 5.0)
        assert wait_for(lambda: len(inbox) >= 2, 5.0)
    finally:
        session.stop()
    assert not link.enabled
    assert [getattr(event, "state", "") for event in inbox.drain()][-1] == "lost"


def test_missing_package_error_names_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "link", None)
    with pytest.raises(LinkUnavailable, match=r"not installed \(make play, or pip install LinkPython-extern\)"):
        make_link(120.0)


def test_polling_the_session_is_fast() -> None:
    clock = SystemClock()
    session, link, _ = make_session(clock)  # type: ignore[arg-type]
    link.others = 1
    session.poll()
    before = time.process_time()
    for _ in range(500):
        session.poll()
    assert (time.process_time() - before) / 500 < 0.5e-3
