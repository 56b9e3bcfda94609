"""What each edit does to a text, and why one is refused."""

from pathlib import Path
from typing import Any

import pytest

from live.base.errors import PersonError
from live.document.document import Document
from live.document.edit import Edit, EditRefused, parse_edit, parse_edits
from live.document.edit_actions import apply_edit, apply_edits

TEXT = """name = "x"
seed = 3
reserve = 6

[selections]
pair = "ember & 1-2"

[[group]]
name = "ember"
dancers = 4
steps = ["groove x2", "turn"]
facing = "group tide"

[[group]]
name = "tide"
dancers = 4
like = "ember"

[[section]]
name = "verse"
measures = 64
then = "verse"

[[segment]]
measure = 1
measures = 4
formation = "circle"

# The second one of the verse.
[[segment]]
section = "verse"
measure = 3
measures = 2  # short
group = "ember & left + pair"
formation = "line"

[[scene]]
name = "dusk"
set = { "/dance/motion/larger ember" = 0.5, "/dance/draw/ink ember & pair" = 1.0, "/dance/look" = "warm" }

[[looks]]
name = "warm"
draw = { "ink ember - 1" = 1.0, "solid pair" = 0.5 }

[[sequence]]
section = "verse"
group = "pair - ember + 2"
measure = 9
steps = ["jump"]

[[at]]
section = "verse"
measure = 2
call = "/dance/spread"
values = [2, "ember - 1"]

[[pad]]
name = "evening"
does = "scene dusk"

[[cue]]
name = "one"
scene = "dusk"
section = "verse"
calls = [["/dance/step", "jump", 1, "ember"], ["/dance/facing", "ember"]]

[[midi.map]]
note = 36
control = "/dance/step"
values = { name = "jump", group = "ember" }
"""


@pytest.fixture
def document(tmp_path: Path) -> Document:
    return Document([("show.toml", TEXT)], path=tmp_path / "show.toml")


def text(document: Document) -> str:
    return document.files[0].text


def edit(document: Document, do: str, *at: str | int, value: Any = None) -> str:
    """Apply an edit, check that its inverse gives the patch back, apply it again, and return the text."""
    former = document.patch
    applied = apply_edit(document, Edit(do, at, value))
    assert applied.inverse is not None
    apply_edit(document, applied.inverse)
    assert document.patch == former
    apply_edit(document, Edit(do, at, value))
    return text(document)


def test_set_changes_one_line(document: Document) -> None:
    assert edit(document, "set", "seed", value=7) == TEXT.replace("seed = 3", "seed = 7")


def test_null_removes_a_key(document: Document) -> None:
    assert edit(document, "set", "reserve") == TEXT.replace("reserve = 6\n", "")


def test_a_key_of_a_missing_table_makes_it(document: Document) -> None:
    edit(document, "set", "stage", "width", value=9.5)
    assert document.patch.stage.width == 9.5
    assert "\n[stage]\nwidth = 9.5\n" in text(document)


def test_an_entry_is_found_by_name_by_number_and_in_its_section(document: Document) -> None:
    paths: list[tuple[str | int, ...]] = [("segment", 2), ("section", "verse", "segment", 1)]
    for at in (*paths, ("section", 1, "segment", "1")):
        assert apply_edit(document, Edit("set", (*at, "measures"), 3)).keys == [("segment", 1, "measures")]
        assert text(document) == TEXT.replace("measures = 2  # short", "measures = 3  # short")
        apply_edit(document, Edit("set", (*at, "measures"), 2))
    edit(document, "change", "group", "TIDE", value={"dancers": 5, "colour": [1, 0, 0]})
    assert (document.patch.group[1].dancers, document.patch.group[1].colour) == (5, (1, 0, 0))


def test_elements_of_lists_count_from_1(document: Document) -> None:
    assert edit(document, "set", "group", "ember", "steps", 2, value="bow") == TEXT.replace('"turn"', '"bow"')
    edit(document, "insert", "group", "ember", "steps", 2, value="kick")
    assert document.patch.group[0].steps == ("groove x2", "kick", "bow")
    edit(document, "delete", "group", "ember", "steps", 1)
    assert document.patch.group[0].steps == ("kick", "bow")


def test_insert_keeps_the_order_of_the_file(document: Document) -> None:
    edit(document, "insert", "segment", value={"measure": 9, "measures": 1})
    assert [each.measure for each in document.patch.segment] == [1, 3, 9]
    edit(document, "insert", "segment", 1, value={"measure": 20, "measures": 1})
    assert [each.measure for each in document.patch.segment] == [20, 1, 3, 9]
    edit(document, "insert", "section", "verse", "segment", value={"measure": 5, "measures": 2})
    assert [(each.section, each.measure) for each in document.patch.segment][2:] == [
        ("verse", 3),
        ("verse", 5),
        (None, 9),
    ]
    edit(document, "insert", "signal", value={"name": "hit", "measure": 2})  # the first of its kind
    assert document.patch.signal[0].name == "hit"


def test_delete_leaves_the_comments_of_others(document: Document) -> None:
    end = TEXT.index("[[segment]]")
    second = TEXT.index("# The second one")
    assert edit(document, "delete", "segment", 1) == TEXT[:end] + TEXT[second:]


def test_move_changes_the_measure_or_the_place_in_the_list(document: Document) -> None:
    edit(document, "move", "segment", 1, value=17)
    assert [each.measure for each in document.patch.segment] == [17, 3]
    edit(document, "move", "segment", 2, value={"section": None, "measure": 30})
    assert [(each.section, each.measure) for each in document.patch.segment] == [(None, 17), (None, 30)]
    apply_edit(document, Edit("change", ("group", "tide"), {"like": None, "steps": ["turn"]}))
    edit(document, "move", "group", "tide", value=1)
    assert [group.name for group in document.patch.group] == ["tide", "ember"]
    edit(document, "move", "segment", 2, value={"number": 1})
    assert [each.measure for each in document.patch.segment] == [30, 17]


def test_resize_changes_how_long_it_is(document: Document) -> None:
    assert edit(document, "resize", "segment", 2, value=5) == TEXT.replace(
        "measures = 2  # short", "measures = 5  # short"
    )
    edit(document, "resize", "group", "ember", value={"size": [3, 4]})
    assert document.patch.group[0].size == (3, 4)
    edit(document, "resize", "stage", value={"width": 14})
    assert document.patch.stage.width == 14


def test_copy_stands_behind_and_gets_a_free_name(document: Document) -> None:
    edit(document, "copy", "segment", 2, value=6)
    assert [each.measure for each in document.patch.segment] == [1, 3, 6]
    assert text(document).count("# short") == 2
    assert text(document).count("# The second one") == 1
    edit(document, "copy", "scene", "dusk")
    edit(document, "copy", "scene", "dusk 2")
    edit(document, "copy", "cue", "one", value="another")
    assert [scene.name for scene in document.patch.scene] == ["dusk", "dusk 2", "dusk 3"]
    assert [cue.name for cue in document.patch.cue] == ["one", "another"]


@pytest.mark.parametrize("old", ["ember", "verse", "dusk", "warm", "pair"])
def test_rename_reaches_every_use(document: Document, old: str) -> None:
    """The text with the word replaced everywhere is what a careful person would write."""
    kind = {"ember": "group", "verse": "section", "dusk": "scene", "warm": "looks", "pair": "selections"}[old]
    expected = TEXT.replace(old, "glow").replace("one of the glow", "one of the verse")  # but for the comment
    assert edit(document, "rename", kind, old, value="glow") == expected


def test_a_name_with_blanks_is_found_where_it_stands_alone(document: Document) -> None:
    edit(document, "rename", "section", "verse", value="verse one")
    assert document.patch.cue[0].section == "verse one"


@pytest.mark.parametrize(
    ("do", "at", "value", "words"),
    [
        ("set", ("segment", 7, "measures"), 3, "there is no segment 7 (there are 2)"),
        ("set", ("group", "mist", "dancers"), 3, "no group is called 'mist' (there are: ember, tide)"),
        ("set", ("segment",), 3, "this is a list of tables (say which"),
        ("set", ("segment", 2, "measures"), 0, "greater than or equal to 1"),
        ("set", ("segment", 2, "mesures"), 4, "unknown key (did you mean 'measures'?"),
        ("set", ("stage",), 4, "a table expected, found 4"),
        ("set", ("seed",), {"a": 1}, "integer"),
        ("set", ("name",), None, "missing (it must be given)"),
        ("delete", ("group", "ember"), None, "no other group is called that"),
        ("delete", ("segment", 1, "colour"), None, "there is no such key"),
        ("insert", ("segment",), {"measures": 2}, "missing"),
        ("insert", ("segment", 9), {"measure": 2}, "it cannot be number 9 (there are 2)"),
        ("insert", ("seed",), 4, "it is there already (change it)"),
        ("insert", ("segment",), 7, "a table of the entry's keys expected"),
        ("move", ("seed",), 4, "only an entry of a list can be moved"),
        ("move", ("segment", 1), {"group": "ember"}, "allowed are measure, section"),
        ("move", ("group", 1), 5, "its new number expected, 1 to 2"),
        ("resize", ("cue", "one"), {"name": "two"}, "allowed are measures"),
        ("resize", ("seed",), 2, "allowed are none here"),
        ("copy", ("seed",), None, "only an entry of a list can be copied"),
        ("rename", ("segment", 1), "x", "only an entry with a name can be renamed"),
        ("rename", ("group", "ember"), "tide", "two groups are called 'tide'"),
        ("rename", ("group", "ember"), "", "a name expected"),
        ("rename", ("selections", "trio"), "x", "no selection is called 'trio'"),
        ("change", ("group", "ember"), {"dancers": -1}, "greater than or equal to 1"),
        ("set", ("group", 1, "steps", 9), "x", "cannot be written there"),
    ],
)  # fmt: skip
def test_a_refusal_says_why_and_changes_nothing(
    document: Document, do: str, at: tuple[str | int, ...], value: Any, words: str
) -> None:
    former = document.patch
    with pytest.raises(EditRefused) as caught:
        apply_edit(document, Edit(do, at, value))
    assert words in str(caught.value)
    assert text(document) == TEXT
    assert document.patch is former


def test_a_refusal_names_all_faults_with_file_line_field_and_measure(document: Document) -> None:
    changes = {"measures": 0, "match": "none", "measure": 7}
    with pytest.raises(EditRefused) as caught:
        apply_edit(document, Edit("change", ("segment", 2), changes))
    faults = {fault.field: fault for fault in caught.value.faults}
    assert set(faults) == {"segment.2.measures", "segment.2.match"}
    one = faults["segment.2.measures"]
    assert one.file.endswith("show.toml")
    assert one.line is not None
    assert TEXT.split("\n")[one.line - 1].startswith("measures = 2")
    assert (one.measure, one.dancers) == (7.0, "ember & left + pair")


def test_a_refusal_counts_lines_and_entries_of_the_files_as_they_are(document: Document) -> None:
    """The new entry has no line; segment 2 of the file is named so, though it would become the third."""
    new = {"measure": 1, "measures": 0, "formation": "no such formation", "hold": True}
    with pytest.raises(EditRefused) as caught:
        apply_edits(document, [Edit("insert", ("segment", 1), new), Edit("set", ("segment", 3, "measures"), 0)])
    faults = {fault.field: fault.line for fault in caught.value.faults}
    assert faults.pop("segment.1.measures") is None
    ((field, line),) = faults.items()
    assert field == "segment.2.measures"
    assert line is not None
    assert TEXT.split("\n")[line - 1].startswith("measures = 2")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ([], "object"), ({"do": "set"}, "at"), ({"do": "burn", "at": ["seed"]}, "allowed are insert, change"),
        ({"do": "set", "at": []}, "at"), ({"do": "set", "at": [0]}, "at"), ({"do": "set", "at": [1.5]}, "at"),
        ({"do": "set", "at": ["seed"], "valeu": 3}, "valeu: unknown key"),
        ({"do": "set", "at": ["seed"], "value": float("nan")}, "finite"),
        ({"do": "set", "at": ["seed"], "value": 1 << 70}, "too many digits"),
        ({"do": "set", "at": ["name"], "value": "\ud800"}, "UTF-8"),
        ({"do": "set", "at": ["name"], "value": [None, [None]]}, "null"),
        ({"do": "set", "at": ["seed"], "base": -1}, "base"),
    ],
)  # fmt: skip
def test_malformed_edits_are_refused(values: object, words: str) -> None:
    with pytest.raises(PersonError) as caught:
        parse_edit(values)
    assert words in str(caught.value)


def test_a_list_of_edits_names_the_malformed_one() -> None:
    assert parse_edits("[]", "edits") == []
    with pytest.raises(PersonError, match=r"e\.json: edit 2: do: "):
        parse_edits('[{"do": "set", "at": ["seed"], "value": 1}, {"do": "no", "at": ["seed"]}]', "e.json")
    for broken in ("", "{}", "[", "[" * 100_000):
        with pytest.raises(PersonError, match=r"e\.json: "):
            parse_edits(broken, "e.json")
