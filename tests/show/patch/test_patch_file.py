"""Patch files: valid ones load, errors are reported with file, line, field and remedy."""

import pytest

from live import __version__
from live.show.patch import toml_model
from live.show.patch.patch_reader import parse_patch, read_patch
from live.show.patch.patch_search_path import DEFAULT_PATCH, PatchError, find_patch, find_resource, show_stem
from tests.show.made_show import PATCH


@pytest.mark.parametrize(
    ("line", "where", "words"),
    [
        ("tempo = 3", "line 2: tempo: unknown key", "allowed are name, seed"),
        ("hologram = 3", "line 2: hologram", f"version {__version__} of the program may be older than the patch"),
        ("[stage]\nwidht = 3", "line 3: stage.widht: unknown key", "did you mean 'width'?"),
        ("[stage]\nwidth = 1", "line 3: stage.width", "greater than or equal to 2, found 1"),
        ('[stage]\nwidth = "wide"', "line 3: stage.width", "found the text 'wide'"),
        ("[stage]\nwidth = nan", "line 3: stage.width", "found nan"),
        ("seed = -1", "line 2: seed", "found -1"),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]", "line 2: camera", "the camera looks nowhere"),
        ("[clock]\nmetres = [3, 12]", "line 3: clock.metres", "2 to 9 beats"),
        ("[clock]\nmetres = []", "line 3: clock.metres", "at least 1"),
        ("[clock]\nlikely_bpm = 300", "line 3: clock.likely_bpm", "less than or equal to 240"),
        ("[clock]\nbpm = 1000", "line 3: clock.bpm", "less than or equal to 400"),
        (
            '[[element]]\nkind = "explode"\nmeasure = 1',
            "line 3: element.1.kind",
            "'attract', 'repel', 'spread', 'cross'",
        ),
        ('[[element]]\nkind = "attract"', "line 2: element.1.measure", "missing"),
        ('[[element]]\nkind = "attract"\nmeasure = 1\nat = [1e30, 0]', "line 5: element.1.at", "found 1e+30"),
        ('[[group]]\nname = "b"\ndancers = 0\nsteps = ["a"]', "line 4: group.1.dancers", "found 0"),
        ('[[group]]\nname = "b"\ndancers = 2\nsteps = []', "line 2: group.1", "has nothing to dance"),
        ("[[segment]]\nmeasure = 1\npath = [[0, 0]]", "line 4: segment.1.path", "at least 2 expected, found 1"),
        ("[[segment]]\nmeasure = 1\nmirror = [[1, 1], [1, 1]]", "line 2: segment.1", "there is no line through them"),
        (
            '[[formation]]\nname = "a"\n[[formation]]\nname = "A"',
            "line 5: formation.2.name",
            "two formations are called 'A'",
        ),
        ("segment = [3]", "line 2: segment.1", "a table expected, found 3"),
        ('[[group]]\nname = "b"\ndancers = 2\nsteps = [" "]', "line 5: group.1.steps", "is no step"),
        ('[[group]]\nname = "b"\ndancers = 2\nsteps = ["a x0"]', "line 5: group.1.steps", "'a x0' is no step"),
        ("name 3", "line 2: not valid TOML", "a line is key = value"),
        ("[stage]\n[stage]", "line 3: not valid TOML", "write [[stage]] each time where there may be several"),
        ('[cue]\nname = "a"', "line 2: cue", "write [[cue]] each time"),
        ("[[stage]]\nwidth = 9", "line 2: stage", "there is one: write [stage]"),
        ('[stage]\nwidth = "9,5"', "line 3: stage.width", "found the text '9,5'; write the number without quotes"),
        (
            '[[cue]]\nname = "a"\ncalls = [["/dance/spread", "2"]]',
            "line 4: cue.1.calls.1",
            'received the text "2"; write the number without quotes',
        ),
        (
            '[[cue]]\nname = "a"\ncalls = [["/dance/step", 2]]',
            "line 4: cue.1.calls.1",
            "the number 2; write a text in quotes",
        ),
        ('[[cue]]\nname = "a"\ncalls = [["/dance/spread", true]]', "line 4: cue.1.calls.1", "received the switch true"),
        ("[camera]\neye = [1e200, 0, 0]", "line 3: camera.eye.1", "less than or equal to 1000"),
        (
            'loop_measures = 2\n[[element]]\nkind = "spread"\nmeasure = 3',
            "line 5: element.1.measure",
            "it would never begin",
        ),
        ("[look]\nfloor = [2.0, 0, 0]", "line 3: look.floor.1", "less than or equal to 1"),
    ],
)
def test_invalid_field_is_reported_with_its_line(line, where, words):
    group = "" if "[[group]]" in line else '\n[[group]]\nname = "a"\ndancers = 1\nsteps = ["sway"]\n'
    with pytest.raises(PatchError) as error:
        parse_patch(f'name = "x"\n{line}\n{group}', "my.toml")
    message = str(error.value)
    assert f"my.toml, {where}" in message
    assert words in message
    assert "\n" not in message


def test_all_problems_are_reported_at_once():
    with pytest.raises(PatchError) as error:
        parse_patch('seed = "x"\n[stage]\nwidth = 0\ndepth = 0\n', "p")
    for field in ("name", "seed", "stage.width", "stage.depth", "group"):
        assert f": {field}: " in str(error.value)


def test_groups_with_the_same_name_are_refused():
    with pytest.raises(PatchError, match="two groups are called 'front'"):
        parse_patch(PATCH.replace('"back"', '"front"'), "p")


def test_patch_has_written_values_and_defaults():
    patch = parse_patch(PATCH, "p")
    assert patch.dancer_count == 9
    assert patch.clock.bpm == 120
    assert patch.stage.width == 12
    assert patch.group[1].choose == "random"


def test_default_patch_is_valid_and_its_music_exists():
    patch = read_patch(DEFAULT_PATCH)
    assert find_resource(patch.music.file or "", DEFAULT_PATCH) is not None


def test_patches_are_found_by_path_folder_and_name(tmp_path):
    folder = tmp_path / "mine"
    folder.mkdir()
    (folder / "show.toml").write_text(PATCH)
    assert find_patch(str(folder)) == folder / "show.toml"
    assert find_patch("first_show") == DEFAULT_PATCH
    assert find_patch(None) == DEFAULT_PATCH
    with pytest.raises(PatchError, match=r"no patch 'nothing'.*first_show"):
        find_patch("nothing")


def test_deep_brackets_and_impossible_file_names_are_refused():
    with pytest.raises(PatchError, match="nested too deep"):
        parse_patch("a = " + "[" * 20_000, "p")
    for name in ("x" * 3000, "a\0b"):
        with pytest.raises(PatchError, match="there is no patch"):
            find_patch(name)


def test_binary_large_and_missing_files_are_refused(tmp_path):
    (tmp_path / "a.toml").write_bytes(b"name = \xff")
    with pytest.raises(PatchError, match="UTF-8"):
        read_patch(tmp_path / "a.toml")
    (tmp_path / "b.toml").write_bytes(b"#" * 4_000_001)
    with pytest.raises(PatchError, match="at most"):
        read_patch(tmp_path / "b.toml")
    with pytest.raises(PatchError, match="cannot read"):
        read_patch(tmp_path / "c.toml")


def test_remedies_are_searched_only_for_reported_problems(monkeypatch):
    asked = []
    monkeypatch.setattr(toml_model.difflib, "get_close_matches", lambda *words, **_: asked.append(words[0]) or [])
    with pytest.raises(PatchError, match="and 4994 more"):  # 5,000, name and group; of eight the words are here
        parse_patch("\n".join(f"k{number} = 1" for number in range(5000)), "test.toml")
    assert len(set(asked)) <= 8
    assert len(asked) <= 2 * 8  # in its own table, and in the others


@pytest.mark.parametrize(
    ("patch", "stem"),
    [
        (None, "first-show"),
        ("house", "house"),
        ("my shows/gala.toml", "gala"),
        ("a/night.of.5/show.toml", "night.of.5"),
    ],
)
def test_files_made_from_a_show_have_its_name(patch, stem):
    assert show_stem(patch) == stem
