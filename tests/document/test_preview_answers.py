"""Answers of the preview: the frames are what the engine says, and wrong questions are refused with words."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.document.document_store import DocumentStore
from live.document.edit import Edit
from live.document.preview import PreviewEngine
from live.document.preview_answers import MAX_RANGE, PreviewAnswers, open_answers
from live.show.loader import LoadedShow, load_show
from live.show.view.stage_frames import joints_frame, positions_frame
from tests.control.audio.test_music_file import write_wav
from tests.document.test_preview import TEXT
from tests.fixtures.mostly_long import mostly_long


def written(folder: Path) -> LoadedShow:
    path = folder / "show.toml"
    path.write_text(TEXT)
    return load_show(path)


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedShow:
    """The show of tests that leave its file as it is."""
    return written(tmp_path_factory.mktemp("show"))


@pytest.fixture(scope="module")
def answers(loaded: LoadedShow) -> PreviewAnswers:
    """For tests that try no edit: each measure is simulated once."""
    return open_answers(loaded)


@pytest.fixture
def own(tmp_path: Path) -> LoadedShow:
    """A show whose file may be changed."""
    return written(tmp_path)


def asked(answers: PreviewAnswers, **question: Any) -> tuple[dict[str, Any], list[bytes]]:
    """Return the text frames of an answer by their kinds, and the binary ones."""
    question = {key.rstrip("_"): value for key, value in question.items()}
    texts: dict[str, Any] = {}
    frames: list[bytes] = []
    for frame in answers.answer(question):
        if isinstance(frame, bytes):
            frames.append(frame)
        else:
            told = json.loads(frame)
            assert told["kind"] not in texts
            texts[told["kind"]] = told
    return texts, frames


@pytest.mark.long
@pytest.mark.parametrize("positions", ["measures", pytest.param("samples", marks=pytest.mark.long)])
def test_a_range_is_what_the_engine_says(loaded: LoadedShow, positions: str) -> None:
    engine = PreviewEngine(loaded)
    texts, frames = asked(open_answers(loaded), id=7, from_=7, to=9, positions=positions)
    wanted = [engine.at(measure) for measure in (6.0, 7.0, 8.0, 9.0)]
    if positions == "samples":
        wanted = engine.samples(6.0, 9.0)
        assert len(wanted) > 90
    assert frames == [positions_frame(one.tick, one.place, one.heading, one.present) for one in wanted]
    assert [one["tick"] for one in texts["moments"]["moments"]] == [one.tick for one in wanted]
    assert texts["dancers"]["ids"] == [1, 2, 3, 4, 5, 6]
    ways = np.array(texts["ways"]["ways"])
    assert ways.shape == (6, 3 * 32, 2)
    assert np.abs(ways - engine.plan(7, 9).ways.transpose(1, 0, 2)).max() < 0.001
    assert texts["notes"]["meetings"] == []
    assert texts["done"] == {"kind": "done", "id": 7, "document": 0}


@pytest.mark.long
def test_a_range_has_the_joints_of_each_sample(loaded: LoadedShow) -> None:
    engine = PreviewEngine(loaded)
    _, frames = asked(
        open_answers(loaded), id=1, from_=7, to=8, positions="samples", joints=[2], ways=False, notes=False
    )
    there = engine.samples(6.0, 8.0)
    assert len(frames) == 2 * len(there)
    middle = len(there) // 2
    assert frames[len(there) + middle] == joints_frame(
        there[middle].tick, engine.view_at(there[middle].measure).joint_position[:6], [2]
    )
    refused, _ = asked(open_answers(loaded), id=2, from_=1, to=17, positions="samples", joints=True)
    assert "at once" in refused["refused"]["refused"][0]["what"]


@pytest.mark.long
def test_planned_ways_of_an_edit_need_no_run(loaded: LoadedShow) -> None:
    answers = open_answers(loaded)
    asked(answers, id=1, from_=8, to=8)
    tried = [{"do": "set", "at": ["segment", 2, "formation"], "value": "line"}]
    quick, frames = asked(answers, id=2, from_=8, to=8, with_=tried, planned=True)
    whole, _ = asked(answers, id=3, from_=8, to=8, with_=tried)
    assert frames == []
    planned, danced = (np.array(texts["ways"]["ways"]) for texts in (quick, whole))
    apart = np.linalg.norm(planned - danced, axis=-1)
    assert apart.max() < 0.15  # who knows of the edit takes another last step before, ...
    assert (np.diff(apart, axis=1) < 2e-3).all()  # ... and comes nearer ...
    assert apart[:, -1].max() < 2e-3  # ... until all arrive
    assert (quick["notes"]["meetings"], quick["done"]["kind"]) == (whole["notes"]["meetings"], "done")
    earlier = [{"do": "set", "at": ["segment", 1, "formation"], "value": "star"}]
    assert "moments" in asked(answers, id=4, from_=8, to=8, with_=earlier, planned=True)[0]  # they stand elsewhere then


@pytest.mark.long
def test_a_moment_has_positions_and_joints(loaded: LoadedShow, answers: PreviewAnswers) -> None:
    engine = PreviewEngine(loaded)
    texts, frames = asked(answers, measure=5.5, joints=True)
    there = engine.at(4.5)
    joints = engine.view_at(4.5).joint_position[:6]
    assert frames == [
        positions_frame(there.tick, there.place, there.heading, there.present), joints_frame(there.tick, joints)
    ]  # fmt: skip
    assert texts["moments"]["moments"][0]["measure"] == pytest.approx(5.5, abs=0.05)
    _, frames = asked(answers, measure=5.5, joints=[2, 1])
    assert frames[1] == joints_frame(there.tick, joints, [2, 1])
    assert len(asked(answers, measure=5.5)[1]) == 1


@pytest.mark.long
def test_edits_are_tried_and_the_document_stays(loaded: LoadedShow) -> None:
    answers = open_answers(loaded)
    plain = asked(answers, from_=8, to=9)
    edit = {"id": "e", "do": "set", "at": ["segment", 2, "formation"], "value": "line"}
    wrong = {"id": "w", "do": "set", "at": ["segment", 2, "formation"], "value": "nonsense"}
    texts, frames = asked(answers, from_=8, to=9, with_=[edit, wrong])
    patch = loaded.patch.model_copy(
        update={"segment": (loaded.patch.segment[0], loaded.patch.segment[1].model_copy(update={"formation": "line"}))}
    )
    engine = PreviewEngine(loaded).branch(patch)
    assert frames == [
        positions_frame(one.tick, one.place, one.heading, one.present) for one in map(engine.at, (7.0, 8.0, 9.0))
    ]
    assert [(one["id"], "refused" in one) for one in texts["notes"]["answers"]] == [("e", False), ("w", True)]
    assert texts["notes"]["answers"][1]["refused"][0]["field"] == "segment.2.formation"
    assert frames != plain[1]
    assert asked(answers, from_=8, to=9) == plain
    assert loaded.path.read_text() == TEXT
    assert not (loaded.path.parent / ".history").exists()


@pytest.mark.long
def test_an_accepted_edit_of_another_process_is_taken_in_and_earlier_measures_stay(own: LoadedShow) -> None:
    answers = open_answers(own)
    edit = {"do": "set", "at": ["segment", 2, "formation"], "value": "line"}
    tried, frames = asked(answers, from_=8, to=9, with_=[edit])
    plain = asked(answers, from_=8, to=9)[1]
    DocumentStore(own.path).edit(Edit("set", ("segment", 2, "formation"), "line"))
    ticks = []
    answers.on_tick = lambda: ticks.append(1)
    texts, after = asked(answers, from_=8, to=9)
    assert after == frames  # simulated when it was tried
    assert not ticks
    assert texts["done"]["document"] == tried["done"]["document"] + 1 == 1
    assert asked(answers, from_=8, to=9, document=0)[1] == plain  # compared with what was before
    own.path.write_text("name = ")  # by hand, and not whole yet
    assert asked(answers, from_=8, to=9)[1] == frames


@pytest.mark.long
def test_documents_that_differ_in_the_music_alone_have_previews_of_their_own(loaded: LoadedShow) -> None:
    answers = open_answers(loaded)
    other = {"do": "insert", "at": ["music", "phrase"], "value": {"measure": 1, "name": "a"}}
    plain = {measure: asked(answers, from_=measure)[1] for measure in (2, 4, 6, 8)}
    answers = open_answers(loaded)
    for measure, wanted in plain.items():  # each goes on in turn
        edits = [other] if measure % 4 else []
        assert asked(answers, from_=measure, with_=edits)[1] == wanted
    assert "revision" in asked(answers, from_=1, with_=[other])[0]["notes"]["answers"][0]


@pytest.mark.long
def test_a_segment_stands_for_its_measures(answers: PreviewAnswers) -> None:
    texts, frames = asked(answers, segment=1, positions="none", notes=False)
    assert (texts["ways"]["from"], texts["ways"]["to"]) == (2, 4)
    assert not frames
    assert set(texts) == {"ways", "done"}
    assert texts["ways"]["dancers"] == [1, 2, 3]
    whole = asked(answers, from_=2, to=4, positions="none")[0]["ways"]
    assert whole["dancers"] == [1, 2, 3, 4, 5, 6]
    assert texts["ways"]["ways"] == whole["ways"][:3]
    assert "there is no segment 3" in asked(answers, segment=3)[0]["refused"]["refused"][0]["what"]


@pytest.mark.long
def test_a_segment_of_a_section_is_found_after_repeated_ones(tmp_path: Path) -> None:
    path = tmp_path / "show.toml"
    sections = "".join(
        f'[[section]]\nname = "{name}"\nmeasures = 4\nrepeat = {repeat}\n' for name, repeat in (("a", 3), ("b", 1))
    )
    path.write_text(
        TEXT.replace("[[segment]]", f'{sections}[[segment]]\nsection = "b"', 1).replace("measure = 8", "measure = 4")
    )
    answers = open_answers(load_show(path))
    found = [asked(answers, segment=number, positions="none")[0]["ways"] for number in (1, 2)]
    assert [(one["from"], one["to"]) for one in found] == [(14, 16), (4, 4)]


@pytest.mark.long
def test_measures_behind_a_section_that_waits_are_those_of_somebody_who_leads(tmp_path: Path) -> None:
    sections = """
[[section]]
name = "waiting"
measures = 2
wait = true
[[section]]
name = "verse"
measures = 4
repeat = 3
[[section]]
name = "last"
measures = 4
then = "verse"
"""
    path, plain = tmp_path / "show.toml", tmp_path / "plain.toml"
    path.write_text(TEXT + sections)
    once = sections.replace("wait = true\n", "").replace("repeat = 3\n", "").replace('then = "verse"\n', "")
    plain.write_text(TEXT + once)
    led, wanted = open_answers(load_show(path)), open_answers(load_show(plain))
    for question in ({"from_": 7, "to": 9}, {"measure": 8.5}, {"from_": 3, "to": 4, "positions": "samples"}):
        texts, frames = asked(led, led=True, **question)
        told, there = asked(wanted, **question)
        assert frames == there
        assert texts["moments"] == told["moments"]
    waiting = asked(led, from_=7, to=9)[1]
    assert waiting != asked(led, from_=7, to=9, led=True)[1]  # it still waits there
    edit = {
        "do": "insert",
        "at": ["segment"],
        "value": {"section": "last", "measure": 1, "measures": 2, "formation": "line"},
    }
    texts, frames = asked(led, from_=7, to=8, led=True, with_=[edit], positions="none", planned=True)
    told, there = asked(wanted, from_=7, to=8, with_=[edit], positions="none", planned=True)
    assert texts["ways"]["ways"] == told["ways"]["ways"]


@pytest.mark.long
def test_doubts_stand_at_their_measures(loaded: LoadedShow) -> None:
    answers = open_answers(loaded)
    far = {"do": "change", "at": ["segment", 2], "value": {"formation": None, "path": [[2.5, 0.0], [-5.0, 0.0]]}}
    texts, _ = asked(answers, from_=8, to=8, with_=[far])
    assert {one["measure"] for one in texts["notes"]["too_far"]} == {8}
    assert any(one["measure"] == 8 and "m to go" in one["what"] for one in texts["notes"]["notes"])
    texts, _ = asked(answers, positions="none", ways=False, with_=[far])
    assert any("m to go" in one["what"] for one in texts["notes"]["notes"])
    texts, _ = asked(answers, from_=1, to=2, with_=[far])
    assert not [one for one in texts["notes"]["notes"] if one["measure"] == 8]


@mostly_long(
    "question",
    [
        None, 7, "x", [], {}, {"from": 0}, {"from": 5, "to": 4}, {"from": 1, "to": 1 + MAX_RANGE}, {"from": 1e9},
        {"measure": float("nan")}, {"measure": 0.5}, {"measure": 10**9}, {"from": True}, {"from": "1"}, {"segment": 99},
        {"from": 1, "to": 2, "with": 5}, {"from": 1, "with": [{"do": "burn", "at": ["seed"]}]}, {"from": 1, "x": 2},
        {"from": 1, "with": [{}] * 201}, {"from": 1, "document": 99}, {"from": 1, "positions": "all"},
        {"measure": 2.0, "joints": ["x"]}, {"id": [], "from": 1}, {"id": "x" * 101, "from": 1},
    ], quick=[2],
)  # fmt: skip
def test_wrong_questions_are_refused_with_words(answers: PreviewAnswers, question: Any) -> None:
    (frame,) = answers.answer(question)
    told = json.loads(frame)
    assert told["kind"] == "refused"
    assert all(one["what"] for one in told["refused"])
    assert "done" in asked(answers, from_=1, id="a")[0]


@pytest.mark.long
def test_the_waveform_of_the_music(own: LoadedShow) -> None:
    texts, frames = asked(open_answers(own), id=1, waveform=True)
    assert (frames, texts["refused"]["refused"][0]["what"]) == ([], "this show has no music")
    sound = np.sin(np.arange(48_000) * 0.05).astype(np.float32)
    write_wav(own.path.parent / "tune.wav", sound, 48_000)
    own.path.write_text('music = {file = "tune.wav", bpm = 120}\n' + TEXT)
    answers = open_answers(load_show(own.path))
    texts, (frame,) = asked(answers, id=2, waveform=True)
    assert (frame[0], int.from_bytes(frame[2:4], "little"), int.from_bytes(frame[4:8], "little")) == (3, 200, 200)
    assert len(frame) == 8 + 200
    assert frame[8:].count(255) > 190
    assert texts["done"]["id"] == 2
    assert asked(answers, id=3, waveform=True)[1] == [frame]
