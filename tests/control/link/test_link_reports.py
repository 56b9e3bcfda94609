"""Tests of events from a Link session: properties over readings of a fake session."""

from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from live.control.link.link_sync import LinkReading, LinkReporter, fold_factor, phase_difference


@dataclass
class FakeSession:
    """A fake session: tempo [Link's bpm] and beat, changed by the test."""

    tempo: float = 120.0
    beat: float = 0.3
    time: float = 0.0
    peers: int = 1
    metre: int = 4
    playing: bool = False
    since: float = 0.0

    def after(self, seconds: float) -> LinkReading:
        self.time += seconds
        self.beat += seconds * self.tempo / 60.0
        fold = fold_factor(self.tempo)
        return LinkReading(
            self.time, self.peers, self.tempo / fold, self.beat / fold, self.metre, fold, self.playing, self.since
        )


def beat_events(events: list[ControlEvent]) -> list[BeatHeard]:
    return [event for event in events if isinstance(event, BeatHeard)]


def source_states(events: list[ControlEvent]) -> list[str]:
    return [event.state for event in events if isinstance(event, SourceChanged)]


def test_events_start_with_found_when_peers_join() -> None:
    session, reports = FakeSession(peers=0), LinkReporter()
    assert [reports.update(session.after(0.02)) for _ in range(50)] == [[]] * 50
    session.peers = 2
    found, beat = reports.update(session.after(0.02))
    assert (found.state, found.detail, found.source) == ("found", "2 peers", "link")  # type: ignore[attr-defined]
    assert isinstance(beat, BeatHeard)
    assert not beat.jump
    session.peers = 1
    assert source_states(reports.update(session.after(0.02))) == []
    session.peers = 0
    assert source_states(reports.update(session.after(0.02))) == ["lost"]
    assert reports.update(session.after(0.02)) == []


@settings(max_examples=60, deadline=None)
@given(
    steps=st.lists(
        st.tuples(st.floats(0.005, 0.8), st.one_of(st.none(), st.floats(20.0, 999.0))), min_size=5, max_size=60
    ),
    metre=st.integers(2, 7),
)
def test_reported_beats_match_session_within_one_beat_ahead(
    steps: list[tuple[float, float | None]], metre: int
) -> None:
    session, reports = FakeSession(metre=metre), LinkReporter()
    for wait, tempo in steps:
        fold = fold_factor(session.tempo)
        if tempo is not None and fold_factor(tempo) == fold:
            session.tempo = tempo  # from now on; the beat goes on
        reading = session.after(wait)
        for event in beat_events(reports.update(reading)):
            assert not event.jump
            assert event.period == pytest.approx(60.0 * fold / session.tempo)
            assert 0.15 - 1e-9 <= event.period <= 3.0 + 1e-9
            assert 0.0 < event.beat_time - event.time <= event.period + 1e-9
            at = (session.beat + (event.beat_time - session.time) * session.tempo / 60.0) / fold
            assert phase_difference(at, event.measure * metre + event.beat, metre) == pytest.approx(0.0, abs=1e-6)
            assert 0 <= event.beat < metre == event.beats_per_measure


def test_beats_are_reported_twice_per_beat_and_on_tempo_change() -> None:
    session, reports = FakeSession(), LinkReporter()
    told = [bool(beat_events(reports.update(session.after(0.02)))) for _ in range(1000)]
    assert 70 <= sum(told) <= 85  # 20 s at 120 bpm: 40 beats
    session.tempo = 133.0
    (event,) = beat_events(reports.update(session.after(0.02)))
    assert event.period == pytest.approx(60.0 / 133.0)


def test_jump_is_reported_except_for_whole_measures() -> None:
    session, reports = FakeSession(), LinkReporter()
    reports.update(session.after(0.02))
    session.beat += 8.0  # the number of measures is our own affair
    assert not any(event.jump for event in beat_events(reports.update(session.after(0.02))))
    session.beat += 0.25
    assert [event.jump for event in beat_events(reports.update(session.after(0.02)))] == [True]
    assert beat_events(reports.update(session.after(0.02))) == []
    session.metre = 3
    assert [event.jump for event in beat_events(reports.update(session.after(0.02)))] == [True]


def test_tempo_above_400_is_folded_by_two_or_four() -> None:
    assert [fold_factor(tempo) for tempo in (20.0, 400.0, 400.1, 800.0, 999.0)] == [1, 1, 2, 2, 4]


def test_start_waits_for_downbeat_and_stop_is_immediate() -> None:
    session, reports = FakeSession(beat=0.5), LinkReporter(start_stop=True)
    session.playing = True  # as we came
    assert source_states(reports.update(session.after(0.02))) == ["found"]
    session.playing, session.since = False, session.time + 0.01
    assert source_states(reports.update(session.after(0.02))) == ["stopped"]
    session.playing, session.since = True, session.time + 0.01
    while not (told := [e for e in reports.update(session.after(0.02)) if isinstance(e, SourceChanged)]):
        assert session.time < 3.0
    assert told[0].state == "started"
    line = session.beat - (session.time - told[0].time) * 2.0
    assert line % 4 == pytest.approx(0.0, abs=1e-6)
    assert session.time - told[0].time < 0.02


def test_transport_is_ignored_without_start_stop_sync() -> None:
    session, reports = FakeSession(), LinkReporter()
    reports.update(session.after(0.02))
    session.playing = True
    assert all(source_states(reports.update(session.after(0.02))) == [] for _ in range(200))


def test_leaving_reports_lost_once() -> None:
    session, reports = FakeSession(), LinkReporter()
    reports.update(session.after(0.02))
    assert source_states(reports.end(1.0, "left")) == ["lost"]
    assert reports.end(1.0, "left") == []
