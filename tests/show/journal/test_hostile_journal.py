"""Tests of damaged or altered journals: errors name their line, without traceback."""

import json
import os

import numpy as np
import psutil
import pytest

from live.base.compression import MAX_BYTES, compress_text, decompress_text
from live.show.journal.journal_reader import MAX_VALUES, JournalError, read_journal, survey
from live.show.journal.replay import ReplayError, load_from_header, load_journal
from live.show.patch.patch_reader import parse_patch
from tests.show.made_show import PATCH

HEAD = {"journal": 2, "patch": {"name": "test"}, "patch_path": "x.toml", "recordings": None, "steps_hash": "",
        "seed": 1, "tempo": None}  # fmt: skip


def write_journal(path, *rows, **head):
    path.write_text("\n".join(json.dumps(row) for row in (HEAD | head, *rows)) + "\n")
    return read_journal(path)


@pytest.mark.parametrize(
    "row",
    [
        {"tick": 1, "event": ["SetTempo", 0.0, "osc", 10**400]},
        {"tick": 1, "event": {"type": "SetTempo", "time": 10**400, "source": "osc", "tempo": 120.0}},
        {"tick": 1, "event": {"type": "TicksSkipped", "time": 0.0, "source": "engine", "count": 10**30}},
        {"tick": 1, "measure": 10**30, "hash": ""},
        {"tick": 1, "measure": -1, "hash": ""},
    ],
)
def test_out_of_range_numbers_are_reported_as_damage(tmp_path, row):
    found = survey(write_journal(tmp_path / "a.jsonl", row, {"tick": 2, "measure": 2, "hash": ""}))
    assert found.damaged == 1
    assert "a.jsonl, line 2: " in found.problems[0]
    assert len(found.problems[0]) < 1000
    assert list(found.measure) == [2]


@pytest.mark.parametrize("patch", [[], "x", None, {"clock": []}, {"clock": {"beats_per_measure": "x"}}])
def test_journal_with_damaged_header_can_be_surveyed(tmp_path, patch):
    rows = [{"tick": 64 * n, "measure": n, "hash": ""} for n in (1, 2)]
    assert survey(write_journal(tmp_path / "a.jsonl", *rows, patch=patch)).tempo() == [(64, 240.0)]


@pytest.mark.parametrize("tick", ["x", None, [], 10**400])
def test_damaged_steps_line_causes_only_replay_error(tmp_path, tick):
    row = {"tick": tick, "event": {"type": "StepsAdded", "time": 0.0, "source": "steps", "clips": "a"}}
    with pytest.raises(ReplayError):  # of the patch, which is no whole one
        load_journal(write_journal(tmp_path / "a.jsonl", row))


@pytest.mark.parametrize("wrong", [{"seed": "x"}, {"seed": None}, {"tempo": []}])
def test_header_with_invalid_seed_or_tempo_is_refused(wrong):
    with pytest.raises(ReplayError, match="does not hold a complete show"):
        load_from_header(HEAD | {"patch": parse_patch(PATCH, "a.toml").to_json_values()} | wrong, [])


def test_journal_without_header_object_is_refused(tmp_path):
    (tmp_path / "a.jsonl").write_text("[1]\n")
    with pytest.raises(JournalError, match="line 1"):
        read_journal(tmp_path / "a.jsonl")


ROWS = [
    {"tick": 3, "event": {"type": "Attract", "time": 0.05, "source": "osc", "x": 1.0, "z": 0.5}},
    {"tick": 5, "event": ["BeatHeard", 0.07, "audio", 0.06, 0.5, 0.9]},
    {"tick": 64, "measure": 2, "hash": "0d4c161ec809ed2b"},
    {"tick": 70, "event": {"type": "PatchChanged", "time": 1.1, "source": "patch", "patch": "{}", "version": "1"}},
    {"tick": 80, "event": {"type": "StepsAdded", "time": 1.2, "source": "steps", "clips": "a", "library": "b"}},
    {"tick": 90, "event": {"type": "TicksSkipped", "time": 1.4, "source": "engine", "count": 3}, "gap": 2},
    {"tick": 200, "end": True},
]
MANY = int(os.environ.get("HOSTILE_JOURNALS", "400"))
"""Number of mutated journals; HOSTILE_JOURNALS=100000 takes some minutes."""


def test_mutated_journals_are_read_or_refused(tmp_path):
    """Changed, cut and repeated bytes: readable lines are read, and damage is reported."""
    chance, path = np.random.default_rng(8), tmp_path / "a.jsonl"
    whole = ("\n".join(json.dumps(row) for row in (HEAD, *ROWS)) + "\n").encode()
    before, read = psutil.Process().memory_info().rss, 0
    for _ in range(MANY):
        data = bytearray(whole)
        for place in chance.integers(len(data), size=int(chance.integers(1, 12))):
            data[place] = chance.choice(np.frombuffer(b'0123456789[]{}",:eE-.ntxu\\\n\x00\xff', np.uint8))
        begin, end = sorted(chance.integers(len(data), size=2).tolist())
        path.write_bytes(bytes(data[:end] + data[begin:] if chance.random() < 0.3 else data))
        try:
            journal = read_journal(path)
        except JournalError:
            continue
        read += 1
        survey(journal)
        assert all(line.tick >= 0 for line in journal.lines_with_damage())
        assert journal.last_tick >= 0
    assert read
    assert (psutil.Process().memory_info().rss - before) / 1e6 < 200.0


@pytest.mark.parametrize("row", ["[" + "[]," * MAX_VALUES + "0]", '{"tick":1,"a":[' + "{}," * MAX_VALUES + "0]}"])
def test_line_with_too_many_values_is_reported_as_damage(tmp_path, row):
    path = tmp_path / "a.jsonl"
    path.write_text(json.dumps(HEAD) + "\n" + row + "\n")
    found = survey(read_journal(path))
    assert found.damaged == 1
    assert "more values" in found.problems[0]


@pytest.mark.parametrize("text", ["x" * (MAX_BYTES + 1), "[" + "[]," * 600_000 + "0]"])
def test_packed_text_that_needs_much_memory_is_refused(text):
    with pytest.raises(ValueError, match=r"too long|too much"):
        decompress_text(compress_text(text))
