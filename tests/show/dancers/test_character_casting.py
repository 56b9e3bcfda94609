"""Tests of `[[character]]`: assignment of characters to dancers, and errors with their line before a show."""

import pytest

from live.base.body.catalogue import DEFAULT_BODY
from live.base.errors import PersonError
from live.show.dancers.character_casting import bodies_of, character_files, check_characters, drawable_characters
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from live.show.patch.patch_update import split_deferred
from live.show.view.render_scene import make_scene
from tests.render.characters.figures import glb_of
from tests.show.made_show import PATCH

BEGIN = PATCH.partition("[[group]]")[0]
GROUPS = """
[[group]]
name = "ember"
dancers = 40
steps = ["groove"]
[[group]]
name = "tide"
dancers = 5
steps = ["groove"]
"""
ANNA = '[[character]]\nname = "anna"\nfile = "characters/anna.glb"\n'


def patch(text):
    return parse_patch(BEGIN + GROUPS + text, "a.toml")


def test_characters_are_assigned_by_seed_within_groups_or_by_number():
    assert bodies_of(patch("")) == ()
    said = ANNA + 'groups = ["Ember"]\ndancers = [43]\n'
    both = patch(said + ANNA.replace("anna", "ben") + 'groups = ["ember"]\n')
    bodies = bodies_of(both)
    assert set(bodies[:40]) == {"anna", "ben"}
    assert 8 < bodies[:40].count("ben") < 32
    assert bodies[40:45] == (DEFAULT_BODY, DEFAULT_BODY, "anna", DEFAULT_BODY, DEFAULT_BODY)
    assert len(bodies) == 45 + both.reserve  # including the reserve
    assert bodies == bodies_of(both) != bodies_of(both.model_copy(update={"seed": 5}))
    assert set(bodies_of(patch(ANNA))) == {"anna"}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (ANNA + 'groups = ["embers"]', "no group is called 'embers'"),
        (ANNA + "dancers = [46]", "no dancer 46"),
        (ANNA.replace('"anna"', '"slim"'), "'slim' is a body"),
        (ANNA + 'joints = { hip = "a" }', "'hip' is no joint"),
        (ANNA + ANNA, "two characters are called 'anna'"),
        (ANNA + "[character.materials.Hat]\nhiden = true", "hiden"),
    ],
)
def test_invalid_characters_are_refused_with_line(text, words):
    with pytest.raises(PatchError, match=words) as refused:
        patch(text)
    assert "a.toml, line" in str(refused.value)


def test_files_are_checked_before_show_and_changes_are_deferred(tmp_path):
    path, said = tmp_path / "show.toml", patch(ANNA)
    with pytest.raises(PersonError, match=r"no file 'characters/anna\.glb'"):
        character_files(said, path)
    folder = tmp_path / "characters"
    folder.mkdir()
    (folder / "anna.glb").write_bytes(b"glTF and no more")
    with pytest.raises(PersonError, match=r"anna\.glb") as refused:
        check_characters(said, path)
    assert refused.value.key_path == ("character", 0, "file")
    assert drawable_characters(said, path) == ()  # an engine that goes on draws the usual body
    assert set(make_scene(said, None, drawable_characters(said, path)).bodies) == {DEFAULT_BODY}
    (folder / "anna.glb").write_bytes(glb_of())
    check_characters(said, path)
    scene = make_scene(said, None, character_files(said, path))
    assert scene.characters[0].path == str(folder / "anna.glb")
    assert set(scene.bodies) == {"anna"}
    assert split_deferred(patch(""), said) == (with_characters(said), ("character",))
    outside = said.model_copy(update={"character": (said.character[0].model_copy(update={"file": "../anna.glb"}),)})
    (tmp_path.parent / "anna.glb").write_bytes(b"")
    with pytest.raises(PersonError, match="outside"):
        character_files(outside, path)


def with_characters(said):
    """The running patch with the characters of another: deferred sections stay as before."""
    return patch("").model_copy(update={"character": said.character})
