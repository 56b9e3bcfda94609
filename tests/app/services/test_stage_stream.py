"""The stage for pages: frames of a show, its files and their changes."""

import json
import random
import struct
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.app.services.score_stream import MAX_ENTRIES, ScoreStream, change_values
from live.app.services.stage_stream import StageStream
from live.clock.ticks import TICK
from live.control.events.event import ControlEvent
from live.control.registry.registry import REGISTRY
from live.document.document_store import DocumentStore
from live.document.edit import Edit, EditRefused
from live.show.patch.table_batches import patch_json
from tests.app.services.test_document_service import PATCH, EditedShow
from tests.document.random_edits import random_edit
from tests.fixtures.mostly_long import mostly_long
from tests.show.patch.edited_night import write_patch_folder

WANTS = {"pages": 1, "joints": None, "structure": 1}


class StreamedShow(EditedShow):
    """A show whose pages get packets at each frame."""

    def __init__(self, patch: Path) -> None:
        super().__init__(patch)
        view = self.show.view()
        self.late = 3
        self.next = None
        self.stream = StageStream(self.show, lambda: view, ScoreStream(self.show, self.service), lambda: self.late,
                                  lambda: self.next)  # fmt: skip
        self.engine.patch_listeners.append(lambda patch: self.stream.update_patch())
        self.view = view

    def packets(self, wants: Any = WANTS) -> list[list[Any]]:
        """Return the packets of one frame and of the next, between which the watching thread has worked."""
        self.show.fill(self.view, self.show.time)
        now = self.clock.now()
        before = list(self.stream.packets(now, wants))
        self.watch.run_tasks()
        return before + list(self.stream.packets(now + 1 / 30, wants))


@pytest.fixture
def night(tmp_path: Path) -> StreamedShow:
    return StreamedShow(write_patch_folder(tmp_path, PATCH))


def texts_of(packets: list[list[Any]], name: str) -> list[Any]:
    """Return the texts of a name that came."""
    found, pieces = [], []
    for packet in packets:
        if packet[:2] == ["text", name]:
            _, _, number, part, parts, data = packet
            assert part == len(pieces)
            pieces.append(data)
            if part + 1 == parts:
                found.append(json.loads(b"".join(pieces)))
                assert found[-1].get("revision", number) == number
                pieces.clear()
    assert not pieces
    return found


@pytest.mark.long
def test_nobody_looks_and_nothing_is_written(night: StreamedShow) -> None:
    night.run(0.5)
    for wants in (None, {}, {"pages": 0}, "nonsense", {"pages": None}):
        assert night.packets(wants) == []
    night.send({"do": "set", "at": ["seed"], "value": 7})
    assert night.packets(None) == []


def test_frames_hold_places_headings_and_joints(night: StreamedShow) -> None:
    night.run(3.0)
    packets = night.packets({"pages": 1, "joints": [2, 1, 99, "x"]})
    assert texts_of(packets, "dancers")[0]["ids"] == list(range(1, 11))  # six, and four in the wings
    positions, joints = [packet[2] for packet in packets if packet[0] == "frame"][:2]
    kind, _, count, tick = struct.unpack_from("<BBHI", positions)
    assert (kind, count, tick) == (1, 10, round(night.show.time / TICK))
    rows = np.frombuffer(positions, "<i2", offset=8).reshape(10, 4)
    assert np.abs(rows[:, :2] / 1000 - night.show.dancers.drawn_hips).max() < 0.001
    group = np.where(night.show.motion.present, night.show.casting.group + 1, 0)
    assert rows[:, 3].tolist() == group[:10].tolist()
    facing = rows[:6, 2] / 10_000 * 2 * np.pi
    assert np.abs(facing).max() < 1.0  # to the public, more or less
    kind, flags, count, _ = struct.unpack_from("<BBHI", joints)
    assert (kind, flags, count, len(joints)) == (2, 1, 2, 8 + 2 * 22 * 6)
    found = np.frombuffer(joints, "<i2", offset=8).reshape(2, 22, 3) / 1000
    assert np.abs(found - night.view.joint_position[[1, 0]]).max() < 0.001


@pytest.mark.long
def test_they_come_thirty_times_a_second_at_most_and_the_clock_ten_times(night: StreamedShow) -> None:
    night.run(0.5)
    counts = Counter[str]()
    for frame in range(600):  # ten seconds of frames
        for packet in night.stream.packets(frame / 60, WANTS):
            counts[packet[1] if packet[0] == "text" else str(packet[1])] += 1
    assert 298 <= counts["1"] <= 302
    assert counts["2"] == 0
    assert 98 <= counts["clock"] <= 102
    assert counts["dancers"] == 1


@pytest.mark.long
def test_the_clock_has_elements_with_their_measures_and_the_lateness(night: StreamedShow) -> None:
    night.run(4.5)
    event = REGISTRY.call("/dance/attract", [1.0, -0.5, 1.5, 2.0], night.clock.now(), "osc")
    assert isinstance(event, ControlEvent)
    night.inbox.put(event)
    night.run(1.0)
    night.show.follower._alignment.runner_up = (2.0, 0.45)  # of another line
    night.stream._count = 1  # the next but one has a clock
    list(night.stream.packets(100.0, WANTS))
    packets = [packet for turn in range(4) for packet in night.stream.packets(100.25 + turn / 30, WANTS)]
    clock = texts_of(packets, "clock")[0]
    assert clock["late_frames"] == 3
    assert (clock["runner_up"], clock["asks"]) == ([2.0, 0.45], False)
    assert clock["frame_ms"] == pytest.approx(250.0)
    (element,) = clock["elements"]
    assert (element["at"], element["strength"]) == ([1.0, -0.5], 1.5)
    assert element["from"] < clock["measure"] + 1 <= element["to"] + 1
    assert element["to"] - element["from"] == pytest.approx(2.0, abs=0.3)


@pytest.mark.long
def test_what_could_come_next_is_told_with_the_launches(night: StreamedShow) -> None:
    night.run(0.5)
    night.stream._count = 1
    (launches,) = texts_of(night.packets(), "launches")
    assert launches["next"] is None
    night.next = {"after": "cross", "who": "*", "pads": [{"pad": "formation line", "name": "line", "measures": 3}]}
    packets = [packet for turn in range(4) for packet in night.stream.packets(100.0 + turn / 30, WANTS)]
    assert [one["next"] for one in texts_of(packets, "launches")] == [night.next]


def test_the_structure_comes_once_and_when_it_is_wanted_again(night: StreamedShow) -> None:
    night.run(0.5)
    (structure,) = texts_of(night.packets(), "structure")
    assert structure["score"] == json.loads(patch_json(night.show.patch))
    assert [group["name"] for group in structure["groups"]] == ["ember", "tide"]
    assert {"name": "groove", "measures": 1} in structure["library"]
    assert structure["revision"] == 0
    assert texts_of(night.packets(), "structure") == []
    assert len(texts_of(night.packets(WANTS | {"structure": 2}), "structure")) == 1
    night.packets({})  # another process shows pages now
    assert len(texts_of(night.packets(WANTS | {"structure": 2}), "structure")) == 1


def test_an_edit_is_told_at_once_as_a_change(night: StreamedShow) -> None:
    night.run(0.5)
    night.packets()
    night.send({"id": "e", "by": "ana", "do": "set", "at": ["segment", 2, "formation"], "value": "line"})
    (change,) = texts_of(night.packets(), "change")
    assert (change["revision"], change["by"], change["what"]) == (1, "ana", "edit")
    assert change["edit"] == {"do": "set", "at": ["segment", 2, "formation"], "value": "line"}
    assert change["entries"] == [{"at": ["segment", 2], "value": {"measure": 8, "measures": 2, "formation": "line"}}]
    night.run(4.0)  # the show takes it: that is no news
    assert texts_of(night.packets(), "structure") == []
    night.undo("ana")
    assert texts_of(night.packets(), "change")[0]["what"] == "undo"
    night.send({"do": "set", "at": ["segment", 2, "formation"], "value": "nonsense"})
    assert texts_of(night.packets(), "change") == []


@pytest.mark.long
def test_what_a_text_editor_saves_comes_as_a_whole(night: StreamedShow) -> None:
    night.run(0.5)
    night.packets()
    night.path.write_text(PATCH.replace('formation = "circle"', 'formation = "line"'))
    night.watch.poll()
    night.watch.poll()
    night.run(4.0)
    (structure,) = texts_of(night.packets(), "structure")
    assert structure["revision"] == 1
    assert structure["score"]["segment"][1]["formation"] == "line"
    night.send({"do": "set", "at": ["segment", 1, "measures"], "value": 3})
    assert texts_of(night.packets(), "change")[0]["revision"] == 2


def applied(score: dict[str, Any], change: dict[str, Any]) -> None:
    """Apply a change to a score, as a page does."""
    for shift in change["shifts"]:
        rows = score.setdefault(shift["list"], [])
        row = rows.pop(shift["from"] - 1) if shift["from"] is not None else None
        if shift["to"] is not None:
            rows.insert(shift["to"] - 1, row)
    for entry in change["entries"]:
        name, *number = entry["at"]
        if number:
            score[name][number[0] - 1] = entry["value"]
        elif entry["value"] is None:
            score.pop(name, None)
        else:
            score[name] = entry["value"]


@mostly_long("seed", range(4), quick=[0])
def test_changes_applied_to_a_score_give_the_next_one(tmp_path: Path, seed: int) -> None:
    more = "".join(
        f'[[element]]\nkind = "attract"\nmeasure = {measure}\n[[signal]]\nname = "s{measure}"\nmeasure = {measure}\n'
        f'[[at]]\nmeasure = {measure}\ncall = "/dance/spread"\nvalues = [1]\n'
        for measure in range(1, 9)
    )
    path = tmp_path / "show.toml"
    path.write_text(PATCH.replace('steps = "moves"\n', "") + more)
    store, rng = DocumentStore(path), random.Random(seed)
    score, described = json.loads(patch_json(store.document.patch)), 0
    for turn in range(150):
        before = store.revision
        joint = [random_edit(rng, store.document) for _ in range(3)]
        try:
            if rng.random() < 0.2 and turn:
                accepted = store.undo()
            elif rng.random() < 0.5:
                accepted = store.edit_together(lambda _, joint=joint: joint, "keep", "")  # type: ignore[misc]
            else:
                accepted = store.edit(joint[0])
        except EditRefused:
            continue
        if store.revision == before:
            continue
        change = json.loads(json.dumps(change_values(accepted.revision, store.document.patch)))
        fresh = json.loads(patch_json(store.document.patch))
        if change["entries"] is None:
            score = fresh
            continue
        described += 1
        applied(score, change)
        score = {name: value for name, value in score.items() if value not in ([], {})}
        assert score == {name: value for name, value in fresh.items() if value not in ([], {})}, change
    assert described > 30


def test_an_entry_that_came_and_went_in_one_revision_is_not_told(tmp_path: Path) -> None:
    path = tmp_path / "show.toml"
    path.write_text(PATCH.replace('steps = "moves"\n', ""))
    store = DocumentStore(path)
    fresh = {"measure": 5, "formation": "grid"}
    edits = [
        Edit("insert", ("segment", 2), fresh),
        Edit("insert", ("segment", 1), fresh),
        Edit("delete", ("segment", 1)),
    ]
    accepted = store.edit_together(lambda _: edits, "keep", "")
    entries = change_values(accepted.revision, store.document.patch)["entries"]
    assert {one["at"][1] for one in entries} <= {1, 2, 3}
    assert {"at": ["segment", 2], "value": fresh} in entries


def test_a_change_of_very_many_entries_is_no_change(tmp_path: Path) -> None:
    path = tmp_path / "show.toml"
    path.write_text(
        PATCH.replace('steps = "moves"\n', "")
        + "".join(
            f'[[segment]]\nmeasure = {20 + one}\ngroup = "ember"\nformation = "line"\n' for one in range(MAX_ENTRIES)
        )
    )
    store = DocumentStore(path)
    accepted = store.edit(Edit("rename", ("group", "ember"), "glow"))
    assert change_values(accepted.revision, store.document.patch)["entries"] is None


def launches_of(night: StreamedShow) -> list[dict[str, Any]]:
    """Return what the next frames tell about launches; the clock is told in every third frame."""
    told = [text for _ in range(3) for text in texts_of(night.packets(), "launches")]
    return told[-1:]


@pytest.mark.long
def test_every_page_is_told_what_waits_runs_and_cannot_follow(night: StreamedShow) -> None:
    night.run(1.0)
    packets = [packet for _ in range(3) for packet in night.packets()]
    (pads,) = texts_of(packets, "pads")
    assert [pad["pad"] for pad in pads["pads"]["step"]][:1] == ["step " + night.show.graph.library.steps[0]]
    assert set(pads["pads"]) == {"own", "step", "phrase", "formation", "element", "look"}
    (told,) = texts_of(packets, "launches")
    assert (told["launches"], told["beats"]) == ([], 4)
    assert set(told["away"]) == {"*", "ember", "tide"}
    assert launches_of(night) == []  # nothing has changed
    made = REGISTRY.call("/dance/launch", ("element spread", "ember", "measure", 2), night.clock.now(), "osc")
    assert isinstance(made, ControlEvent)
    night.inbox.put(made)
    night.run(0.1)
    (told,) = launches_of(night)
    (row,) = told["launches"]
    due = (night.show.span.number + 1) * 4
    assert (row["pad"], row["who"], row["state"], row["due"]) == ("element spread", "ember", "waits", due)
    night.run(3.0)
    (told,) = launches_of(night)
    assert [(row["state"], row["until"]) for row in told["launches"]] == [("runs", due + 8)]
    night.packets({"pages": 0})
    night.run(0.5)
    again = [packet for _ in range(3) for packet in night.packets()]  # a page that comes later
    assert len(texts_of(again, "pads")) == len(texts_of(again, "launches")) == 1
