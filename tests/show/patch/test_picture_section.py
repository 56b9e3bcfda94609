"""`[picture]`: order and initial values of the passes, `/dance/pass`, and errors with their line."""

import pytest

from live.base.custom_pass import PASSES
from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from live.show.view.render_scene import make_scene
from tests.show.desk.desk_show import DeskSession
from tests.show.made_show import PATCH

INK = "/dance/pass/ink"


def test_picture_section_sets_passes_and_parameter_row():
    text = (
        PATCH
        + '[picture]\npasses = ["bloom", "shadow"]\n'
        + 'set = {"/dance/pass/ink/colour" = [1, 0, 0], "/dance/pass/ink" = 0.5}\n'
    )
    scene = make_scene(parse_patch(text, "a.toml"))
    assert scene.passes == ("bloom", "shadow")
    row = picture_row(scene)
    assert row[BY_ADDRESS[INK].first] == 0.5
    assert row[BY_ADDRESS["/dance/pass/ink/colour"].row_slice].tolist() == [1.0, 0.0, 0.0]
    assert make_scene(parse_patch(PATCH, "a.toml")).passes == PASSES


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('passes = ["blom"]', "no pass 'blom'"),
        ('passes = ["ink", "ink"]', "is there twice"),
        ('set = {"/dance/pass/inc" = 1}', "no parameter of the picture"),
        ('set = {"/dance/pass/ink" = 7}', "0 to 1"),
        ('set = {"/dance/pass/ink/colour" = 1}', "3 numbers"),
    ],
)
def test_invalid_picture_key_is_refused_with_its_line(line, words):
    with pytest.raises(PatchError, match=words) as refused:
        parse_patch(PATCH + f"[picture]\n{line}\n", "a.toml")
    assert str(len(PATCH.splitlines()) + 2) in str(refused.value)


def test_pass_is_faded_undone_and_stored_in_scenes():
    hands = DeskSession().run(4)
    hands.say("/dance/pass", "Ink", 1.0, 1)
    hands.run(2)
    assert hands.value(INK) == pytest.approx(0.5)
    hands.run(3)
    assert hands.value(INK) == 1.0
    hands.say("/dance/scene/store", "inked")
    hands.say("/dance/pass", "ink", 0)
    hands.run(1)
    assert hands.value(INK) == 0.0
    hands.say("/dance/scene", "inked", 0)
    hands.run(1)
    assert hands.value(INK) == 1.0
    hands.say("/dance/pass", "ink", 4)  # no more than there can be
    hands.run(1)
    assert hands.value(INK) == 1.0
    hands.say("/dance/undo")
    assert not hands.say("/dance/pass", "nothing", 1)
    hands.run(1)
    assert "no pass is called 'nothing'" in hands.words
