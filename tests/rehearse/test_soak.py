"""A short soak test: a sound show has no problems, and injected problems are detected."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from live.base.stage_snapshot import StageView
from live.control.events.events import TicksSkipped
from live.rehearse.fault_injection import FAULT_HANDLERS, FAULT_RATES, Fault, fault_schedule
from live.rehearse.invariants import CheckingJournalWriter, check_replay
from live.rehearse.soak_test import SoakOptions, SoakTest
from live.show.patch.patch_search_path import find_patch


@pytest.fixture(scope="module")
def soak_and_report(tmp_path_factory):
    """Half a minute, with every kind of fault."""
    soak = SoakTest(
        SoakOptions(find_patch("score"), seed=4, hours=30.0 / 3600.0, fps=8.0, faults=0.0), tmp_path_factory.mktemp("s")
    )
    coming = iter([Fault(2.0 + 2.0 * number, kind, 0.3) for number, kind in enumerate(FAULT_RATES)])
    soak._faults = coming
    soak._next_fault = next(coming)
    return soak, soak.run()


@pytest.mark.long
def test_half_a_minute_with_every_fault_has_no_problems(soak_and_report):
    _, report = soak_and_report
    assert report.problems == []
    assert report.faults == dict.fromkeys(FAULT_RATES, 1)
    assert report.measures >= 8
    assert report.skipped > 0
    assert report.edits == {"good": 1, "bad": 1, "back": 1}
    assert report.refused["garbage"] > 0
    json.dumps(report.as_json(), allow_nan=False)


@pytest.mark.long
def test_soak_journal_replays_to_the_same_states(soak_and_report):
    soak, report = soak_and_report
    found = check_replay(soak.journal_path, seed=1, parts=2)
    assert found["problems"] == []
    assert found["different"] == 0
    assert found["measures"] > report.measures
    assert found["stretches"] == 2


def test_every_fault_has_a_handler_and_its_rate():
    assert set(FAULT_HANDLERS) == set(FAULT_RATES)
    times, kinds = [], []
    for fault in fault_schedule(1, rate=2.0, start=0.0):
        if fault.time > 36000.0:
            break
        times.append(fault.time)
        kinds.append(fault.kind)
    assert times == sorted(times)
    assert len(times) == pytest.approx(2.0 * sum(FAULT_RATES.values()) * 600.0, rel=0.1)
    assert kinds.count("flood") == pytest.approx(2.0 * FAULT_RATES["flood"] * 600.0, rel=0.4)
    assert list(fault_schedule(1, rate=0.0)) == []


class _FakeShow:
    """The part of a show that the writer checks."""

    def __init__(self):
        self.span = SimpleNamespace(number=3)
        self.danced_beats = 12.0
        self.time = 0.0
        zeros = np.zeros((2, 2))
        self.state = SimpleNamespace(position=zeros.copy(), velocity=zeros.copy(), acceleration=zeros.copy())
        self.timeline = SimpleNamespace(beat_at=lambda time: time)


@pytest.fixture
def writer_and_show(tmp_path):
    watching = CheckingJournalWriter(tmp_path / "j", {}, snapshots=False)
    show = _FakeShow()
    watching.take_snapshot(show, 1, begins=False)
    yield watching, show
    watching.close(9)


@pytest.mark.parametrize(
    ("number", "danced", "begins", "words"),
    [
        (5, 20.0, True, "missed"),
        (2, 12.5, False, "begins again"),
        (4, 16.0, False, "do not match"),
        (3, 11.0, False, "goes back"),
        (3, float("nan"), False, "goes back"),
    ],
)
def test_missed_or_repeated_measure_is_detected(writer_and_show, number, danced, begins, words):
    watching, show = writer_and_show
    show.span.number, show.danced_beats = number, danced
    watching.take_snapshot(show, 2, begins=begins)
    assert watching.problem_count == 1
    assert words in watching.problems[0]


def test_measure_within_skipped_ticks_is_not_missed(writer_and_show):
    watching, show = writer_and_show
    watching.record_event(1, TicksSkipped(time=0.0, source="engine", count=500))
    show.span.number, show.danced_beats = 6, 24.0
    watching.take_snapshot(show, 502, begins=True)
    assert watching.problem_count == 0
    assert watching.skipped_measures == 2


def test_nan_in_state_is_detected(writer_and_show):
    watching, show = writer_and_show
    show.state.velocity[1, 0] = np.nan
    watching.take_snapshot(show, 2, begins=False)
    assert "velocity" in watching.problems[0]


def test_nan_in_view_is_reported_with_rows_and_beat(writer_and_show):
    watching, _ = writer_and_show
    view = StageView.allocate(4, 2)
    view.phase = 1.25
    watching.check_view(view, 2)
    assert watching.problem_count == 0
    view.joint_position[(1, 3), 0, 2] = np.nan, np.inf
    watching.check_view(view, 3)
    assert watching.problem_count == 1
    assert "joint_position is not finite in rows 1, 3 of 4, 2 in all; 1.250 beats" in watching.problems[0]


@pytest.mark.long
def test_exceptions_of_show_and_replay_are_reported_in_one_line_each(tmp_path, monkeypatch):
    soak = SoakTest(SoakOptions(find_patch("score"), seed=4, hours=20.0 / 3600.0, fps=8.0, faults=0.0), tmp_path)
    show = type(soak.show)
    was = show.tick

    def tick(self, time):
        if time > 4.0:
            return [0][int(time)]
        return was(self, time)

    monkeypatch.setattr(show, "tick", tick)
    report = soak.run()
    assert not report.ok
    assert report.count == 1
    assert report.problems[0].startswith("the show ends: tick ")
    assert "IndexError" in report.problems[0]
    assert "\n" not in report.problems[0]
    assert "Traceback" in report.failures[0]["trace"]
    report.replay = check_replay(soak.journal_path, seed=1)
    assert len(report.replay["problems"]) == 1
    assert "the replay ends in an exception: IndexError" in report.replay["problems"][0]
    json.dumps(report.as_json(), allow_nan=False)
