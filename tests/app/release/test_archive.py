"""The archive: its launcher on small trees, the libraries that it finds, and how it is packed."""

import os
import shutil
import subprocess
import sys
import tarfile

import pytest

from live.base.errors import PersonError
from tests.places import ROOT

archive = pytest.importorskip("tools.archive.__main__", reason="license-expression comes with `make test`")

pytestmark = pytest.mark.skipif(
    not (
        sys.platform == "linux" and os.path.exists("/lib64/ld-linux-x86-64.so.2") and os.path.exists("/sbin/ldconfig")
    ),
    reason="archives are made on and for Linux with the GNU C library on x86-64",
)
PYTHON = '#!/bin/sh\nprintf "%s\\n" "$@" "$LD_LIBRARY_PATH" "${PYTHONPATH-none}" "${ALSA_CONFIG_DIR-none}"\n'
"""A Python that tells what it was given."""


@pytest.fixture
def tree(tmp_path):
    """An unpacked archive in a folder with a space, with a library that every system has, and one that none has."""
    folder = tmp_path / "the stage" / "live 1"
    (folder / "python" / "bin").mkdir(parents=True)
    python = folder / "python" / "bin" / "python3"
    python.write_text(PYTHON)
    python.chmod(0o755)
    for name in ("libc.so.6", "libnowhere.so.7"):
        (folder / "libraries" / name).mkdir(parents=True)
    (folder / "alsa").mkdir()
    shutil.copy(ROOT / "tools" / "archive" / "launcher.sh", folder / "live")
    return folder


def start(command, *arguments, **options):
    done = subprocess.run([command, *arguments], capture_output=True, text=True, check=True, **options)
    return done.stdout.splitlines()


def test_launcher_starts_its_own_python_from_anywhere(tree, tmp_path):
    link, second = tmp_path / "live", tmp_path / "bin link"
    link.symlink_to(tree / "live")
    second.symlink_to("live")
    environment = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": "/nowhere"}
    for command in (str(tree / "live"), str(link), str(second), "live"):
        told = start(command, "play", "my song.wav", cwd="/", env=environment)
        assert told[:4] == ["-m", "live", "play", "my song.wav"]
        assert told[5] == "none"
    assert start("./live", cwd=tree, env=environment)[:2] == ["-m", "live"]


def test_launcher_takes_only_libraries_that_the_system_lacks(tree):
    plain = {"PATH": os.environ["PATH"]}
    ours = f"{tree}/python/lib:{tree}/libraries/libnowhere.so.7"
    assert start(tree / "live", env=plain)[2] == ours
    assert start(tree / "live", env={**plain, "LD_LIBRARY_PATH": "/mine"})[2] == f"{ours}:/mine"


def test_launcher_names_alsa_without_a_space(tree):
    told = start(tree / "live", env={"PATH": os.environ["PATH"]})[4]
    if os.path.exists("/usr/share/alsa/alsa.conf"):
        assert told == "none"
    else:
        assert told.startswith("/proc/")


def test_plain_names_find_libraries_of_the_archive(tree):
    code = "from sitecustomize import find_library as find; print(find('nowhere'), find('c'), find('nobody'))"
    environment = {
        "PATH": os.environ["PATH"],
        "PYTHONPATH": str(ROOT / "tools" / "archive"),
        "LD_LIBRARY_PATH": f"{tree}/libraries/libnowhere.so.7::/nowhere",
    }
    (told,) = start(sys.executable, "-c", code, env=environment)
    assert told == f"{tree}/libraries/libnowhere.so.7/libnowhere.so.7 libc.so.6 None"


def test_libraries_are_those_that_files_need():
    assert archive.libraries_of([shutil.which("sh")])["libc.so.6"].is_file()
    assert archive.SYSTEM.match("libc.so.6")
    assert archive.SYSTEM.match("libEGL.so.1")
    assert not archive.SYSTEM.match("libcrypto.so.3")


def test_missing_library_is_told(monkeypatch):
    monkeypatch.setattr(archive, "LOADED", ("libc.so.6", "libnowhere.so.7"))
    with pytest.raises(PersonError, match=r"lacks libnowhere\.so\.7"):
        archive.find_loaded()
    monkeypatch.setattr(archive, "LOADED", ("libc.so.6",))
    assert archive.find_loaded()["libc.so.6"].is_file()


def test_archive_without_documentation_does_not_begin(monkeypatch, tmp_path):
    monkeypatch.setattr(archive.shutil, "which", lambda name: name)
    monkeypatch.setattr(archive, "ROOT", tmp_path)
    for name in sorted(archive.artifacts.SITE):
        with pytest.raises(PersonError, match=f"{name} is missing") as told:
            archive.check_start()
        assert told.value.remedy == "make docs"
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    archive.check_start()


def test_machine_without_debian_packages_is_told(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    with pytest.raises(PersonError, match="this machine lacks dpkg, ldd"):
        archive.check_start()


@pytest.mark.parametrize(
    ("does", "fault"), [("echo no network >&2; exit 1", "uv python: no network"), ("mkdir -p $5", "uv installed no")]
)
def test_another_python_is_taken_only_when_asked_for(tmp_path, does, fault):
    uv = tmp_path / "uv"
    uv.write_text(f"#!/bin/sh\n{does}\n")
    uv.chmod(0o755)
    with pytest.raises(PersonError, match=fault) as told:
        archive.find_interpreter(False, "3.11", uv, tmp_path / "scratch")
    assert "--python own" in told.value.remedy
    binary, library = archive.find_interpreter(True, "3.11", uv, tmp_path / "scratch")
    assert binary.samefile(sys.executable)
    assert (library / "os.py").is_file()


def test_python_of_uv_is_found(tmp_path):
    uv = tmp_path / "uv"
    uv.write_text('#!/bin/sh\nmkdir -p "$5/cpython-3.11.9-linux" && ln -s cpython-3.11.9-linux "$5/cpython-3.11"\n')
    uv.chmod(0o755)
    prefix = tmp_path / "cpython-3.11.9-linux"
    found = archive.find_interpreter(False, "3.11", uv, tmp_path)
    assert found == (prefix / "bin" / "python3.11", prefix / "lib" / "python3.11")


def test_the_same_tree_is_packed_into_the_same_bytes(tree, tmp_path):
    (tree / "python" / "bin" / "python").symlink_to("python3")
    packed = []
    for number in (1, 2):
        os.utime(tree / "live", (number, number))
        path = tmp_path / f"{number}.tar.gz"
        archive.pack(tree, path, 86400)
        packed.append(path.read_bytes())
    assert packed[0] == packed[1]
    with tarfile.open(path) as tar:
        members = {member.name: member for member in tar}
    assert members["live 1"].isdir()
    assert members["live 1/python/bin/python"].linkname == "python3"
    assert members["live 1/live"].mode == members["live 1/python/bin/python3"].mode == 0o755
    assert {(member.mtime, member.uid, member.uname) for member in members.values()} == {(86400, 0, "")}
