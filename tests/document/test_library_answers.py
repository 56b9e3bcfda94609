"""Answers of the preview about steps, formations and ways into them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.document.preview_answers import PreviewAnswers, open_answers
from live.document.step_answers import feet_of, motion_frames, sequence_values, step_values, turn_of
from live.graph.motion_graph import MotionGraph, build_graph
from live.show.loader import load_show
from tests.document.test_preview import TEXT
from tests.document.test_preview_answers import asked

TABLES = '[[formation]]\nname = "gate"\nshape = "arc"\nsize = [30.0, 20.0]\n'


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> PreviewAnswers:
    path = tmp_path_factory.mktemp("show") / "show.toml"
    path.write_text(TEXT + TABLES)
    return open_answers(load_show(path))


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> MotionGraph:
    """The project's steps, of which few may follow one another."""
    path: Path = tmp_path_factory.mktemp("strict") / "show.toml"
    path.write_text(TEXT)
    return build_graph(load_show(path).graph.library, threshold=0.02, prune=False)


@pytest.mark.long
def test_steps_have_their_length_feet_turn_and_followers(answers: PreviewAnswers) -> None:
    texts, frames = asked(answers, id="a", steps=True)
    rows = {row["name"]: row for row in texts["steps"]["steps"]}
    assert not frames
    assert rows["mambo"]["measures"] == 2
    assert rows["turn"]["turn_deg"] == 360
    assert (rows["kick"]["begin_foot"], rows["kick"]["end_foot"]) == ("left", "right")
    assert len({take["direction"] for take in rows["walk"]["takes"]}) == 9
    assert "turn" in rows["walk"]["follows"]
    assert "walk" in rows["turn"]["precedes"]
    assert texts["done"]["id"] == "a"


def test_followers_are_those_of_the_graph(graph: MotionGraph) -> None:
    library = graph.library
    rows = step_values(graph)
    pairs = {(row["name"], name) for row in rows for name in row["follows"]}
    assert pairs == {(name, row["name"]) for row in rows for name in row["precedes"]}
    wanted = set()
    for u in range(library.node_count):
        for v in graph.edge_target[graph.edge_start[u] : graph.edge_start[u + 1]].tolist():
            if library.node_measure[v] == 0 and library.node_measure[u] == library.node_measures[u] - 1:
                wanted.add((library.steps[library.node_step[u]], library.steps[library.node_step[v]]))
    assert pairs == wanted
    assert len(wanted) < len(rows) ** 2


@pytest.mark.long
def test_motion_is_the_step_from_line_to_line(answers: PreviewAnswers) -> None:
    texts, frames = asked(answers, step="Side_Step", takes=[1, 3])
    motion = texts["motion"]
    assert motion["step"] == "side step"
    assert [take["number"] for take in motion["takes"]] == [1, 3]
    take = motion["takes"][0]
    assert len(take["contact"]) == take["samples_per_beat"] * 4 * take["measures"] + 1
    for frame in frames:
        joints = np.frombuffer(frame[8:], "<i2").reshape(-1, 22, 3)
        assert len(joints) == len(take["contact"])
        assert joints[0, 0, 0] == joints[0, 0, 2] == 0
        assert 700 < joints[:, 0, 1].mean() < 1000


@pytest.mark.parametrize("words", ["nothing", "walk"])
def test_unknown_steps_and_takes_are_refused(graph: MotionGraph, words: str) -> None:
    with pytest.raises(PersonError, match=r"no (step|take)|has no take"):
        list(motion_frames(graph, words, [99]))


def test_feet_and_turn_of_clips(graph: MotionGraph) -> None:
    clips = [clip for clip in graph.library.clips if clip.step == "kick"]
    assert {feet_of(clip) for clip in clips} == {("left", "right"), ("right", "left")}
    assert abs(turn_of(next(clip for clip in graph.library.clips if clip.step == "turn"))) == pytest.approx(
        6.283, abs=0.1
    )


def test_a_sequence_says_what_to_record_and_why(graph: MotionGraph, answers: PreviewAnswers) -> None:
    rows = step_values(graph)
    first, second = next(
        (row["name"], other["name"]) for row in rows for other in rows if other["name"] not in row["follows"]
    )
    told = sequence_values(graph, f"{first}, {second}")
    (missing,) = told["missing"]
    assert (missing["from"], missing["to"]) == (first, second)
    assert missing["measure"] == 1 + next(row["measures"] for row in rows if row["name"] == first)
    assert "record one" in missing["needs"]
    assert all(gap > 0.1 for _, gap in missing["joints"])
    fits = asked(answers, sequence="groove x2, turn, *")[0]["sequence"]
    assert (fits["measures"], fits["missing"]) == (4, [])
    assert fits["steps"] == ["groove", "groove", "turn", None]


@pytest.mark.long
def test_feet_that_do_not_fit_are_named(graph: MotionGraph) -> None:
    rows = step_values(graph)
    words = [
        words
        for row in rows
        for other in rows
        if other["name"] not in row["follows"]
        for missing in sequence_values(graph, f"{row['name']}, {other['name']}")["missing"]
        for words in missing["because"]
    ]
    assert any("ends on the" in one for one in words) or any("apart from" in one for one in words)


def test_places_of_names_words_and_tables(answers: PreviewAnswers) -> None:
    wishes: list[dict[str, Any]] = [
        {"formation": "star:6", "dancers": 12},
        {"formation": "gate", "dancers": 5},
        {"formation": {"shape": "circle", "size": [3.0, 3.0], "pattern": "poisson"}, "dancers": 20},
        {"formation": "no such shape", "dancers": 3},
        {"formation": {"shape": "line", "size": [3.0, "x"]}, "dancers": 3},
        {"formation": {"shape": {}, "x": []}, "dancers": 3},
    ]
    star, gate, circle, *wrong = asked(answers, places=wishes)[0]["places"]["places"]
    assert len(star["slots"]) == 12
    assert star["fits"]
    assert not gate["fits"]
    assert "times as large" in gate["remedy"]
    assert len(circle["slots"]) == 20
    assert circle["warnings"]
    assert all(one["refused"][0]["what"] for one in wrong)


@pytest.mark.long
def test_options_of_a_segment_are_compared(answers: PreviewAnswers) -> None:
    options = [{"match": match} for match in ("squared", "shortest", "bottleneck", "number")]
    told = asked(answers, segment=1, options=[*options, {"way": "straight", "facing": "declared"}])[0]["options"]
    assert told["dancers"] == [1, 2, 3]
    assert (told["from"], told["to"], told["formation"]) == (2, 4, "line")
    *found, refused = told["options"]
    assert "heading" in refused["refused"][0]["what"]
    by = {one["option"]["match"]: one for one in found}
    assert by["shortest"]["total_m"] <= min(one["total_m"] for one in found) + 0.02
    assert by["bottleneck"]["longest_m"] <= min(one["longest_m"] for one in found) + 0.02
    ways = np.array(by["squared"]["ways"])
    assert ways.shape == (3, 3 * 8 + 1, 2)
    line = asked(answers, places=[{"formation": "line", "dancers": 3}])[0]["places"]["places"][0]["slots"]
    ends = ways[:, -1]
    assert np.abs(ends[ends[:, 0].argsort()] - sorted(line)).max() < 0.01


@pytest.mark.long
def test_options_of_a_segment_that_is_only_tried(answers: PreviewAnswers) -> None:
    value: dict[str, Any] = {"measure": 5, "measures": 3, "group": "tide", "formation": "star"}
    tried: dict[str, Any] = {"do": "insert", "at": ["segment"], "value": value}
    told = asked(answers, segment=3, options=[{}], with_=[tried])[0]["options"]
    assert (told["from"], told["to"], told["dancers"]) == (5, 7, [4, 5, 6])
    refused = asked(answers, segment=3, options=[{}], with_=[tried | {"value": value | {"formation": "nothing"}}])[0]
    assert "nothing" in refused["refused"]["refused"][0]["what"]


@pytest.mark.parametrize(
    "question",
    [
        {"steps": "yes"}, {"step": 5}, {"step": "x" * 101}, {"step": "walk", "takes": [0]},
        {"step": "walk", "takes": [9999]}, {"step": "walk", "takes": [1] * 5}, {"sequence": ""},
        {"sequence": "nothing"}, {"sequence": "groove x65"}, {"sequence": "x" * 2001},
        {"places": [{"formation": "line"}]}, {"places": [{"formation": "line", "dancers": 401}]},
        {"places": [{"formation": 5, "dancers": 4}]}, {"places": [{"formation": "line", "dancers": 3}] * 65},
        {"options": [{}]}, {"segment": 1, "options": [{"match": "love"}]}, {"segment": 9, "options": [{}]},
        {"segment": 1, "options": [{}] * 17}, {"segment": 1, "options": [{"headings_deg": [float("nan")]}]},
    ],
)  # fmt: skip
def test_wrong_questions_are_refused_with_words(answers: PreviewAnswers, question: dict[str, Any]) -> None:
    (frame,) = answers.answer(question)
    told = json.loads(frame)
    assert told["kind"] == "refused"
    assert all(one["what"] for one in told["refused"])


@pytest.mark.long
def test_what_could_follow_an_element(tmp_path: Path) -> None:
    element = '[[element]]\nkind = "cross"\nmeasure = 3\nmeasures = 3\nat = [0.0, -3.5]\nto = [0.0, 3.5]\n'
    path = tmp_path / "show.toml"
    path.write_text(TEXT + TABLES + element)
    mine = open_answers(load_show(path))
    number = len(mine._store.document.patch.element)
    texts, _ = asked(mine, id=1, element=number)
    told = texts["next"]
    assert (told["element"], told["after"]) == (number, 6)
    assert 1 <= len(told["formations"]) <= 4
    for one in told["formations"]:
        assert one["segment"] == {"measure": 6, "measures": one["measures"], "formation": one["formation"]}
        insert = {"do": "insert", "at": ["segment"], "value": one["segment"]}
        followed, _ = asked(mine, id=2, element=number, **{"with": [insert]})
        assert (followed["next"]["formations"], followed["next"]["quiet"]) == ([], 0.0)
    assert asked(mine, id=3, element=number)[0]["next"]["formations"] == told["formations"]
    texts, _ = asked(mine, id=4, element=99)
    assert "there is no element 99" in texts["refused"]["refused"][0]["what"]
