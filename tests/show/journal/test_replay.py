"""Tests of replay: start measure, frame rate, damage, journal files, snapshots and slow disks."""

import json
import math
import shutil
import threading
import tracemalloc
from pathlib import Path

import pytest

from live.base.event_queue import EventQueue
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.events import events
from live.show.engine import Engine
from live.show.journal.journal import JournalWriter, read_journal
from live.show.journal.journal_writer import KEEP_EVERY, SnapshotFile, read_snapshots
from live.show.journal.replay import Replayer, first_start, run_from, start_before
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import patch_version
from live.show.state.snapshot import Snapshotter, snapshot_header
from live.show.view.status import Status
from tests.fixtures.mostly_long import mostly_long
from tests.show.journal.disk import wait_until_written
from tests.show.made_show import GRAPH, PATCH

MADE = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
SCRIPT = {
    40: events.PlaceElement(time=0.8, source="osc", kind="attract", points=((1.0, 0.5),), measures=3.0),
    150: events.SetParameter(time=3.0, source="osc", address="/dance/motion/warp", value=(0.4,), group="*"),
    260: events.Evolve(time=5.2, source="osc", formation="circle", group="front", measures=2.0),
    330: events.StepNow(time=6.6, source="osc", name="spin", group="back"),
    470: events.One(time=9.4, source="key"),
    560: events.PlaceElement(time=11.2, source="osc", kind="spread"),
    650: events.SetTempo(time=13.0, source="osc", tempo=128.0),
}


def record(path, seconds=18.0, fps=50, sink=None):
    """Run and record a show with events and a stall at `fps`; returns the engine."""
    show, clock, inbox = MADE.start(), ManualClock(), EventQueue()
    writer = JournalWriter(path, {"seed": 3, "tempo": None}, sink=sink)
    status = Status(show, rejected=dict, memory=lambda: 0.0)
    engine = Engine(show, clock=clock, inbox=inbox, status=status, journal=writer)
    for frame in range(1, round(seconds * fps) + 1):
        if 700 <= frame < 720:  # the machine stands still for a moment
            continue
        clock.set(frame / fps)
        if frame in SCRIPT:
            inbox.put(SCRIPT[frame])
        engine.frame(lambda view: None)
        if frame % fps == 0:
            wait_until_written(writer)
    writer.close(engine.ticks.index)
    return engine


@pytest.fixture(scope="module")
def recorded_journal(tmp_path_factory):
    """A journal with its snapshots, and the hash at its end."""
    path = tmp_path_factory.mktemp("night") / "a.jsonl"
    engine = record(path)
    return path, engine.show.state_hash()


@pytest.fixture
def journal_copy(recorded_journal, tmp_path):
    """A copy of the journal that tests may damage."""
    for file in (recorded_journal[0], recorded_journal[0].with_name("a.jsonl.snap")):
        shutil.copy(file, tmp_path / file.name)
    return tmp_path / "a.jsonl"


@mostly_long("fps", [25, 60, 144], quick=[1])
def test_replay_has_same_hashes_at_any_frame_rate(recorded_journal, fps):
    path, last = recorded_journal
    journal = read_journal(path)
    start = first_start(journal, MADE)
    running, view, frame = Replayer(start.show, journal.lines_with_damage()), start.show.view(), 0
    while not running.ended:
        frame += 1
        running.advance(math.floor(frame / fps / TICK))
        start.show.fill(view, max(frame / fps, running.tick * TICK))
    assert running.result.measures >= 7
    assert running.result.different == 0
    assert start.show.state_hash() == last
    assert abs(frame - journal.last_tick * TICK * fps) <= fps * 0.6  # but for the stall, it is as long as the show


@mostly_long("first", [2, 4, 6, 8], quick=[3])
def test_replay_from_measure_starts_at_previous_snapshot(recorded_journal, first):
    path, last = recorded_journal
    journal, problems = read_journal(path), []
    start = start_before(journal, MADE, first, problems)
    assert not problems
    assert start.show.span.number + 1 == first - 1
    assert start.tick > 0 or first == 2
    found = run_from(start, journal, loaded=MADE)
    assert found.different == 0
    assert found.measures == max(line.measure or 0 for line in journal.lines) - first + 1
    assert start.show.state_hash() == last


def test_replay_to_measure_ends_with_that_measure(recorded_journal):
    journal = read_journal(recorded_journal[0])
    found = run_from(start_before(journal, MADE, 3, []), journal, to=4)
    assert found.measures == 2
    assert found.different == 0
    assert found.ticks < journal.last_tick


def _damage(path, which):
    rows = path.read_text().splitlines()
    number = next(n for n, row in enumerate(rows) if which in row)
    rows[number] = rows[number][:25] + "#" + rows[number][25:]
    path.write_text("\n".join(rows) + "\n")
    return number + 1


@pytest.mark.long
def test_damaged_line_is_reported_and_replay_resumes_at_next_snapshot(journal_copy, recorded_journal):
    number = _damage(journal_copy, '"StepNow"')
    journal = read_journal(journal_copy)
    start = first_start(journal, MADE)
    found = run_from(start, journal, loaded=MADE)
    assert f"line {number}" in found.problems[0]
    assert "resumes at the snapshot in measure" in found.problems[1]
    assert found.different == 0
    assert found.ticks == journal.last_tick
    assert found.measures >= 5
    whole = [line.measure for line in read_journal(recorded_journal[0]).lines_with_damage() if line.measure]
    [(first, last)] = found.not_compared
    assert found.measures + last - first + 1 == len(whole)
    journal_copy.with_name("a.jsonl.snap").unlink()
    found = run_from(first_start(journal, MADE), journal, loaded=MADE)
    assert found.ticks < 0.5 * journal.last_tick
    assert len(found.problems) == 1
    assert found.not_compared == [(first, whole[-1])]


def test_damaged_snapshot_is_reported_and_older_snapshot_is_used(journal_copy, recorded_journal):
    file = journal_copy.with_name("a.jsonl.snap")
    whole = list(read_snapshots(file, []))
    assert [snapshot_header(data)["measure"] for data in whole] == list(range(2, len(whole) + 2))
    data = bytearray(file.read_bytes())
    place = sum(len(one) for one in whole[:3]) + len(whole[3]) // 2
    data[place] ^= 1
    file.write_bytes(data)
    problems = []
    start = start_before(read_journal(journal_copy), MADE, 6, problems)
    assert len(problems) == 1
    assert "snapshot 4: the snapshot is damaged" in problems[0]
    assert start.show.span.number + 1 == 4
    assert run_from(start, read_journal(journal_copy)).different == 0


def test_truncated_snapshot_file_is_usable(journal_copy):
    file = journal_copy.with_name("a.jsonl.snap")
    file.write_bytes(file.read_bytes()[:-1000])
    problems = []
    assert start_before(read_journal(journal_copy), MADE, 99, problems).tick > 0
    assert len(problems) == 1


def test_snapshots_of_other_patch_are_not_used(journal_copy):
    other = LoadedShow(MADE.path, parse_patch(PATCH.replace("bpm = 120", "bpm = 121"), "test.toml"), GRAPH)
    problems = []
    start = start_before(read_journal(journal_copy), other, 5, problems)
    assert start.tick == 0
    assert "other patch" in problems[0]


class Sink:
    """Stores its input, and the refusal count of the show at each line."""

    def __init__(self):
        self.show, self.lines, self.states, self.refused = None, [], [], []

    def put(self, line):
        self.lines.append(line)
        if self.show is not None:
            self.refused.append(self.show.refusals.count)

    def snapshot(self, taken):
        self.states.append(taken)

    def facts(self):
        return {"dropped": 0}

    def close(self):
        self.lines.append("closed")


def test_event_is_recorded_before_being_applied():
    sink, show, clock, inbox = Sink(), MADE.start(), ManualClock(), EventQueue()
    writer = JournalWriter(Path("no file"), {}, sink=sink)
    engine = Engine(
        show, clock=clock, inbox=inbox, status=Status(show, rejected=dict, memory=lambda: 0.0), journal=writer
    )
    sink.show = show
    engine.apply(events.CallStep(time=0.0, source="test", name="no such step"))
    assert show.refusals.count == 1
    assert sink.refused == [0]
    for frame in range(1, 200):
        clock.set(frame / 30)
        engine.frame(lambda view: None)
    writer.close(engine.ticks.index)
    assert sink.lines[-1] == "closed"
    assert [taken.measure for taken in sink.states] == sorted({taken.measure for taken in sink.states})
    assert len(sink.states) >= 2
    assert not Path("no file").exists()


def _make_snapshots(measures):
    show = MADE.start()
    source = Snapshotter(show)
    taken = source.capture(0)
    assert taken is not None
    return [type(taken)(taken.written, n * 100, n, taken.seed, taken.origin) for n in range(1, measures + 1)]


def test_older_snapshots_are_thinned(tmp_path):
    file = SnapshotFile(tmp_path / "s")
    for taken in _make_snapshots(2 * KEEP_EVERY + 4):
        file._add(taken.seal())
        assert [snapshot_header(data)["measure"] for data in read_snapshots(tmp_path / "s", [])][-1] == taken.measure
    file.close()
    kept = [snapshot_header(data)["measure"] for data in read_snapshots(tmp_path / "s", [])]
    assert kept == [1, 1 + KEEP_EVERY, 1 + 2 * KEEP_EVERY, *(2 * KEEP_EVERY + n for n in (2, 3, 4))]


def test_slow_disk_drops_snapshots_without_blocking(tmp_path, monkeypatch):
    go, begun = threading.Event(), threading.Event()

    def slow(_self, _data):
        begun.set()
        go.wait(20.0)

    monkeypatch.setattr(SnapshotFile, "_add", slow)
    file = SnapshotFile(tmp_path / "s")
    some = _make_snapshots(6)
    file.put(some[0])
    assert begun.wait(20.0)
    for taken in some[1:]:
        file.put(taken)
    assert file.dropped == 3  # one is being written, two wait
    go.set()
    file.close()


def test_lost_lines_of_older_journals_are_reported_in_place(tmp_path):
    path = tmp_path / "a.jsonl"
    lines = ['{"journal":2}', '{"tick":10,"measure":1,"hash":"ab"}', '{"tick":20,"measure":2,"hash":"cd","lost":4}']
    path.write_text("\n".join([*lines, '{"tick":30,"measure":3,"hash":"ef","lost":4}']) + "\n")
    found = list(read_journal(path).lines_with_damage())
    assert [line.measure for line in found] == [1, None, 2, 3]
    assert "line 3: lines before it could not be written, 4 in total" in (found[1].damaged or "")


@pytest.mark.long
def test_long_journal_is_not_loaded_into_memory(tmp_path):
    path = tmp_path / "long.jsonl"
    with path.open("w") as file:
        file.write('{"journal":2}\n')
        for tick in range(20_000):
            file.write(json.dumps({"tick": tick, "event": ["BeatHeard", tick / 64, "audio", 1.0, 0.5, 1.0]}) + "\n")
        file.write('{"tick":20000,"end":true}\n')
    tracemalloc.start()
    try:
        journal = read_journal(path)
        count = sum(line.event is not None for line in journal.lines)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert count == 20_000
    assert journal.complete
    assert journal.last_tick == 20_000
    assert peak < 1_000_000


@pytest.mark.long
def test_replay_starts_from_snapshot_after_patch_edit(tmp_path):
    show, clock, inbox = MADE.start(), ManualClock(), EventQueue()
    path = tmp_path / "a.jsonl"
    writer = JournalWriter(path, {"seed": 3, "tempo": None})
    engine = Engine(
        show, clock=clock, inbox=inbox, status=Status(show, rejected=dict, memory=lambda: 0.0), journal=writer
    )
    text = parse_patch(PATCH.replace('steps = ["glide", "sway", "spin"]', 'steps = ["spin"]'), "x").model_dump_json()
    for frame in range(1, 451):
        clock.set(frame / 30)
        if frame == 100:
            inbox.put(events.PatchChanged(time=3.3, source="patch", patch=text, version=patch_version(text)))
        engine.frame(lambda view: None)
        if frame % 30 == 0:
            wait_until_written(writer)
    writer.close(engine.ticks.index)
    assert show.patch.group[1].steps == ("spin",)
    journal, problems = read_journal(path), []
    start = start_before(journal, MADE, 7, problems)
    assert not problems
    assert start.show.span.number + 1 == 6
    found = run_from(start, journal, loaded=MADE)
    assert (found.different, start.show.state_hash()) == (0, show.state_hash())
    assert found.measures >= 2


def test_full_disk_message_changes_rarely():
    sink = Sink()
    writer = JournalWriter(Path("no file"), {}, sink=sink)
    assert writer.problem == ""
    told = set()
    for dropped in range(1, 2000):
        sink.facts = lambda dropped=dropped: {"dropped": dropped}
        told.add(writer.problem)
    assert len(told) == 11
    assert all("could not be written" in words for words in told)
    sink.facts = lambda: {"dropped": 0, "behind": 5000}
    assert writer.problem == "journal: the disk is 4096 or more lines behind"
