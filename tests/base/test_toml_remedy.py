"""Remedies for invalid TOML."""

import tomllib

import pytest

from live.base.toml import error_line, toml_remedy

BAD = [
    ("steps = folder", 'steps = "folder"', 'steps = "folder"'),
    ("wait = True", "write true", "wait = true"),
    ("name = “a”", "plain quotes", 'name = "a"'),
    ("low = .5", "0.5", "low = 0.5"),
    ("low =", "missing", "low = 1"),
    ('name = "a', "close the text with the quotes", 'name = "a"'),
    ('name = "a",', "nothing behind the value", 'name = "a"'),
    ("width = 9,5", "a point", "width = 9.5"),
    ('file = "C:\\music"', "write / or", 'file = "C:/music"'),
    ("values = [1, 2", "with ]", "values = [1, 2]"),
    ("set = {low = 1", "with }", "set = {low = 1}"),
    ('[[cue]\nname = "a"', "with ]]", '[[cue]]\nname = "a"'),
    ('[cue\nname = "a"', "with ]", '[cue]\nname = "a"'),
    ("count in = 4", "no blanks", "count_in = 4"),
    ("beats = 1\nbeats = 2", "leave one of them out", "beats = 1"),
    ('[cue]\nname = "a"\n[cue]\nname = "b"', "write [[cue]] each time", '[[cue]]\nname = "a"\n[[cue]]\nname = "b"'),
    ("= 3", "key = value", "a = 3"),
    ("from = 2026-02-30", "in quotes", 'from = "2026-02-30"'),
]


@pytest.mark.parametrize(("text", "remedy", "mended"), BAD)
def test_remedy_is_suggested_and_fixes_the_text(text, remedy, mended):
    with pytest.raises(tomllib.TOMLDecodeError) as caught:
        tomllib.loads(text)
    told = toml_remedy(str(caught.value), text, error_line(str(caught.value), text))
    assert remedy in told
    assert "\n" not in told
    tomllib.loads(mended)


def test_long_hostile_value_is_shortened():
    assert len(toml_remedy("Invalid value (at line 1, column 5)", "a = " + "x" * 10_000, 1)) < 200
