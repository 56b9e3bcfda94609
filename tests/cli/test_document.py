"""`live document`: edits from a file, answers as JSON, history."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.cli.command import run_live

TEXT = '# mine\nname = "x"\nseed = 3\n[[group]]\nname = "ember"\ndancers = 4\nsteps = ["groove x2", "turn"]\n'


@pytest.fixture
def show(tmp_path: Path) -> Path:
    path = tmp_path / "show.toml"
    path.write_text(TEXT)
    return path


def document(*arguments: str, code: int = 0) -> str:
    done = run_live("document", *arguments)
    assert done.returncode == code, done.stderr
    return done.stdout


def edits(folder: Path, *values: dict[str, Any]) -> str:
    path = folder / "edits.json"
    path.write_text(json.dumps(values))
    return str(path)


@pytest.mark.long
def test_edits_are_answered_in_order_and_can_be_undone(show: Path) -> None:
    good = {"id": "a", "by": "ana", "base": None, "do": "set", "at": ["seed"], "value": 7}
    bad = {"id": "b", "do": "change", "at": ["group", "ember", "steps"], "value": ["no step"]}
    file = edits(show.parent, good, bad, good | {"id": "c", "at": ["group", "ember", "dancers"], "value": 5})
    dry = json.loads(document("edit", str(show), file, "--dry", "--json", code=1))
    assert show.read_text() == TEXT
    answers = json.loads(document("edit", str(show), file, "--json", code=1))
    assert [sorted(answer) for answer in answers] == [
        ["id", "inverse", "revision"],
        ["id", "refused"],
        ["id", "inverse", "revision"],
    ]
    assert answers == dry
    assert [answer["id"] for answer in answers] == ["a", "b", "c"]
    (fault,) = answers[1]["refused"]
    assert (fault["line"], fault["field"]) == (7, "group.1.steps")
    assert "no step is called 'no step'" in fault["what"]
    assert show.read_text() == TEXT.replace("seed = 3", "seed = 7").replace("dancers = 4", "dancers = 5")
    log = json.loads(document("log", str(show), "--json"))
    assert [(one["revision"], one["by"]) for one in log] == [(0, ""), (1, "ana"), (2, "ana")]
    assert "undo: revision 3" in document("undo", str(show), "--by", "ana")
    assert "'bea' has nothing to undo" in document("undo", str(show), "--by", "bea", code=1)
    document("undo", str(show))
    assert show.read_text() == TEXT
    document("redo", str(show))
    document("restore", str(show), "2", "--json")
    assert "dancers = 5" in show.read_text()
    assert "no revision 99" in document("restore", str(show), "99", code=1)


def test_an_empty_list_leaves_every_byte(show: Path) -> None:
    assert json.loads(document("edit", str(show), edits(show.parent), "--json")) == []
    assert show.read_text() == TEXT
    assert not (show.parent / ".history").exists()


def test_malformed_edits_name_the_one(show: Path) -> None:
    done = run_live("document", "edit", str(show), edits(show.parent, {"do": "burn", "at": ["seed"]}))
    assert done.returncode == 2
    assert "edit 1: do: " in done.stderr
    assert "allowed are insert, change" in done.stderr
    assert run_live("document", "edit", str(show), str(show.parent / "none.json")).returncode == 2
