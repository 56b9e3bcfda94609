"""Journals that somebody, or a disk, has changed: what is wrong is told with its line; no traceback."""

import json

import pytest

from live.show.journal_reading import JournalError, read_journal
from live.show.journal_survey import survey
from live.show.patch_file import parse_patch
from live.show.replay_start import ReplayError, loaded_by, loaded_of
from tests.show.made_show import PATCH

HEAD = {"journal": 2, "patch": {"name": "test"}, "patch_path": "x.toml", "recordings": None, "steps_hash": "",
        "seed": 1, "tempo": None}  # fmt: skip


def written(path, *rows, **head):
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
def test_numbers_without_end_are_damage(tmp_path, row):
    found = survey(written(tmp_path / "a.jsonl", row, {"tick": 2, "measure": 2, "hash": ""}))
    assert found.damaged == 1
    assert "a.jsonl, line 2: " in found.problems[0]
    assert len(found.problems[0]) < 1000
    assert list(found.measure) == [2]


@pytest.mark.parametrize("patch", [[], "x", None, {"clock": []}, {"clock": {"beats_per_measure": "x"}}])
def test_a_damaged_header_is_surveyed_all_the_same(tmp_path, patch):
    rows = [{"tick": 64 * n, "measure": n, "hash": ""} for n in (1, 2)]
    assert survey(written(tmp_path / "a.jsonl", *rows, patch=patch)).tempo() == [(64, 240.0)]


@pytest.mark.parametrize("tick", ["x", None, [], 10**400])
def test_a_damaged_line_about_steps_stops_no_replay(tmp_path, tick):
    row = {"tick": tick, "event": {"type": "StepsAdded", "time": 0.0, "source": "steps", "clips": "a"}}
    with pytest.raises(ReplayError):  # of the patch, which is no whole one
        loaded_by(written(tmp_path / "a.jsonl", row))


@pytest.mark.parametrize("wrong", [{"seed": "x"}, {"seed": None}, {"tempo": []}])
def test_a_header_with_no_number_for_seed_or_tempo_is_refused(wrong):
    with pytest.raises(ReplayError, match="does not hold a whole show"):
        loaded_of(HEAD | {"patch": parse_patch(PATCH, "a.toml").written()} | wrong, [])


def test_a_first_line_that_is_no_table_is_no_journal(tmp_path):
    (tmp_path / "a.jsonl").write_text("[1]\n")
    with pytest.raises(JournalError, match="line 1"):
        read_journal(tmp_path / "a.jsonl")
