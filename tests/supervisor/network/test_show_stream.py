"""The numbered stream of a show's lines, and which lines of another machine can belong to a show."""

import json

import pytest

from live.control.events.events import BeatHeard, SetTempo
from live.show.journal.journal import event_line
from live.supervisor.network.show_stream import RECENT, RECENT_LINES, ShowStream, is_show_line


def test_who_was_away_gets_what_it_missed():
    stream = ShowStream()
    for number in range(5):
        stream.add(f"line {number}")
    assert stream.since(stream.name, 3) == ["line 3", "line 4"]
    assert stream.since(stream.name, 5) == []
    assert stream.since(stream.name, 6) is None
    assert stream.since("another", 3) is None
    before = stream.name
    stream.restart()
    assert stream.name != before
    assert stream.since(before, 3) is None


def test_old_lines_are_dropped_by_number_and_size():
    stream = ShowStream()
    for number in range(RECENT_LINES + 10):
        stream.add(str(number))
    assert stream.since(stream.name, 9) is None
    assert stream.since(stream.name, 10)[0] == "10"
    stream.add("x" * RECENT)
    assert stream.since(stream.name, stream.number - 2) is None


@pytest.mark.parametrize(
    "event",
    [
        BeatHeard(time=1.0, source="audio", beat_time=1.5, period=0.5, confidence=0.9),
        SetTempo(time=1.0, source="osc", tempo=120.0),
    ],
)
def test_events_as_rows_and_as_tables_belong_to_a_show(event):
    assert is_show_line(json.loads(event_line(7, event)), begun=True, tick=6)


@pytest.mark.parametrize(
    "line",
    [
        {"tick": 7, "event": "SetTempo"}, {"tick": True}, {"tick": -1}, {"tick": 1.5}, {"event": {}}, {},
        {"tick": 6 + 64 * 600 + 1}, {"tick": 7, "measure": 2}, {"tick": 7, "left_out": 1 << 20},
    ],
)  # fmt: skip
def test_what_cannot_be_of_a_show_is_refused(line):
    assert not is_show_line(line, begun=True, tick=6)


def test_nothing_but_the_first_line_comes_first():
    assert is_show_line({"journal": 2}, begun=False, tick=0)
    assert not is_show_line({"tick": 7}, begun=False, tick=0)
