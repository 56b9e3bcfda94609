"""Appending a step to a TOML text: existing lines are kept, and the result reads back unchanged."""

import tomllib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.library.step_writer import append_step

NEW = {"file": "b.bvh", "name": "two", "bpm": 96.5, "first_beat_s": 1.0, "measures": 2, "tags": ["slow"]}

LIST = """# my library, 3 May
fps = 60   # true

[[step]]
file = "a.bvh"  # the good take
name = "one"

bpm = 120
first_beat_s = 0.5
# the end of it
"""
SINGLE = """# one dance
# in two lines

file = "a.bvh"   # the good take
name = "one"
bpm = 120
first_beat_s = 0.5
"""


def lines_of(text: str) -> list[str]:
    return [line for line in text.splitlines() if line.strip()]


def test_new_file_is_written_in_plain_layout() -> None:
    assert append_step("", NEW, {"bpm": "guess: confirm"}) == (
        '[[step]]\nfile = "b.bvh"\nname = "two"\nbpm = 96.5 # guess: confirm\nfirst_beat_s = 1\nmeasures = 2\n'
        'tags = ["slow"]\n'
    )


def test_step_is_appended_and_every_line_is_kept() -> None:
    text = append_step(LIST, NEW | {"fps": 60})
    assert text is not None
    assert text.startswith(LIST.rstrip("\n"))
    steps = tomllib.loads(text)["step"]
    assert steps[0] == tomllib.loads(LIST)["step"][0]
    assert steps[1] == NEW  # the file's default already says fps
    assert '\n\n[[step]]\nfile = "b.bvh"' in text


def test_top_level_recording_becomes_first_of_two() -> None:
    text = append_step(SINGLE, NEW)
    assert text is not None
    assert tomllib.loads(text)["step"] == [tomllib.loads(SINGLE), NEW]
    assert lines_of(text)[: len(lines_of(SINGLE)) + 1] == [
        *lines_of(SINGLE)[:2], "[[step]]", *lines_of(SINGLE)[2:],
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("drop_frames = 6\nmirror = true\n", {"drop_frames": 0, "mirror": False}),
        ('tags = ["x"]\nmeasures = 4\n', {}),
    ],
)
def test_unwanted_file_defaults_are_overridden(text: str, left: dict[str, object]) -> None:
    table = NEW if left else {key: value for key, value in NEW.items() if key not in ("tags", "measures")}
    written = append_step(text + LIST.partition("\n\n")[2], table)
    assert written is not None
    read = tomllib.loads(written)
    effective = {key: value for key, value in read.items() if key != "step"} | read["step"][1]
    wanted = dict(table) | (left or {"tags": [], "measures": 1})
    assert effective == wanted


@pytest.mark.parametrize(
    "text",
    [
        'style = "soft"\n' + LIST,  # a default that cannot be taken back
        '[[pair]]\nleader = { file = "x.bvh" }\n',
        "step = 4\n",
        "step = []\n",
        "not TOML",
        "colour = 3\n" + LIST,
    ],
)
def test_incompatible_text_is_refused(text: str) -> None:
    assert append_step(text, NEW) is None


def test_comments_of_empty_file_are_kept() -> None:
    text = append_step("# nothing yet\n", NEW)
    assert text is not None
    assert text.startswith("# nothing yet\n")
    assert tomllib.loads(text)["step"] == [NEW]


def test_windows_line_endings_are_kept() -> None:
    text = append_step(LIST.replace("\n", "\r\n"), NEW | {"fps": 60})
    assert text is not None
    assert text.startswith(LIST.rstrip("\n").replace("\n", "\r\n"))
    assert tomllib.loads(text)["step"][1] == NEW


@given(
    st.lists(
        st.fixed_dictionaries(
            {"file": st.text(min_size=1, max_size=20), "name": st.text(min_size=1, max_size=20)},
            optional={
                "bpm": st.floats(20, 400),
                "measures": st.integers(1, 99),
                "tags": st.lists(st.text(max_size=5), max_size=3),
                "mirror": st.booleans(),
                "style": st.text(max_size=9),
            },
        ),
        min_size=1,
        max_size=4,
    )
)
def test_written_steps_are_read_back_unchanged(tables: list[dict[str, object]]) -> None:
    text: str | None = ""
    for table in tables:
        assert text is not None
        text = append_step(text, table)
    assert text is not None
    assert tomllib.loads(text)["step"] == tables
