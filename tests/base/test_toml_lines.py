"""Line numbers of TOML keys, against counted texts and against tomllib's keys."""

import tomllib
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.toml import KeyPath, error_line, line_of, toml_line_numbers

TEXT = '''# a show
title = "first"          # line 2
size = [
  1.0,                   # 4
  2.0,
]
text = """
several
lines"""

[look]                   # 11
floor = { colour = [0, 1], "a b" = 3 }
key.light = 1
"1&" = "down = [6]"

[[group]]                # 16
name = "one"
  [group.step]
  long = 1
[[group]]                # 20
name = 'two # not a comment'
[[group.cue]]            # 22
at = 1
[[group.cue]]
at = 2
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("title",), 2),
        (("size",), 3),
        (("size", 0), 4),
        (("size", 1), 5),
        (("text",), 7),
        (("look",), 11),
        (("look", "floor"), 12),
        (("look", "floor", "colour", 1), 12),
        (("look", "floor", "a b"), 12),
        (("look", "key", "light"), 13),
        (("look", "1&"), 14),
        (("group", 0), 16),
        (("group", 0, "name"), 17),
        (("group", 0, "step"), 18),
        (("group", 0, "step", "long"), 19),
        (("group", 1), 20),
        (("group", 1, "name"), 21),
        (("group", 1, "cue", 0, "at"), 23),
        (("group", 1, "cue", 1), 24),
        (("group", 1, "cue", 1, "at"), 25),
    ],
)
def test_every_key_has_its_line(path: KeyPath, line: int) -> None:
    assert toml_line_numbers(TEXT)[path] == line


def test_missing_key_has_the_line_of_its_parent() -> None:
    lines = toml_line_numbers(TEXT)
    assert line_of(lines, ("group", 1, "steps")) == 20
    assert line_of(lines, ("nowhere", "at", "all")) == 1


def paths_of(value: object, path: KeyPath = ()) -> set[KeyPath]:
    found: set[KeyPath] = {path} if path else set()
    if isinstance(value, dict):
        for key, inner in value.items():
            found |= paths_of(inner, (*path, key))
    if isinstance(value, list):
        for index, inner in enumerate(value):
            found |= paths_of(inner, (*path, index))
    return found


def test_line_numbers_cover_the_keys_of_tomllib() -> None:
    assert set(toml_line_numbers(TEXT)) == paths_of(tomllib.loads(TEXT))


words = st.text(st.sampled_from("ab c=\"[]{}#\\\n\t,'.&é"), max_size=8)
keys = st.text(st.sampled_from('ab .="#]\\&é'), min_size=1, max_size=5)
values = st.recursive(
    st.one_of(words, st.integers(-9, 9), st.booleans()),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(keys, inner, max_size=3)),
    max_leaves=6,
)


def quoted(text: str) -> str:
    for raw, escaped in (("\\", "\\\\"), ('"', '\\"'), ("\n", "\\n"), ("\t", "\\t")):
        text = text.replace(raw, escaped)
    return f'"{text}"'


def toml_value(value: Any) -> str:
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return "[\n" + "".join(f"{toml_value(inner)}, # [ = \n" for inner in value) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{quoted(key)} = {toml_value(inner)}" for key, inner in value.items()) + "}"
    return str(value)


@given(st.dictionaries(keys, values, max_size=4))
def test_every_document_is_scanned_to_its_end(table: dict[str, Any]) -> None:
    text, expected = "", {}
    for key, value in table.items():
        expected[(key,)] = text.count("\n") + 1
        text += f"{quoted(key)} = {toml_value(value)}\n\n"
    assert tomllib.loads(text) == table
    lines = toml_line_numbers(text)
    assert set(lines) == paths_of(table)
    assert {path: lines[path] for path in expected} == expected


@given(st.text(st.sampled_from("ab[]{}=\"'\n#,.\\ 1"), max_size=40))
def test_invalid_toml_raises_no_exception(text: str) -> None:
    assert all(line >= 1 for line in toml_line_numbers(text).values())


@pytest.mark.parametrize("text", ["a=[}", "a=[,]", "a={]", "a=[[}", "a=]", "a=[1}", "a={b=}", "a=[\n#}\n}"])
def test_mismatched_brackets_end_the_scan(text: str) -> None:
    assert toml_line_numbers(text)[("a",)] == 1


def test_syntax_error_has_its_line() -> None:
    text = "a = 1\nb = \nc = 2\n"
    with pytest.raises(tomllib.TOMLDecodeError) as caught:
        tomllib.loads(text)
    assert error_line(str(caught.value), text) == 2
