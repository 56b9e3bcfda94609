"""What the show hears of a Link session: laws over readings that a made-up session gives."""

from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.control.events.events import BeatHeard, ControlEvent, SourceChanged
from live.control.link.link_sync import LinkReading, LinkReporter, fold_factor, phase_difference


@dataclass
class Session:
    """A made-up session: tempo [Link's bpm] and beat, moved by hand."""

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


def beats(events: list[ControlEvent]) -> list[BeatHeard]:
    return [event for event in events if isinstance(event, BeatHeard)]


def states(events: list[ControlEvent]) -> list[str]:
    return [event.state for event in events if isinstance(event, SourceChanged)]


def test_alone_nothing_is_heard_and_with_others_found_comes_first() -> None:
    session, reports = Session(peers=0), LinkReporter()
    assert [reports.update(session.after(0.02)) for _ in range(50)] == [[]] * 50
    session.peers = 2
    found, beat = reports.update(session.after(0.02))
    assert (found.state, found.detail, found.source) == ("found", "2 peers", "link")  # type: ignore[attr-defined]
    assert isinstance(beat, BeatHeard)
    assert not beat.jump
    session.peers = 1
    assert states(reports.update(session.after(0.02))) == []
    session.peers = 0
    assert states(reports.update(session.after(0.02))) == ["lost"]
    assert reports.update(session.after(0.02)) == []


@settings(max_examples=60, deadline=None)
@given(
    steps=st.lists(
        st.tuples(st.floats(0.005, 0.8), st.one_of(st.none(), st.floats(20.0, 999.0))), min_size=5, max_size=60
    ),
    metre=st.integers(2, 7),
)
def test_every_beat_told_lies_on_the_session_and_at_most_one_ahead(
    steps: list[tuple[float, float | None]], metre: int
) -> None:
    session, reports = Session(metre=metre), LinkReporter()
    for wait, tempo in steps:
        fold = fold_factor(session.tempo)
        if tempo is not None and fold_factor(tempo) == fold:
            session.tempo = tempo  # from now on; the beat goes on
        reading = session.after(wait)
        for event in beats(reports.update(reading)):
            assert not event.jump
            assert event.period == pytest.approx(60.0 * fold / session.tempo)
            assert 0.15 - 1e-9 <= event.period <= 3.0 + 1e-9
            assert 0.0 < event.beat_time - event.time <= event.period + 1e-9
            at = (session.beat + (event.beat_time - session.time) * session.tempo / 60.0) / fold
            assert phase_difference(at, event.measure * metre + event.beat, metre) == pytest.approx(0.0, abs=1e-6)
            assert 0 <= event.beat < metre == event.beats_per_measure


def test_a_beat_is_told_twice_a_beat_and_at_every_new_tempo() -> None:
    session, reports = Session(), LinkReporter()
    told = [bool(beats(reports.update(session.after(0.02)))) for _ in range(1000)]
    assert 70 <= sum(told) <= 85  # 20 s at 120 bpm: 40 beats
    session.tempo = 133.0
    (event,) = beats(reports.update(session.after(0.02)))
    assert event.period == pytest.approx(60.0 / 133.0)


def test_a_jump_is_told_and_a_mere_measure_is_none() -> None:
    session, reports = Session(), LinkReporter()
    reports.update(session.after(0.02))
    session.beat += 8.0  # the number of measures is our own affair
    assert not any(event.jump for event in beats(reports.update(session.after(0.02))))
    session.beat += 0.25
    assert [event.jump for event in beats(reports.update(session.after(0.02)))] == [True]
    assert beats(reports.update(session.after(0.02))) == []
    session.metre = 3
    assert [event.jump for event in beats(reports.update(session.after(0.02)))] == [True]


def test_beyond_four_hundred_every_second_or_fourth_beat_is_the_beat() -> None:
    assert [fold_factor(tempo) for tempo in (20.0, 400.0, 400.1, 800.0, 999.0)] == [1, 1, 2, 2, 4]


def test_starts_wait_for_the_measure_line_and_stops_do_not() -> None:
    session, reports = Session(beat=0.5), LinkReporter(start_stop=True)
    session.playing = True  # as we came
    assert states(reports.update(session.after(0.02))) == ["found"]
    session.playing, session.since = False, session.time + 0.01
    assert states(reports.update(session.after(0.02))) == ["stopped"]
    session.playing, session.since = True, session.time + 0.01
    while not (told := [e for e in reports.update(session.after(0.02)) if isinstance(e, SourceChanged)]):
        assert session.time < 3.0
    assert told[0].state == "started"
    line = session.beat - (session.time - told[0].time) * 2.0
    assert line % 4 == pytest.approx(0.0, abs=1e-6)
    assert session.time - told[0].time < 0.02


def test_without_start_stop_the_transport_is_nobodys_business() -> None:
    session, reports = Session(), LinkReporter()
    reports.update(session.after(0.02))
    session.playing = True
    assert all(states(reports.update(session.after(0.02))) == [] for _ in range(200))


def test_leaving_says_lost_once() -> None:
    session, reports = Session(), LinkReporter()
    reports.update(session.after(0.02))
    assert states(reports.end(1.0, "left")) == ["lost"]
    assert reports.end(1.0, "left") == []
