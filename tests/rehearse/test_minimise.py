"""Journal minimizing: only the events that cause a failure remain, moved to the beginning."""

import json

import pytest

from live.clock.ticks import TICK
from live.control.events.events import Blackout, ControlEvent, PlaceElement
from live.rehearse.failure import DIFFERENT_STATE, Failure
from live.rehearse.journal_minimiser import Minimiser, Trial, entries_of, minimise, run_entries
from live.show.journal.journal import event_line
from live.show.journal.journal_reader import read_journal
from live.show.loader import load_show
from live.show.patch.patch_search_path import find_patch

MEASURE = 100


class _Trial(Trial):
    """Fails 10 ticks after a blackout in the same measure as an attractor with x = 2."""

    def __init__(self):
        self.count, self.measure_ticks = 0, []

    def run(self, entries, end):
        self.count += 1
        self.measure_ticks = list(range(MEASURE, end, MEASURE))
        drawn = {
            tick // MEASURE for tick, event in entries if isinstance(event, PlaceElement) and event.points[0][0] == 2.0
        }
        for tick, event in entries:
            if isinstance(event, Blackout) and tick // MEASURE in drawn and tick + 10 <= end:
                return Failure("IndexError", "", "show/made.py, tick", 7, tick + 10)
        return None


def _entry(tick: int, x: float | None) -> tuple[int, ControlEvent]:
    if x is None:
        return tick, Blackout(time=tick * TICK, source="osc", on=True)
    return tick, PlaceElement(time=tick * TICK, source="osc", kind="attract", points=((x, 0.0),))


def test_only_failing_events_remain_and_move_to_beginning():
    entries = [_entry(tick, 1.0) for tick in range(5, 5000, 10)]
    entries += [_entry(4520, 2.0), _entry(4530, None), _entry(4990, None)]
    entries.sort(key=lambda entry: entry[0])
    trial = _Trial()
    found = Minimiser(trial, {}, beats=4).run(entries, 5000)
    assert [type(event) for _, event in found.entries] == [PlaceElement, Blackout]
    assert found.end < 3 * MEASURE
    assert found.failure.key == ("IndexError", "show/made.py, tick")
    assert found.original_size == (503, 5000)
    for tick, event in found.entries:
        assert event.time == tick * TICK
    assert trial.count < 200


def test_journal_without_failure_is_not_minimized():
    assert Minimiser(_Trial(), {}).run([_entry(5, 1.0)], 500) is None


def test_journal_is_unchanged_without_time_budget():
    entries = [_entry(4500, 1.0), _entry(4520, 2.0), _entry(4530, None)]
    found = Minimiser(_Trial(), {}, seconds=-1.0).run(entries, 5000)
    assert [tick for tick, _ in found.entries] == [4500, 4520, 4530]


@pytest.fixture(scope="module")
def score_show():
    return load_show(find_patch("score"))


@pytest.mark.long
def test_failing_journal_is_minimized_and_written(tmp_path, score_show, monkeypatch):
    show = score_show.start(seed=3)
    said = [_entry(tick, 1.0) for tick in range(20, 700, 20)]
    said[20] = said[20][0], Blackout(time=said[20][1].time, source="osc", on=True)
    path = tmp_path / "long.jsonl"
    header = {"journal": 2, **score_show.header(show, tempo=None)}
    path.write_text(
        "\n".join([json.dumps(header), *(event_line(*entry) for entry in said), '{"tick":700,"end":true}', ""])
    )

    was = type(show).tick

    def tick(self, time):
        if self.blackout and self.brightness < 0.5:
            raise KeyError("dark")
        return was(self, time)

    monkeypatch.setattr(type(show), "tick", tick)
    found = minimise(path, seconds=60.0)
    assert [type(event) for _, event in found.entries] == [Blackout]
    assert found.failure.kind == "KeyError"
    kept = tmp_path / "short.jsonl"
    found.write(kept)
    assert kept.stat().st_size < 100_000
    journal = read_journal(kept)
    assert journal.header["patch_path"] == "score/show.toml"
    assert journal.header["fails"]["kind"] == "KeyError"
    assert entries_of(journal) == (found.entries, found.end)
    monkeypatch.undo()
    assert minimise(kept, seconds=5.0) is None


@pytest.mark.long
def test_snapshot_with_different_state_is_a_failure(score_show, monkeypatch):
    trial = Trial(score_show, {"seed": 3, "tempo": None}, snapshots=True)
    assert trial.run([_entry(20, 1.0)], 500) is None

    def other(show, entries, end, *, begin=0):
        for tick, begins in run_entries(show, entries, end, begin=begin):
            if begin and tick == begin + 5:
                show.state.position[0, 0] += 0.001
            yield tick, begins

    monkeypatch.setattr("live.rehearse.journal_minimiser.run_entries", other)
    failure = trial.run([_entry(20, 1.0)], 500)
    assert failure.kind == DIFFERENT_STATE
