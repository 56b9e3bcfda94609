"""Plain files are read; pipes, devices and folders are named and never waited for."""

import os
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.library.disk_cache import read_regular_file
from live.library.step_folder import load_steps
from live.show.patch.patch_reader import read_text


def test_no_more_is_read_than_asked(tmp_path):
    (tmp_path / "long").write_bytes(b"abcdef")
    assert read_regular_file(tmp_path / "long", 3) == b"abcd"
    assert read_regular_file(tmp_path / "long", 6) == b"abcdef"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names here")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "groove.toml")
    with pytest.raises(PersonError, match=r"cannot read the patch .*groove\.toml: a file expected"):
        read_text(tmp_path / "groove.toml", "patch")
    with pytest.raises(PersonError, match=r"cannot read the step .*groove\.toml: a file expected"):
        load_steps(tmp_path)


@pytest.mark.parametrize("name", ["/dev/zero", "."])
def test_devices_and_folders_are_named(name):
    if Path(name).exists():
        with pytest.raises(PersonError, match="cannot read the patch"):
            read_text(Path(name), "patch")


def test_a_name_that_no_file_has_is_named(tmp_path):
    with pytest.raises(PersonError, match="no file can have this name"):
        read_text(tmp_path / "a\0b", "patch")
