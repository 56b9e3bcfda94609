"""A running show's files are edited: saved, danced from the next free measure line, replayed bit by bit."""

import json
import math
import random
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.agents.formations.formation_notation import parse_formation
from live.agents.formations.formation_spec import spec_from_table
from live.app.services.document_service import MAX_ANSWERS_LENGTH, DocumentService
from live.control.events.document import (
    EditDocument,
    KeepCue,
    KeepFormation,
    KeepMeasures,
    KeepScene,
    KeepWays,
    RedoDocument,
    ReplaceMusic,
    RestoreDocument,
    UndoDocument,
)
from live.control.events.event import ControlEvent
from live.control.osc.osc_codec import decode, encode
from live.control.registry.registry import REGISTRY
from live.document.document_store import DocumentStore
from live.show.journal.journal import read_journal
from live.show.journal.replay import first_start, load_journal, replay
from live.show.patch.hot_reload import PatchWatch
from live.show.patch.patch_reader import read_patch
from live.show.patch.patch_update import split_deferred
from tests.control.audio.test_music_file import write_wav
from tests.document.random_edits import random_edit
from tests.show.patch.edited_night import JournaledShow, write_patch_folder

PATCH = """# Two groups.
name = "edited"
steps = "moves"
[clock]
bpm = 120
[[group]]
name = "ember"
dancers = 3
steps = ["groove"]
[[group]]
name = "tide"
dancers = 3
steps = ["side step"]

[[segment]]
measure = 2
measures = 2
formation = "line"

[[segment]]
measure = 8
measures = 2
formation = "circle"
"""


class EditedShow(JournaledShow):
    """A journaled show with the editing of its files; edits are served when the test says so."""

    def __init__(self, patch: Path) -> None:
        super().__init__(patch)
        self.watch = PatchWatch(self.loaded, self.show, post=self.inbox.put, now=self.clock.now, library=self.library)
        self.service = DocumentService(self.watch, self.show, self.path, lambda: DocumentStore(self.path))
        self.engine.event_listeners.append(self.service.handle)

    def run(self, seconds: float) -> dict[int, set[str]]:
        danced: dict[int, set[str]] = {}
        for _ in range(round(seconds * 10)):
            for measure, names in super().run(0.1).items():
                danced.setdefault(measure, set()).update(names)
            self.service.frame()
        return danced

    def send(self, *edits: dict[str, Any]) -> list[dict[str, Any]]:
        """Send edits as one message; return the answers."""
        return self.serve(EditDocument(time=self.clock.now(), source="osc", edit=json.dumps(edits)))

    def undo(self, by: str = "") -> dict[str, Any]:
        return self.serve(UndoDocument(time=self.clock.now(), source="osc", by=by))[-1]

    def serve(self, event: Any) -> list[dict[str, Any]]:
        """Have the show handle an event, then the service; return the answers that it added."""
        before = json.loads(self.service.published or "[]")
        self.inbox.put(event)
        self.run(0.1)
        self.watch.run_tasks()
        answers = json.loads(self.service.published)
        return answers[len(before) :] if answers[: len(before)] == before else answers

    def replay_differences(self) -> tuple[object, ...]:
        self.writer.close(self.engine.ticks.index)
        journal = read_journal(self.journal)
        result = replay(first_start(journal, load_journal(journal)).show, journal)
        assert result.measures > 0
        return tuple(result.differences)


@pytest.fixture
def night(tmp_path: Path) -> EditedShow:
    return EditedShow(write_patch_folder(tmp_path, PATCH))


def test_an_edit_is_saved_and_danced_from_the_next_free_measure(night: EditedShow) -> None:
    night.run(2.5)  # in the second measure
    (answer,) = night.send(
        {"id": "e1", "by": "ana", "do": "set", "at": ["group", "ember", "steps"], "value": ["side step"]}
    )
    assert (answer["id"], answer["revision"]) == ("e1", 1)
    assert 'steps = ["side step"]' in night.path.read_text()
    assert night.path.read_text().startswith("# Two groups.\n")
    danced = night.run(4.0)
    assert danced[3] == {"side step"}
    assert not night.watch.poll()
    assert not night.watch.poll()  # its own file is no news
    assert night.show.patch_updates.applied_count == 1
    night.undo("ana")
    assert night.path.read_text() == PATCH
    assert {"groove", "side step"} == night.run(4.0)[6]
    night.serve(RedoDocument(time=night.clock.now(), source="osc", by="ana"))
    assert read_patch(night.path).group[0].steps == ("side step",)
    night.serve(RestoreDocument(time=night.clock.now(), source="osc", revision=0))
    assert night.path.read_text() == PATCH
    night.run(3.0)
    assert night.show.patch == read_patch(night.path)
    assert night.replay_differences() == ()


def test_what_the_show_cannot_take_is_refused_and_not_saved(night: EditedShow) -> None:
    night.run(1.0)
    answers = night.send(
        {"id": 1, "do": "set", "at": ["group", "ember", "steps"], "value": ["no such step"]},
        {"id": 2, "do": "set", "at": ["group", "ember", "colour"], "value": [1, 0, 0]},
    )
    assert [(answer["id"], "refused" in answer) for answer in answers] == [(1, True), (2, False)]
    assert answers[0]["refused"][0]["field"] == "group.1.steps"
    assert "no step is called 'no such step'" in answers[0]["refused"][0]["what"]
    night.undo()
    assert night.path.read_text() == PATCH
    (answer,) = night.send({"do": "set", "at": ["segment", 1, "formation"], "value": "nothing"})
    assert (answer["refused"][0]["field"], answer["refused"][0]["measure"]) == ("segment.1.formation", 2.0)
    for text in ("nonsense", "7", '{"do": "burn", "at": ["seed"]}', "[" * 5000):
        night.serve(EditDocument(time=night.clock.now(), source="osc", edit=text))
    assert night.path.read_text() == PATCH
    assert night.service.status() == {"revision": 2, "accepted": 2, "refused": 6}


@pytest.mark.long
def test_keys_that_wait_for_the_next_start_are_saved_and_told(night: EditedShow) -> None:
    night.run(1.0)
    (answer,) = night.send({"do": "set", "at": ["steering", "separation"], "value": 2})
    assert answer["revision"] == 1
    assert answer["waits"] == ["steering.separation"]
    assert "steering.separation" in night.watch.message
    night.run(3.0)
    assert night.show.patch.steering.separation != 2
    assert night.watch.status()["waits"] == ["steering.separation"]


@pytest.mark.long
def test_an_undo_of_what_has_been_danced_is_refused_with_the_reason(night: EditedShow) -> None:
    night.run(1.0)
    night.send({"by": "ana", "do": "set", "at": ["segment", 1, "formation"], "value": "circle"})
    night.send({"by": "bea", "do": "set", "at": ["segment", 2, "formation"], "value": "grid"})
    night.run(6.0)  # the first one's measure is over, the second one's is not
    answer = night.undo("ana")
    assert answer["refused"][0]["what"] == "measure 2 has been danced with it"
    assert "revision" in night.undo("bea")
    assert [each.formation for each in read_patch(night.path).segment] == ["circle", "circle"]


@pytest.mark.long
def test_an_editor_of_files_and_the_commands_work_side_by_side(night: EditedShow) -> None:
    night.run(1.0)
    night.send({"do": "set", "at": ["group", "ember", "colour"], "value": [1, 0, 0]})
    night.path.write_text(night.path.read_text().replace('steps = ["groove"]', 'steps = ["side step"] # by hand'))
    night.send({"do": "set", "at": ["group", "tide", "colour"], "value": [0, 1, 0]})
    assert "# by hand" in night.path.read_text()
    night.run(3.0)
    assert night.show.patch == read_patch(night.path)
    night.path.write_text("name = ")
    (answer,) = night.send({"do": "set", "at": ["group", "tide", "colour"], "value": [0, 0, 1]})
    assert "not valid now" in answer["refused"][0]["what"]
    assert night.path.read_text() == "name = "


@pytest.mark.long
def test_answers_stay_short_enough_for_a_packet(night: EditedShow) -> None:
    for number in range(70):
        night.send({"id": f"{number}", "do": "set", "at": ["name"], "value": "x" * 60 + str(number)})
        assert len(night.service.published) <= MAX_ANSWERS_LENGTH
    assert json.loads(night.service.published)[-1]["id"] == "69"


@pytest.mark.long
def test_a_stroke_of_512_points_becomes_a_path_by_one_packet(night: EditedShow) -> None:
    """With millimetres, from one corner of a large stage to the other."""
    stroke = [[round(-90.0 + 0.35 * k, 3), round(-80.0 * math.cos(k / 40), 3)] for k in range(512)]
    night.run(1.0)
    table = {"measure": 20, "measures": 4, "group": "ember", "path": stroke}
    text = json.dumps({"do": "insert", "at": ["segment"], "value": table})
    (message,) = decode(encode("/dance/document/edit", (text,)))
    event = REGISTRY.call(message.address, message.arguments, night.clock.now(), "osc")
    assert isinstance(event, EditDocument)
    night.serve(event)
    night.run(4.0)
    assert night.show.patch.segment[2].path == tuple(map(tuple, stroke))
    assert read_patch(night.path) == night.show.patch


@pytest.mark.long
@pytest.mark.parametrize("seed", [0, 1])
def test_random_edits_of_three_people_leave_engine_and_file_alike_and_replay(night: EditedShow, seed: int) -> None:
    rng = random.Random(seed)
    store = DocumentStore(night.path)
    for _ in range(40):
        store.refresh()
        edit = random_edit(rng, store.document)
        by = rng.choice(("ana", "bea", "cem"))
        if rng.random() < 0.2:
            night.undo(by)
        else:
            night.send(edit.to_json_values() | {"by": by})
        night.run(0.1 * rng.randrange(1, 12))
    night.run(4.0)
    assert night.service.revision is not None
    assert night.service.revision > 10
    assert split_deferred(read_patch(night.path), night.show.patch)[0] == night.show.patch
    assert night.replay_differences() == ()


def play(night: EditedShow, file: str, lines: str = "") -> dict[str, Any]:
    """Replace the music; return the answer when it has been heard."""
    before = night.service.published
    event = ReplaceMusic(time=night.clock.now(), source="osc", file=file, lines=lines, by="mel")
    night.service.handle(event)
    deadline = time.monotonic() + 120.0
    while night.service.published == before and time.monotonic() < deadline:
        for thread in threading.enumerate():
            if thread.name == "music":
                thread.join(deadline - time.monotonic())
        night.watch.run_tasks()
    return json.loads(night.service.published)[-1]  # type: ignore[no-any-return]


@pytest.mark.long
def test_lines_of_the_music_act_from_the_next_measure_and_other_music_from_the_next_start(night: EditedShow) -> None:
    night.run(1.0)
    for number, seconds in enumerate((0.5, 2.5, 4.5), start=1):
        night.send({"do": "insert", "at": ["music", "line"], "value": {"time_s": seconds, "measure": number}})
    night.run(3.0)
    assert [line.time_s for line in night.show.patch.music.line] == [0.5, 2.5, 4.5]
    assert night.watch.status()["waits"] == []
    (night.path.parent / "other.txt").write_text("1.0\t1.0\t1 3\n2.5\t2.5\t2 3\n")
    (night.path.parent / "other.wav").write_bytes(b"a sound that is not read with its lines given")
    answer = play(night, "other.wav", "other.txt")
    assert answer["what"] == "music"
    notes = [(note["field"], note["measure"], note["line"] is not None) for note in answer["notes"]]
    assert notes == [("music.line.1", 1, True), ("segment.2", 8, True)]
    assert "begins in measure 8, after the music's last measure 2" in answer["notes"][1]["what"]
    night.run(3.0)
    assert [line.time_s for line in night.show.patch.music.line] == [0.5, 2.5, 4.5]  # with the music that plays
    assert night.watch.status()["waits"] == ["music.file", "music.line"]
    written = read_patch(night.path).music
    assert (written.file, [line.time_s for line in written.line]) == ("other.wav", [1.0, 2.5])
    night.undo("mel")
    assert [line.time_s for line in read_patch(night.path).music.line] == [0.5, 2.5, 4.5]
    for _ in range(3):
        night.undo()
    assert night.path.read_text() == PATCH
    night.run(3.0)
    assert night.replay_differences() == ()


@pytest.mark.long
def test_music_without_lines_is_heard_aside(night: EditedShow) -> None:
    night.run(1.0)
    rate, seconds = 22_050, 20.0
    sound = np.random.default_rng(1).normal(0.0, 0.01, int(rate * seconds)).astype(np.float32)
    for beat in range(40):  # 120 bpm from 0.25 s on, louder on each first of four
        start = int((0.25 + 0.5 * beat) * rate)
        sound[start : start + 900] += np.random.default_rng(2).normal(0.0, 0.6 if beat % 4 == 0 else 0.25, 900)[
            : len(sound[start : start + 900])
        ]
    write_wav(night.path.parent / "clicks.wav", sound[:, np.newaxis], rate)
    assert "revision" in play(night, "clicks.wav")
    lines = read_patch(night.path).music.line
    assert len(lines) >= 8
    assert np.diff([line.time_s for line in lines]) == pytest.approx(2.0, abs=0.05)
    for file, words in (("nothing.wav", "there is no file 'nothing.wav'"), (night.path.name, "read")):
        answer = play(night, file)
        assert words in answer["refused"][0]["what"]


def keep(night: EditedShow, measures: int, name: str, by: str = "ana") -> dict[str, Any]:
    return night.serve(KeepMeasures(time=night.clock.now(), source="osc", measures=measures, name=name, by=by))[-1]


@pytest.mark.long
def test_what_was_danced_becomes_a_section_and_is_danced_again(night: EditedShow) -> None:
    night.run(4.5)  # measures of 2 s
    for address, values in (
        ("/dance/sequence", ["side step x2, groove", "ember"]),
        ("/dance/formation", ["star", 2, "tide", True]),
        ("/dance/attract", [2.0, 1.0, 0.5, 2.0, "ember"]),
        ("/dance/motion/larger", [0.4, "tide"]),
    ):
        event = REGISTRY.call(address, values, night.clock.now(), "osc")
        assert isinstance(event, ControlEvent)
        night.inbox.put(event)
    danced = night.run(9.0)
    first = night.show.span.number + 1 - 4
    answer = keep(night, 4, "take")
    assert "revision" in answer, answer
    patch = read_patch(night.path)
    assert [(one.name, one.measures) for one in patch.section] == [("show", 100_000), ("take", 4)]
    kinds = ("segment", "element", "at")
    own = {kind: [one for one in getattr(patch, kind) if one.section == "take"] for kind in kinds}
    (element,) = own["element"]
    assert (element.kind, element.at, element.strength, element.group) == ("attract", (2.0, 1.0), 0.5, "ember")
    assert [one.formation for one in own["segment"] if one.group == "tide"] == ["star"]
    assert [(one.call, one.values) for one in own["at"]] == [("/dance/motion/larger", (0.4, "tide"))]
    steps = {one.group: one.steps for one in patch.sequence if one.section == "take"}
    assert set(steps) == {"ember", "tide"}
    night.inbox.put(REGISTRY.call("/dance/section", ["take"], night.clock.now(), "osc"))  # type: ignore[arg-type]
    again = night.run(14.0)
    rows = [danced[first + k] for k in range(4)]
    assert len(set(map(frozenset, rows))) > 1
    assert any([again.get(begin + k) for k in range(4)] == rows for begin in again)
    night.undo("ana")
    assert night.path.read_text() == PATCH
    night.run(3.0)
    assert night.replay_differences() == ()


@pytest.mark.long
def test_ways_of_a_flock_are_kept_and_danced_again(night: EditedShow) -> None:
    ask = KeepWays(time=night.clock.now(), source="osc", measures=2, name="flock", group="ember", by="ana")
    assert "no whole measure" in night.serve(ask)[-1]["refused"][0]["what"]
    night.run(4.5)  # measures of 2 s
    night.inbox.put(REGISTRY.call("/dance/attract", [3.0, 1.0, 1.0, 6.0], night.clock.now(), "osc"))  # type: ignore[arg-type]
    night.run(1.0)
    walked = []
    while night.show.span.number < 5:
        if night.show.span.number >= 3:
            walked.append(night.show.state.position[:3].copy())
        night.run(0.1)
    answer = night.serve(replace(ask, time=night.clock.now()))[-1]
    assert "revision" in answer, answer
    (flock,) = read_patch(night.path).evolution
    assert [len(way) <= 12 for way in flock.ways] == [True] * 3
    ends = np.array([[way[0], way[-1]] for way in flock.ways])
    assert np.hypot(*(ends - np.stack([walked[0], walked[-1]], axis=1)).transpose(2, 0, 1)).max() < 0.25
    assert np.hypot(*(ends[:, 1] - ends[:, 0]).T).max() > 0.3
    table = {"measure": 10, "measures": 5, "group": "ember", "evolution": "flock", "mirror": True}
    edit = json.dumps({"do": "insert", "at": ["segment"], "value": table})
    assert "revision" in night.serve(EditDocument(time=night.clock.now(), source="osc", edit=edit))[-1]
    while night.show.span.number < 14:
        night.run(0.1)
    apart = night.show.state.position[:3, None] - ends[:, 1] * (-1.0, 1.0)
    assert np.hypot(*apart.T).min(axis=1).max() < 0.6  # someone is at the end of each way, mirrored
    assert night.replay_differences() == ()
    wrong = replace(ask, time=night.clock.now(), group="nobody & ember")
    assert "refused" in night.serve(wrong)[-1]


@pytest.mark.long
def test_steps_of_parts_are_kept_and_danced_again(night: EditedShow) -> None:
    night.run(4.5)
    for values in (["side step x2, groove", "1 + 5"], ["walk", "3"]):
        night.inbox.put(REGISTRY.call("/dance/sequence", values, night.clock.now(), "osc"))  # type: ignore[arg-type]
    night.run(9.0)
    assert "revision" in keep(night, 3, "take")
    own = [one for one in read_patch(night.path).sequence if one.section == "take"]
    steps = {one.group: one.steps for one in own}
    assert set(steps) == {"ember", "tide", "1", "5", "3"}
    assert steps["1"] == steps["5"]
    assert steps["3"] == ("walk x3",)
    assert steps["ember"] == ("groove x3",)
    assert steps["tide"] == ("side step x3",)
    night.run(3.0)
    assert night.replay_differences() == ()


def _without_camera(values: dict[str, object]) -> dict[str, object]:
    """Leave out the camera, which its director moves."""
    return {address: value for address, value in values.items() if not address.startswith("/dance/camera/")}


@pytest.mark.long
def test_scenes_cues_and_formations_made_live_are_kept(night: EditedShow) -> None:
    night.run(1.0)
    for address, values in (
        ("/dance/light/level", [0.5]),
        ("/dance/motion/larger", [0.25, "tide"]),
        ("/dance/group/colour", [1.0, 0.0, 0.5, "2-3"]),
        ("/dance/formation/define", ["wedge", "polygon:5"]),
    ):
        night.inbox.put(REGISTRY.call(address, values, night.clock.now(), "osc"))  # type: ignore[arg-type]
    night.run(1.0)
    night.inbox.put(REGISTRY.call("/dance/scene/store", ["dusk"], night.clock.now(), "osc"))  # type: ignore[arg-type]
    night.run(0.5)
    now = {"time": night.clock.now(), "source": "osc"}
    night.serve(KeepScene(**now, name="dusk"))
    night.serve(KeepFormation(**now, name="wedge"))
    night.serve(KeepCue(**now, name="now"))
    patch = read_patch(night.path)
    wanted = {"/dance/light/level": 0.5, "/dance/motion/larger tide": 0.25}
    wanted["/dance/group/colour 2-3"] = (1.0, 0.0, 0.5)
    kept = [(scene.name, _without_camera(scene.set)) for scene in patch.scene]
    assert kept == [("dusk", wanted), ("now", wanted)]
    assert [(cue.name, cue.scene) for cue in patch.cue] == [("now", "now")]
    assert spec_from_table(patch.formation[0]) == replace(parse_formation("polygon:5"), name="wedge")
    night.inbox.put(REGISTRY.call("/dance/light/level", [0.75], night.clock.now(), "osc"))  # type: ignore[arg-type]
    night.run(0.5)
    night.serve(KeepCue(**now, name="now"))  # once more: the scene is written over
    assert read_patch(night.path).scene[1].set["/dance/light/level"] == 0.75
    for event in (KeepScene(**now, name="no"), KeepFormation(**now, name="no")):
        assert "refused" in night.serve(event)[-1]
    night.run(3.0)
    assert night.replay_differences() == ()
