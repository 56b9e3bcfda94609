"""The table of motion formats: what its documents say, and formats that come, go and fail."""

import gzip
import importlib.metadata
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from live.library import motion_formats
from live.library.motion_file import read_motion
from live.library.motion_formats import installed_formats
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh
from live.motion.formats.file_error import MotionFileError
from tests.motion.formats.made_bvh import body_bvh, dance_values
from tests.places import ROOT

SECTION = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").partition("### A motion format: 3 files\n")[2]
READER = re.findall(r"```python\n(.*?)```", SECTION, re.DOTALL)[0]
"""The example of CONTRIBUTING.md."""


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


def test_documents_describe_formats_as_they_are() -> None:
    text = (ROOT / "docs/how-to/dance/steps.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| [^|]+ \| `\.[^|]+ \| [^|]+ \|$", text, re.MULTILINE)
    assert len(rows) > 3
    assert set(rows) <= {
        f"| {one.name} | {' '.join(f'`{suffix}`' for suffix in one.suffixes)} | {one.text} |"
        for one in installed_formats().formats
    }


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
    """The example of CONTRIBUTING.md: packed BVH."""
    _install(monkeypatch, tmp_path, packed_bvh=READER)
    assert ".gz" in motion_formats.readable_suffixes()
    text = body_bvh(dance_values(5))
    expected = bvh_to_source_motion(parse_bvh(text, "x"))
    for name in ("a.bvh.gz", "a.txt"):
        (tmp_path / name).write_bytes(gzip.compress(text.encode()))
        np.testing.assert_array_equal(read_motion(tmp_path / name).rotation, expected.rotation)
    (tmp_path / "b.gz").write_text(text)  # the first bytes count more than the name
    assert read_motion(tmp_path / "b.gz").frame_count == 5
    (tmp_path / "c.gz").write_text("words")
    with pytest.raises(MotionFileError, match=r"c\.gz: not packed by gzip: .*; a packed BVH file expected"):
        read_motion(tmp_path / "c.gz")


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
    _install(monkeypatch, tmp_path, packed_bvh=READER)
    before = installed_formats().code
    (tmp_path / "packed_bvh.py").write_text(READER + "# changed")
    installed_formats.cache_clear()
    assert installed_formats().code != before
