"""Patch folders: files are merged in the order of their names, and errors refer to the right file."""

import pytest

from live.base.errors import PersonError
from live.show.loader import load_show
from live.show.patch.patch_reader import MAX_FILES, MAX_PATCH_BYTES, read_patch
from live.show.patch.patch_search_path import PatchError
from live.show.patch.toml_model import TomlSources, parse_text

MAIN = """name = "folder"
[look]
haze = 0.1
[[group]]
name = "all"
dancers = 4
steps = ["groove"]
[[element]]
kind = "spread"
measure = 1
"""
RING = '[[formation]]\nname = "ring"\nshape = "circle"\n'


def write_folder(tmp_path, **files):
    """Writes a show of MAIN and `files`: text by name, folder and file name joined by two underscores."""
    (tmp_path / "show.toml").write_text(files.pop("main", MAIN))
    for name, text in files.items():
        path = tmp_path / f"{name.replace('__', '/')}.toml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    return tmp_path / "show.toml"


def test_tables_of_all_files_are_merged_in_name_order(tmp_path):
    path = write_folder(
        tmp_path,
        formations__b=RING.replace("ring", "late"),
        formations__a=RING,
        looks__night="[look]\nambient = 0.5\n",
        score__two='[[element]]\nkind = "wander"\nmeasure = 3\n[[segment]]\nmeasure = 2\nformation = "ring"\n',
        score__one='[[element]]\nkind = "flock"\nmeasure = 2\n',
    )
    (tmp_path / "score" / "notes.txt").write_text("not a patch")
    (tmp_path / "score" / ".hidden.toml").write_text("= =")
    patch = read_patch(path)
    assert [table["name"] for table in patch.formation] == ["ring", "late"]
    assert [element.kind for element in patch.element] == ["spread", "flock", "wander"]
    assert (patch.look.haze, patch.look.ambient) == (0.1, 0.5)
    assert patch.segment[0].formation == "ring"


def test_patch_file_with_another_name_is_not_merged(tmp_path):
    write_folder(tmp_path, score__one="[[element]]\nkind = 3\n")
    (tmp_path / "alone.toml").write_text(MAIN)
    assert len(read_patch(tmp_path / "alone.toml").element) == 1


@pytest.mark.parametrize(
    ("files", "where", "words"),
    [
        (
            {"score__one": '[[element]]\nkind = "flock"\nmeasure = 2\n\n[[element]]\nkind = "explode"\nmeasure = 2\n'},
            "score/one.toml, line 6: element.3.kind",
            "'attract'",
        ),
        ({"formations__a": RING, "formations__b": "\n" + RING}, "formations/b.toml, line 3: formation.2.name", "two"),
        ({"looks__a": "[look]\nhaze = 0.2\n"}, "looks/a.toml, line 2: look.haze", "already given in"),
        ({"looks__a": 'name = "again"\n'}, "looks/a.toml, line 1: name", "show.toml, line 1"),
        ({"looks__a": "[element]\nmeasure = 2\n"}, "looks/a.toml, line 1: element", "show.toml, line 8"),
        ({"looks__a": "[look]\nambient = 2\n"}, "looks/a.toml, line 2: look.ambient", "less than or equal to 1"),
        ({"score__a": "[[element]\n"}, "score/a.toml, line 1: not valid TOML", ""),
        ({"score__a": "\n\n[[elemint]]\n"}, "score/a.toml, line 3: elemint", "did you mean 'element'?"),
        ({"score__a": '[[regroup]]\nmeasure = 2\ndancers = "1"\ngroup = "x"\n'}, "score/a.toml, line 4", "no group is"),
    ],
)
def test_errors_are_reported_with_their_file_and_line(tmp_path, files, where, words):
    with pytest.raises(PatchError) as error:
        read_patch(write_folder(tmp_path, **files))
    assert f"{tmp_path}/{where}" in str(error.value)
    assert words in str(error.value)


def test_errors_at_show_start_have_file_and_line(tmp_path):
    cases = {
        '[[segment]]\nmeasure = 2\nformation = "rnig"\n': "score/a.toml, line 3: segment.1.formation",
        '\n[[element]]\nkind = "follow"\nmeasure = 2\nwhom = "99"\n': "score/a.toml, line 2: element.2",
        '[selections]\npair = "nobody"\n': "score/a.toml, line 2: selections.pair",
        '[[formation]]\nname = "odd"\nshape = "text"\n': "score/a.toml, line 1: formation.1",
    }
    for text, where in cases.items():
        with pytest.raises(PersonError) as error:
            load_show(write_folder(tmp_path, score__a=text)).start()
        assert f"{tmp_path}/{where}" in str(error.value)
    with pytest.raises(PersonError, match=r"show.toml, line 7: group.1.steps: group 'all': no step is called 'grove'"):
        load_show(write_folder(tmp_path, main=MAIN.replace("groove", "grove"), score__a="")).start()


def test_too_many_and_too_large_files_are_refused_unread(tmp_path):
    path = write_folder(tmp_path)
    (tmp_path / "score").mkdir()
    for number in range(MAX_FILES):
        (tmp_path / "score" / f"{number}.toml").write_text("")
    with pytest.raises(PatchError, match=f"at most {MAX_FILES}"):
        read_patch(path)
    for file in (tmp_path / "score").iterdir():
        file.unlink()
    with (tmp_path / "score" / "a.toml").open("wb") as file:
        file.truncate(50_000_000)  # it would not be TOML either: zero bytes
    with pytest.raises(PatchError, match=f"at most {MAX_PATCH_BYTES}"):
        read_patch(path)
    path.write_bytes(b"")
    with path.open("wb") as file:
        file.truncate(50_000_000)
    (tmp_path / "score" / "a.toml").unlink()
    with pytest.raises(PatchError, match="at most"):
        read_patch(path)


def test_key_locations_include_nested_tables():
    first = parse_text('[midi]\ndefaults = true\n[[midi.map]]\nnote = 1\ncontrol = "a"\n', "a", "patch")
    second = parse_text('\n[[group]]\nname = "x"\n[group.motion]\nhead = 1\n', "b", "patch")
    sources = TomlSources([first, second])
    assert sources.location(("midi", "map", 0, "control")) == ("a", 5)
    assert sources.location(("group", 0, "motion", "head")) == ("b", 5)
    assert sources.location(("group", 7)) == ("b", 2)
