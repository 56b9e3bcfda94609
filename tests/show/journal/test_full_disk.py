"""Tests of a temporarily full disk: the show continues and the journal records the gap."""

import contextlib
import json
import shutil
import subprocess
from pathlib import Path

import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.show.journal.journal import JournalWriter, read_journal
from live.show.journal.replay import first_start, run_from
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from tests.show.journal.disk import wait_until_written
from tests.show.made_show import GRAPH, PATCH

MADE = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
ROOM = 1 << 20
STONE = "stone"


@pytest.fixture
def small_disk(tmp_path):
    """A file system of 1 MB; skips if it cannot be mounted."""
    place = tmp_path / "disk"
    place.mkdir()
    mount, unmount = shutil.which("mount"), shutil.which("umount")
    how = ["-t", "tmpfs", "-o", f"size={ROOM}", "tmpfs", str(place)]
    if mount is None or unmount is None or subprocess.run([mount, *how], capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    yield place
    subprocess.run([unmount, "--lazy", str(place)], check=True)  # a failed test may have left files open


class JournaledShow:
    """A show with a journal, run tick by tick as by an engine, without waiting for the disk."""

    def __init__(self, path, *, events_every=40):
        self.show, self.tick, self.every = MADE.start(), 0, events_every
        self.writer = JournalWriter(path, {"seed": 3, "tempo": None})

    def run(self, measures):
        """Run `measures` measures, then wait for the journal writer."""
        until = self.show.span.number + measures
        while self.show.span.number < until:
            if self.tick % self.every == 0:
                event = events.PlaceElement(
                    time=self.tick * TICK,
                    source="osc",
                    kind="attract",
                    points=((self.tick % 7 - 3.0, 0.5),),
                    measures=1.0,
                )
                self.writer.record_event(self.tick, event)
                self.show.apply(event)
            self.tick += 1
            begins = self.show.tick(self.tick * TICK)
            if begins:
                self.writer.record_measure(self.tick, self.show.span.number + 1, self.show.state_hash())
            self.writer.take_snapshot(self.show, self.tick, begins=begins)
        self.wait_until_written()

    def wait_until_written(self):
        wait_until_written(self.writer)

    def end(self):
        self.writer.close(self.tick)


def fill_disk(place):
    """Fill the disk to the last byte."""
    with (place / STONE).open("wb", buffering=0) as file:
        for piece in (bytes(1 << 12), b"x"):
            with contextlib.suppress(OSError):
                while True:
                    file.write(piece)
    with pytest.raises(OSError, match="No space"), (place / "grain").open("wb", buffering=0) as file:
        file.write(b"x")


@pytest.mark.long
def test_full_disk_leaves_gap_that_replay_reports_and_skips(small_disk):
    dance = JournaledShow(small_disk / "j", events_every=4)
    dance.run(3)
    assert dance.writer.problem == ""
    for _ in range(5):  # snapshots give some of their room back
        fill_disk(small_disk)
        dance.run(1)
    facts = dance.writer.facts()
    assert facts["dropped"] >= facts["missing"] > 6
    assert "is the disk full?" in dance.writer.problem
    (small_disk / STONE).unlink()
    dance.run(10)
    assert dance.writer.facts()["missing"] == 0
    assert "are missing; writing works again" in dance.writer.problem
    dance.end()
    rows = [json.loads(row) for row in (small_disk / "j").read_text().splitlines()]  # each is whole
    gaps = [row["gap"] for row in rows if "gap" in row]
    assert sum(gaps) == dance.writer.facts()["dropped"]
    assert gaps[-1] == facts["missing"]
    journal = read_journal(small_disk / "j")
    assert journal.complete
    start = first_start(journal, MADE)
    found = run_from(start, journal, loaded=MADE)
    assert found.different == 0
    assert any(f"{gaps[0]} lines are missing" in problem for problem in found.problems)
    assert any("resumes at the snapshot" in problem for problem in found.problems)
    assert found.measures >= 3 + 10 - 8  # of older snapshots only every eighth stays
    [(first, last)] = found.not_compared
    assert found.measures + last - first + 1 == 3 + 5 + 10


def test_journal_on_initially_full_disk_starts_with_header(small_disk):
    fill_disk(small_disk)
    dance = JournaledShow(small_disk / "j")
    dance.run(3)
    (small_disk / STONE).unlink()
    dance.run(10)
    dance.end()
    journal = read_journal(small_disk / "j")
    assert journal.header["seed"] == 3
    found = run_from(first_start(journal, MADE), journal, loaded=MADE)
    assert (found.different, found.measures > 0) == (0, True)
    assert any("lines are missing" in problem for problem in found.problems)


@pytest.mark.long
def test_journal_restarts_with_gap_after_folder_is_removed(tmp_path):
    place = tmp_path / "night"
    place.mkdir()
    dance = JournaledShow(place / "j")
    dance.run(3)
    shutil.rmtree(place)
    dance.run(10)
    dance.end()
    journal = read_journal(place / "j")
    assert (journal.header["seed"], journal.complete) == (3, True)
    found = run_from(first_start(journal, MADE), journal, loaded=MADE)
    assert (found.different, found.measures > 0) == (0, True)
    assert any("lines are missing" in problem for problem in found.problems)
