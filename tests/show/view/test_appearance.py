"""What dancers look like: drawn by seed and number, changed live for groups and single dancers, kept by a snapshot."""

from pathlib import Path

import numpy as np
import pytest

from live.base.body.appearance import BODY, BY_CHANCE, COSTUME, COSTUMES, HAIR, HAIRS, SHOES, SHOES_WORN, SKIN
from live.base.errors import PersonError
from live.base.picture_parameters import GROUP_PARAMETERS
from live.control.registry.registry import REGISTRY
from live.control.registry.rejections import Reason, Rejection
from live.show.desk.parameter_table import parse_value
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from live.show.state.snapshot import restore
from live.show.view.appearance import draw_appearances
from tests.show.desk.desk_show import DeskSession
from tests.show.made_show import GRAPH, PATCH
from tests.show.state.test_snapshot import capture_from

COSTUME_AT = "/dance/draw/costume"


def appearance(show):
    view = show.view()
    show.fill(view, show.time)
    return view.appearance.copy()


def test_dancers_have_default_costume_and_different_skins() -> None:
    rows = appearance(DeskSession().show)
    assert (rows[:, [BODY, HAIR, COSTUME, SHOES_WORN]] == [BY_CHANCE, 0, 0, 0]).all()
    assert len(np.unique(rows[:, SKIN])) > len(rows) // 2


def test_costume_of_some_dancers_changes_live_and_at_once() -> None:
    session = DeskSession().run(2)
    before = appearance(session.show)
    assert session.say(COSTUME_AT, "Dress + jacket", "1 + 2")
    rows = appearance(session.show)
    assert {COSTUMES[place] for place in rows[:2, COSTUME]} <= {"dress", "jacket"}
    np.testing.assert_array_equal(rows[2:], before[2:])
    np.testing.assert_array_equal(np.delete(rows, COSTUME, 1), np.delete(before, COSTUME, 1))


def test_unknown_costume_is_rejected_with_names() -> None:
    answer = REGISTRY.call(COSTUME_AT, ["armour"], 0.0, "osc")
    assert isinstance(answer, Rejection)
    assert answer.reason is Reason.FORM
    assert all(name in answer.expected for name in COSTUMES)
    with pytest.raises(PersonError, match="'armour' is none of leotard"):
        parse_value(COSTUME_AT, ["dress", "armour"])
    with pytest.raises(PatchError, match="'armour' is none of leotard"):
        DeskSession('[[scene]]\nname = "x"\nset = { "/dance/draw/costume" = "armour" }\n')


def test_scene_dresses_a_group() -> None:
    session = DeskSession('[[scene]]\nname = "x"\nset = { "/dance/draw/shoes front" = ["boots", "heels"] }\n').run(2)
    assert session.say("/dance/scene", "x")
    rows = appearance(session.show)
    front = session.show.group == 0
    assert {SHOES[place] for place in rows[front, SHOES_WORN]} == {"boots", "heels"}
    assert (rows[~front, SHOES_WORN] == 0).all()
    assert session.desk.scenes.written() == {"/dance/draw/shoes front": "heels + boots"}


def test_resumed_show_wears_the_same() -> None:
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
    show = loaded.start()
    for address, words, whom in ((COSTUME_AT, "skirt", "2"), ("/dance/draw/hair", "bob + curls + bald", "*")):
        assert show.apply(REGISTRY.call(address, [words, whom], 0.0, "osc"))
    _, data = capture_from(show, 70, {})
    rows = appearance(show)
    assert COSTUMES[rows[1, COSTUME]] == "skirt"
    np.testing.assert_array_equal(appearance(restore(loaded, data)), rows)


def test_names_are_drawn_evenly_and_stay_with_the_dancer() -> None:
    hairs = GROUP_PARAMETERS["/dance/draw/hair"]
    said = np.array([[1.0, 1.0, hairs.number_of_names("bob + long + braid"), 0.5, 1.0, 0.1, 0.2]])
    part = np.zeros(3000, np.int32)
    rows = draw_appearances(said, part, seed=4)
    counts = np.bincount(rows[:, HAIR], minlength=len(HAIRS))
    assert set(np.flatnonzero(counts)) == {HAIRS.index(name) for name in ("bob", "long", "braid")}
    assert counts[counts > 0].min() > 900  # 1000 each, with a deviation of 26
    np.testing.assert_array_equal(draw_appearances(said, part[:50], seed=4), rows[:50])
    assert (draw_appearances(said, part, seed=5) != rows).any()
    tones = rows[:, SKIN] / 255.0
    assert tones.min() >= 0.0
    assert tones.max() <= 1.0
    assert abs(np.median(tones) - 0.5) < 0.05


def test_patch_dresses_single_dancers_of_a_group() -> None:
    draw = 'draw = { costume = "trousers", "costume 2 + 3" = "jacket" }'
    text = PATCH.replace('name = "front"', f'name = "front"\n{draw}', 1)
    loaded = LoadedShow(Path("test.toml"), parse_patch(text, "test.toml"), GRAPH)
    show = loaded.start()
    worn = [COSTUMES[place] for place in appearance(show)[:, COSTUME]]
    assert worn[:5] == ["trousers", "jacket", "jacket", "trousers", "trousers"]
    assert set(worn[5:]) == {"leotard"}
    assert show.apply(REGISTRY.call(COSTUME_AT, ["bare"], 0.0, "osc"))
    assert show.apply(REGISTRY.call("/dance/scene", ["start", 0.0], 0.0, "osc"))
    assert [COSTUMES[place] for place in appearance(show)[:, COSTUME]] == worn
    with pytest.raises(PatchError, match="nobody"):
        parse_patch(text.replace("costume 2 + 3", "costume nobody"), "test.toml")
