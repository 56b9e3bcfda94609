"""tools/setup.sh on machines made of small scripts: requested packages, their order, and no repetition."""

import os
import pty
import re
import shutil
import subprocess

import pytest

from tests.app.setup_machine import ASK_INSTALLED, LINK_WHEEL, PYTHON, SETUP, Machine, debian, machine, make_root
from tests.fixtures.mostly_long import mostly_long

__all__ = ["debian", "machine"]

APT_LINE = (
    "  sudo apt-get install --no-install-recommends libegl1 libgl1 libasound2 libportaudio2 libatomic1"
    " libx11-6 libxcursor1 libxi6 libxinerama1 libxrandr2 python3.11-venv"
)


def test_dry_run_prints_commands_and_changes_nothing(debian: Machine) -> None:
    said = debian.run("play", SETUP_DRY_RUN="1")
    assert said.splitlines()[0] == APT_LINE
    assert "uv sync --frozen" in said
    assert debian.log() == []
    assert not (debian.home / "show" / ".venv").exists()


@pytest.mark.long
def test_dry_run_of_tests_lists_test_packages(debian: Machine) -> None:
    second = debian.run("test", SETUP_DRY_RUN="1").splitlines()[1]
    for package in ("xserver-xorg-video-dummy", "xdotool", "imagemagick", "pulseaudio", "liblo-tools"):
        assert f" {package}" in second


def test_setup_without_root_prints_install_command_and_changes_nothing(debian: Machine) -> None:
    said = debian.run("play", code=1)
    assert said.splitlines()[-1] == APT_LINE
    assert debian.log() == []


def test_package_names_of_newer_release_are_used(debian: Machine) -> None:
    (debian.home / "updated").touch()
    assert " libasound2t64 " in debian.run("play", code=1, FAKE_UNKNOWN="")


def test_installed_packages_are_not_requested(debian: Machine) -> None:
    for package in ("libegl1", "libasound2t64", "python3.11-venv"):
        (debian.home / "installed" / package).touch()
    assert debian.run("play", code=1).splitlines()[-1] == (
        "  sudo apt-get install --no-install-recommends libgl1 libportaudio2 libatomic1 libx11-6 libxcursor1 libxi6"
        " libxinerama1 libxrandr2"
    )


@pytest.mark.parametrize(
    ("manager", "asker", "line"),
    [
        ("dnf", "rpm", "  sudo dnf install libglvnd-egl libglvnd-glx mesa-libEGL mesa-libGL mesa-dri-drivers alsa-lib"),
        ("brew", "brew", "  brew install portaudio"),
    ],
)
def test_other_package_managers_get_their_command(machine: Machine, manager: str, asker: str, line: str) -> None:
    machine.add(manager, "#!/bin/sh\nexit 1\n")
    machine.add(asker, ASK_INSTALLED)
    (machine.home / "installed" / "python3.11-venv").touch()  # a Python that is whole, as there
    assert machine.run("play", code=1).splitlines()[-1].startswith(line)


def test_setup_continues_without_package_manager(machine: Machine) -> None:
    assert "no apt, dnf or brew" in machine.run("play")
    assert any(line.startswith("uv sync") for line in machine.log())


@pytest.mark.long
def test_missing_link_wheel_does_not_prevent_installation(debian: Machine) -> None:
    make_root(debian)
    assert "without Ableton Link" in debian.run("play", FAKE_NO_LINK="yes")
    first, second = (line for line in debian.log() if line.startswith("uv sync"))
    assert "--extra=link" in first
    assert "--extra=link" not in second
    assert "--extra=fast" in second


def test_setup_as_root_installs_everything_once(debian: Machine) -> None:
    make_root(debian)
    debian.run("play")
    update, install, *python = debian.log()
    assert update.startswith("apt-get update")
    assert "--no-install-recommends" in install
    assert "--no-remove" in install
    assert install.endswith(APT_LINE.partition("recommends")[2])
    assert python[:2] == ["python -m venv .venv", "python -m pip --version"]
    assert python[2].startswith("python -m pip install")
    assert python[3].startswith("uv sync --frozen --inexact")
    assert python[3].endswith("--extra=link --extra=fast --no-dev")
    assert python[4] == "python -m compileall -q live"
    assert len(python) == 5  # a show compiles what it needs when it starts

    debian.run("play")
    assert debian.log() == []


@pytest.mark.long
def test_passwordless_sudo_installs_packages(debian: Machine) -> None:
    debian.add("sudo", '#!/bin/sh\necho "sudo $*" >>"$LOG"\n[ "$1" = -n ] && shift\nexec "$@"\n')
    assert debian.run("play", code=1).splitlines()[-1] == APT_LINE  # nobody there to be asked
    assert debian.log() == []
    debian.run("play", SETUP_YES="1")
    assert any(line.startswith("sudo -n env DEBIAN_FRONTEND=noninteractive apt-get install") for line in debian.log())


def test_sudo_needing_password_without_terminal_prints_command(debian: Machine) -> None:
    debian.add("sudo", "#!/bin/sh\nexit 1\n")
    assert debian.run("play", code=1, SETUP_YES="1").splitlines()[-1] == APT_LINE


def read_to_end(terminal: int) -> bytes:
    """What was written to a pseudo-terminal whose other end is closed; it comes in pieces."""
    said = b""
    try:
        while piece := os.read(terminal, 65536):
            said += piece
    except OSError:  # EIO: nothing is left
        pass
    return said


def run_at_terminal(machine: Machine, answer: str, **environment: str) -> tuple[int, list[str]]:
    """Run setup.sh at a pseudo-terminal where `answer` is typed; return the exit code and the lines there."""
    try:
        ours, theirs = pty.openpty()
    except OSError as error:
        pytest.skip(f"no pseudo-terminals on this machine: {error}")
    os.write(ours, f"{answer}\n".encode())
    done = subprocess.run(
        [str(machine.home / "show" / "tools" / "setup.sh"), "play"],
        env=machine.environment | environment,
        stdin=theirs,
        stderr=theirs,
        timeout=60,
        check=False,
    )
    os.close(theirs)
    said = read_to_end(ours).decode().replace("\r", "")
    os.close(ours)
    return done.returncode, said.splitlines()


@pytest.mark.long
def test_sudo_may_request_password_with_terminal(debian: Machine) -> None:
    sudo = '#!/bin/sh\necho "sudo $*" >>"$LOG"\ncase $1 in -n) exit 1 ;; -v) exit $FAKE_REFUSED ;; esac\nexec "$@"\n'
    debian.add("sudo", sudo)
    for refused in (1, 0):
        code, said = run_at_terminal(debian, "y", FAKE_REFUSED=str(refused))
        assert any("needs your password" in line for line in said)
        assert code == refused, said
        assert (APT_LINE in said) == bool(refused)
    assert any(line.startswith("sudo env DEBIAN_FRONTEND=noninteractive apt-get install") for line in debian.log())


@mostly_long(
    ("answer", "agreed"),
    [("", True), ("y", True), ("Yes", True), ("n", False), ("no", False), ("what?", False)],
    quick=[0, 3],
)
def test_root_at_a_terminal_is_asked_before_packages_are_installed(debian: Machine, answer: str, agreed: bool) -> None:
    make_root(debian)
    code, said = run_at_terminal(debian, answer)
    told = "\n".join(said)
    assert f"missing:{APT_LINE.partition('recommends')[2]}\nInstall these now? [Y/n]" in told
    assert code == (0 if agreed else 1)
    assert any("apt-get install" in line for line in debian.log()) == agreed
    assert (debian.home / "show" / ".venv").exists() == agreed
    assert (APT_LINE in said) != agreed


@pytest.mark.long
def test_question_is_not_asked_when_answered_before_or_needless(debian: Machine) -> None:
    make_root(debian)
    code, said = run_at_terminal(debian, "n", SETUP_YES="1")
    assert (code, [line for line in said if "[Y/n]" in line]) == (0, [])
    shutil.rmtree(debian.home / "show" / ".venv")
    code, said = run_at_terminal(debian, "n")  # nothing is missing any more
    assert (code, [line for line in said if "[Y/n]" in line]) == (0, [])


def test_setup_of_benches_installs_their_peers(debian: Machine) -> None:
    make_root(debian)
    debian.run("bench")
    assert [line for line in debian.log() if line.endswith("--extra=link --extra=fast --no-dev --extra=bench")]


@pytest.mark.long
def test_missing_test_packages_are_skipped_and_requested_again(debian: Machine) -> None:
    make_root(debian)
    assert "skipped" in debian.run("test", FAKE_UNINSTALLABLE="pulseaudio")
    log = debian.log()
    assert any("uv sync" in line and line.endswith("--group=dev --extra=bench") for line in log)
    installed = {path.name for path in (debian.home / "installed").iterdir()}
    assert "liblo-tools" in installed  # what could be had was taken
    assert "pulseaudio" not in installed

    debian.run("test")  # now it can be had
    assert (debian.home / "installed" / "pulseaudio").exists()


def test_uninstallable_required_package_stops_setup(debian: Machine) -> None:
    make_root(debian)
    said = debian.run("play", code=1, FAKE_UNINSTALLABLE="libportaudio2")
    assert "apt-get could not install" in said
    assert not (debian.home / "show" / ".venv").exists()


@mostly_long("name", ["uv.lock", "pyproject.toml", "tools/uv-requirements.txt"], quick=[1])
def test_changed_lock_file_is_synced_again(debian: Machine, name: str) -> None:
    make_root(debian)
    debian.run("play")
    debian.log()
    with (debian.home / "show" / name).open("a") as file:
        file.write("changed")
    debian.run("play")
    assert [line.split()[0] for line in debian.log()] == ["uv"]


@pytest.mark.long
def test_changed_or_deleted_kernels_are_warmed_again(debian: Machine) -> None:
    make_root(debian)
    debian.run("test")
    assert debian.log()[-1].startswith("live warm --stamp")
    (debian.home / "show" / "live" / "base" / "scalar_kernels.py").write_text("changed")
    debian.run("test")
    assert [line.split(" --")[0] for line in debian.log()] == ["python -m compileall -q live", "live warm"]
    shutil.rmtree(debian.home / "kernels")
    debian.run("test")
    assert [line.split()[0] for line in debian.log()] == ["live"]


def test_venv_of_removed_python_is_recreated(debian: Machine) -> None:
    make_root(debian)
    debian.run("play")
    debian.log()
    python = debian.home / "show" / ".venv" / "bin" / "python"
    python.unlink()
    python.symlink_to("/nowhere/python3.11")
    assert "making it anew" in debian.run("play")
    assert "python -m venv .venv" in debian.log()


@pytest.mark.parametrize("version", ["3.9", "3.10", "3.15", "2.7"])
def test_unsupported_python_version_is_reported(debian: Machine, version: str) -> None:
    said = debian.run("play", code=1, FAKE_PYTHON=version)
    assert "Python 3.11, 3.12, 3.13 or 3.14 is needed" in said
    assert f"python3 {version}" in said
    assert debian.log() == []


def test_missing_python_is_reported(debian: Machine) -> None:
    (debian.home / "bin" / "python3").unlink()
    assert "python3 none" in debian.run("play", code=1)


def test_newest_complete_python_is_chosen(debian: Machine) -> None:
    (debian.home / "installed" / "python3.12-venv").touch()
    for minor in (10, 12, 13):  # 3.13 is the newest but cannot make a .venv, 3.10 is too old
        debian.add(f"python3.{minor}", PYTHON.replace("$FAKE_PYTHON", f"3.{minor}"))
    assert "with python3.12 (3.12)" in debian.run("play", SETUP_DRY_RUN="1")
    (debian.home / "installed" / "python3.13-venv").touch()
    assert "with python3.13 (3.13)" in debian.run("play", SETUP_DRY_RUN="1")


@pytest.mark.long
def test_python_on_which_everything_works_is_chosen(debian: Machine) -> None:
    for minor in (11, 13, 14):
        debian.add(f"python3.{minor}", PYTHON.replace("$FAKE_PYTHON", f"3.{minor}"))
        (debian.home / "installed" / f"python3.{minor}-venv").touch()
    assert "with python3.13 (3.13)" in debian.run("play", SETUP_DRY_RUN="1")
    (debian.home / "installed" / "python3.13-venv").unlink()  # one that needs a package comes later
    assert "with python3.11 (3.11)" in debian.run("play", SETUP_DRY_RUN="1")
    (debian.home / "installed" / "python3.11-venv").unlink()
    assert "with python3.14 (3.14)" in debian.run("play", SETUP_DRY_RUN="1")
    (debian.home / "installed" / "python3.14-venv").unlink()
    assert "with python3.13 (3.13)" in debian.run("play", SETUP_DRY_RUN="1")
    with (debian.home / "show" / "uv.lock").open("a") as lock:
        lock.write(LINK_WHEEL.format(minor=14))
    assert "with python3.14 (3.14)" in debian.run("play", SETUP_DRY_RUN="1")


def test_python_without_a_wheel_of_link_is_told_once(debian: Machine) -> None:
    make_root(debian)
    assert "everything works but Ableton Link" in debian.run("play", FAKE_PYTHON="3.14")
    synced = [line for line in debian.log() if line.startswith("uv sync")]
    assert len(synced) == 1
    assert "--extra=link" not in synced[0]
    assert "Link" not in debian.run("play", FAKE_PYTHON="3.14")


def test_locked_link_has_wheels_as_setup_looks_for_them() -> None:
    lock = (SETUP.parents[1] / "uv.lock").read_text()
    assert re.search(r"/linkpython_extern-[^/]*-cp313-", lock)


def test_unknown_mode_prints_usage(debian: Machine) -> None:
    assert "usage" in debian.run("show", code=2)


def test_uv_is_pinned_with_hashes(debian):
    make_root(debian)
    debian.run("play")
    installs = [line for line in debian.log() if " pip install" in line]
    assert installs == ["python -m pip install -q --require-hashes --only-binary=:all: -r tools/uv-requirements.txt"]
    wanted = [line for line in (SETUP.parent / "uv-requirements.txt").read_text().splitlines() if line[0] != "#"]
    assert re.fullmatch(r"uv==\d+\.\d+\.\d+ \\", wanted[0])
    assert len(wanted) > 10  # Linux with either libc, macOS and Windows, on their processors
    assert all(re.fullmatch(r"    --hash=sha256:[0-9a-f]{64}( \\)?", line) for line in wanted[1:])
