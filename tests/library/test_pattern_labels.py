"""Files of labels: what is written is read, and what is no such file is refused in one line that says where."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.errors import PersonError
from live.library.pattern_labels import (
    LabelledPattern,
    PatternLabels,
    checked_labels,
    labels_path,
    read_labels,
    write_labels,
)

HEAD = '[[pattern]]\ntake = "a"\n'
NAMES = st.from_regex(r"\A[A-Za-z0-9é][A-Za-z0-9é .+'/-]{0,20}\Z")


@pytest.mark.long
@given(st.lists(st.tuples(st.sampled_from(["a", 'b "c" \\', "d\te"]), NAMES), max_size=12), st.lists(NAMES, max_size=5))
def test_written_labels_are_read_again(
    tmp_path_factory: pytest.TempPathFactory, told: list[tuple[str, str]], names: list[str]
) -> None:
    patterns = sorted(
        (
            LabelledPattern(take=take, from_s=2.5 * n, to_s=2.5 * n + 2.5, label=name)
            for n, (take, name) in enumerate(told)
        ),
        key=lambda one: (one.take, one.from_s),
    )
    labels = PatternLabels(tuple(dict.fromkeys([*names, *(one.label for one in patterns)])), tuple(patterns))
    path = tmp_path_factory.mktemp("labels") / "pairs.labels.toml"
    write_labels(path, labels)
    assert read_labels(path) == labels


def test_a_label_holds_from_its_begin_to_its_end() -> None:
    one = LabelledPattern(take="a", from_s=1.0, to_s=2.0, label="x")
    other = LabelledPattern(take="a", from_s=2.0, to_s=3.0, label="y")
    labels = PatternLabels(("x", "y"), (one, other))
    assert [labels.at("a", time) for time in (0.9, 1.0, 1.99, 2.0, 3.0)] == [None, "x", "x", "y", None]
    assert labels.at("b", 1.5) is None
    assert labels_path(Path("d/salsa.toml")) == Path("d/salsa.labels.toml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("labels = 3", "line 1: labels"),
        ("labels = [\"\"]", "labels.1"),
        ("labels = [\"a\\u0000b\"]", "labels.1: a word of letters"),
        ("labels = [\"<script>\"]", "a word of letters"),
        ("[[pattern", "not valid TOML"),
        ("[" * 5000, "not valid TOML|too deep"),
        ("pattern = 1", "line 1: pattern"),
        (HEAD, "from_s: missing"),
        (f'{HEAD}from_s = 1\nto_s = 2\nlabel = "x"\nsize = 3', "line 6: pattern.1.size: unknown key"),
        (f'{HEAD}from_s = 2\nto_s = 2\nlabel = "x"', "line 1: to_s after from_s"),
        (f'{HEAD}from_s = -1\nto_s = 2\nlabel = "x"', "line 3: pattern.1.from_s"),
        (f'{HEAD}from_s = nan\nto_s = 2\nlabel = "x"', "line 3: pattern.1.from_s"),
        (f'{HEAD}from_s = 1\nto_s = inf\nlabel = "x"', "line 4: pattern.1.to_s"),
        (f'{HEAD}from_s = "1"\nto_s = 2\nlabel = "x"', "line 3: pattern.1.from_s"),
        (f'{HEAD}from_s = true\nto_s = 2\nlabel = "x"', "line 3: pattern.1.from_s"),
        (f'{HEAD}from_s = 1\nto_s = 2\nlabel = 7', "line 5: pattern.1.label"),
        (f'{HEAD}from_s = 1\nto_s = 3\nlabel = "x"\n{HEAD}from_s = 2\nto_s = 4\nlabel = "y"',
         "line 6: a has two labels at 2 s: 'x' and 'y'"),
    ],
)  # fmt: skip
def test_what_is_no_file_of_labels_is_refused_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "x.labels.toml"
    path.write_text(text)
    with pytest.raises(PersonError, match=words) as told:
        read_labels(path)
    assert "\n" not in told.value.message
    assert str(path) in told.value.message


def test_files_that_are_none_are_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "nothing.toml"):
        with pytest.raises(PersonError, match="cannot read the labels"):
            read_labels(path)
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(PersonError, match="UTF-8"):
        read_labels(tmp_path / "bytes.toml")
    (tmp_path / "long.toml").write_bytes(b"#" * 1_000_001)
    with pytest.raises(PersonError, match="more than 1000000 bytes"):
        read_labels(tmp_path / "long.toml")


GOOD = {"take": "a", "from_s": 1.0, "to_s": 2.0, "label": "x"}


@pytest.mark.parametrize(
    "values",
    [
        None, 5, [], {"pattern": 3}, {"labels": ["\ud800"]}, {"labels": ["x"] * 31}, {"more": 1},
        {"pattern": [GOOD | {"take": "b"}]}, {"pattern": [GOOD | {"to_s": 11.0}]}, {"pattern": [GOOD | {"to_s": 1.0}]},
        {"pattern": [GOOD | {"label": "a\nb"}]}, {"pattern": [GOOD, GOOD | {"label": "y"}]},
        {"pattern": [GOOD | {"from_s": float("nan")}]}, {"pattern": [GOOD | {"from_s": None}]},
    ],
)  # fmt: skip
def test_labels_of_a_page_that_do_not_fit_the_takes_are_refused(values: Any) -> None:
    with pytest.raises(PersonError):
        checked_labels(values, {"a": 10.0})


def test_labels_of_a_page_are_put_in_order() -> None:
    found = checked_labels({"labels": ["y"], "pattern": [GOOD | {"from_s": 4.0, "to_s": 10.05}, GOOD]}, {"a": 10.0})
    assert [one.from_s for one in found.patterns] == [1.0, 4.0]
    assert found.labels == ("y", "x")
