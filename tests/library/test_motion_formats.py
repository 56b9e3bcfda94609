"""The table of motion formats: what its documents say, and formats that come, go and fail."""

import importlib.metadata
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from live.library import motion_formats
from live.library.motion_file import read_motion
from live.library.motion_formats import installed_formats
from live.motion.formats.file_error import MotionFileError
from tests.places import ROOT

READER = """
from live.motion.formats.file_error import MotionFileError
from live.motion.formats.motion_format import MotionFormat

def _read(file):
    raise MotionFileError(file.name, 1, f"{len(file.data)} bytes", "more expected")

FORMAT = MotionFormat("Dots", (".dots",), _read, "for this test", begins=(b"DOTS",))
"""


@pytest.fixture(autouse=True)
def _formats_are_found_anew() -> Iterator[None]:
    installed_formats.cache_clear()
    yield
    installed_formats.cache_clear()


def _install(monkeypatch: pytest.MonkeyPatch, folder: Path, **modules: str) -> None:
    """Make modules of these texts, and say that they are all formats outside the core."""
    for name, text in modules.items():
        (folder / f"{name}.py").write_text(text)
        monkeypatch.delitem(sys.modules, name, raising=False)
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.setattr(motion_formats, "BRIDGES", "no_such_package")
    entries = [importlib.metadata.EntryPoint(name, name, motion_formats.GROUP) for name in modules]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda *, group: entries)


def test_documents_list_the_formats_of_the_core() -> None:
    text = (ROOT / "docs/steps.md").read_text(encoding="utf-8")
    for one in installed_formats().formats:
        if one.read.__module__.startswith(("live.motion.", "live.library.")):
            assert f"| {one.name} | {' '.join(f'`{suffix}`' for suffix in one.suffixes)} | {one.text} |\n" in text


def test_metadata_of_the_project_names_the_formats_of_bridges() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    modules = sorted(project["entry-points"][motion_formats.GROUP].values())
    folders = sorted((ROOT / "live/bridges").glob("*/motion_format.py"))
    assert modules == [f"{motion_formats.BRIDGES}.{path.parent.name}.{path.stem}" for path in folders]
    assert installed_formats().left_out == {}


def test_every_suffix_belongs_to_one_format() -> None:
    suffixes = [suffix for one in installed_formats().formats for suffix in one.suffixes]
    assert len(set(suffixes)) == len(suffixes)
    assert all(suffix.startswith(".") and suffix == suffix.lower() for suffix in suffixes)
    assert all(set(one.written) <= set(one.suffixes) for one in installed_formats().formats)


def test_format_of_another_package_is_found_by_entry_point(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    _install(monkeypatch, tmp_path, dots_of_a_test=READER)
    assert ".dots" in motion_formats.readable_suffixes()
    for name in ("a.dots", "a.txt"):
        (tmp_path / name).write_text("DOTS 1 2 3")
        with pytest.raises(MotionFileError, match=f"{name}, line 1: 10 bytes; more expected"):
            read_motion(tmp_path / name)
    (tmp_path / "b.dots").write_text("HIERARCHY of another kind")  # the first bytes count more
    with pytest.raises(MotionFileError, match="ROOT"):
        read_motion(tmp_path / "b.dots")


def test_format_that_is_gone_or_fails_is_left_out(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    _install(monkeypatch, tmp_path, broken_of_a_test="1 / 0", empty_of_a_test="FORMAT = None")
    (tmp_path / "a.dots").write_text("DOTS")
    with pytest.raises(MotionFileError, match=r"no reader for \.dots files is installed; there are BVH") as caught:
        read_motion(tmp_path / "a.dots")
    assert "not broken_of_a_test (ZeroDivisionError: division by zero)" in str(caught.value)
    assert "not empty_of_a_test (TypeError: FORMAT is no motion format)" in str(caught.value)
    (tmp_path / "no_suffix").write_text("DOTS")
    with pytest.raises(MotionFileError, match="no reader for such a file is installed"):
        read_motion(tmp_path / "no_suffix")


def test_changed_reader_changes_the_code(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Cached clips are built anew when the code of a format outside the core has changed."""
    _install(monkeypatch, tmp_path, dots_of_a_test=READER)
    before = installed_formats().code
    (tmp_path / "dots_of_a_test.py").write_text(READER + "# changed")
    installed_formats.cache_clear()
    assert installed_formats().code != before
