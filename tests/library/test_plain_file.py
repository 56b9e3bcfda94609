"""Regular files are read; pipes, devices and folders are refused without waiting."""

import os
from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.library.disk_cache import read_regular_file
from live.library.step_folder import load_folder
from live.show.patch.toml_model import read_text


def test_read_is_limited_to_one_byte_more_than_limit(tmp_path):
    (tmp_path / "long").write_bytes(b"abcdef")
    assert read_regular_file(tmp_path / "long", 3) == b"abcd"
    assert read_regular_file(tmp_path / "long", 6) == b"abcdef"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names here")
def test_pipe_is_refused_without_waiting(tmp_path):
    os.mkfifo(tmp_path / "groove.toml")
    with pytest.raises(PersonError, match=r"cannot read the patch .*groove\.toml: a file expected"):
        read_text(tmp_path / "groove.toml", "patch")
    with pytest.raises(PersonError, match=r"groove\.toml: not a file of at most"):
        load_folder(tmp_path)


@pytest.mark.parametrize("name", ["/dev/zero", "."])
def test_devices_and_folders_are_refused(name):
    if Path(name).exists():
        with pytest.raises(PersonError, match="cannot read the patch"):
            read_text(Path(name), "patch")


def test_impossible_file_name_is_refused(tmp_path):
    with pytest.raises(PersonError, match="no file can have this name"):
        read_text(tmp_path / "a\0b", "patch")
