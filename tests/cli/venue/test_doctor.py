"""`live doctor`: checks of this machine and of simulated broken ones."""

import errno
import json
import re
import socket
import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pytest

from live.app.machine import machine_check
from live.app.machine.device_list import Section
from live.app.machine.machine_check import Check
from live.base import jit
from tests.cli.command import run_live


@pytest.mark.long
def test_json_on_this_machine_contains_all_checks() -> None:
    done = run_live("doctor", "--json")
    report = json.loads(done.stdout)
    assert done.returncode == (0 if report["can_run"] else 1)
    by_name = {check["name"]: check for check in report["checks"]}
    assert {"Python", "numba", "moderngl", "OpenGL", "monitors", "kernel cache", "OSC port"} <= by_name.keys()
    assert by_name["Python"]["state"] == by_name["numba"]["state"] == "ok"
    assert all(check["remedy"] for check in report["checks"] if check["state"] != "ok")


@pytest.mark.long
def test_table_ends_with_verdict_for_show() -> None:
    done = run_live("doctor")
    verdict = done.stdout.splitlines()[-1]
    assert verdict.startswith("A show can run here" if done.returncode == 0 else "No show can run here")


def test_missing_required_part_has_exit_code_1() -> None:
    done = run_live("doctor", "--json", __EGL_VENDOR_LIBRARY_FILENAMES="/nowhere.json", DISPLAY="")
    report = json.loads(done.stdout)
    found = next(check for check in report["checks"] if check["name"] == "OpenGL")
    assert (found["state"], found["needed"]) == ("missing", True)
    assert done.returncode == 1
    assert report["can_run"] is False


def test_unwritable_cache_is_limited_without_traceback(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("not a folder")
    report = json.loads(run_live("doctor", "--json", LIVE_CACHE_DIR=str(file)).stdout)
    found = next(check for check in report["checks"] if check["name"] == "kernel cache")
    assert found["state"] == "limited"
    assert "LIVE_CACHE_DIR" in found["remedy"]


@pytest.mark.long
def test_cold_cache_is_reported_with_warm_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(jit, "KERNEL_STORE", jit.KernelStore((tmp_path / "kernels" / jit.KERNEL_SET,)))
    report = json.loads(run_live("doctor", "--json", LIVE_CACHE_DIR=str(tmp_path)).stdout)
    found = next(check for check in report["checks"] if check["name"] == "kernel cache")
    assert (found["state"], found["remedy"]) == ("limited", "live warm")


def test_busy_osc_port_is_limited_with_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        monkeypatch.setattr(machine_check, "OSC_ADDRESS", other.getsockname())
        busy = machine_check.check_osc_port()
        assert busy.state == "limited"
        assert str(other.getsockname()[1]) in busy.detail
        assert "--osc" in busy.remedy
    assert machine_check.check_osc_port().state == "ok"


def test_every_package_requirement_is_checked() -> None:
    from importlib.metadata import requires

    asked = [
        each
        for each in requires("choreographics-live") or []
        if not re.search("'(bench|train)'|\"(bench|train)\"", each)
        and not re.search(f"sys_platform (!= '{sys.platform}'|== '(?!{sys.platform}'))", each)
    ]
    assert len(list(machine_check.check_packages())) == len(asked)
    assert len(asked) > 30


def test_missing_package_prevents_show(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.metadata.requires", lambda name: ["surely-not-there>=1", "numpy>=2"])
    absent, present = machine_check.check_packages()
    assert absent == Check("surely-not-there", "missing", "not installed", "make play", needed=True)
    assert (present.name, present.state) == ("numpy", "ok")


def test_package_excluded_by_python_version_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    requirement = 'surely-not-there>=1; python_version < "3.13"'
    monkeypatch.setattr("importlib.metadata.requires", lambda name: [requirement])
    (found,) = machine_check.check_packages()
    assert (found.state, found.needed) == ("limited", False)
    assert 'python_version < "3.13"' in found.detail


def test_packages_of_other_systems_are_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = [f"not-there-{number}; sys_platform {each}" for number, each in enumerate(("!= 'linux'", "== 'linux'"))]
    monkeypatch.setattr("importlib.metadata.requires", lambda name: asked)
    monkeypatch.setattr(machine_check.sys, "platform", "linux")
    assert [(each.name, each.state) for each in machine_check.check_packages()] == [("not-there-1", "missing")]
    monkeypatch.setattr(machine_check.sys, "platform", "darwin")
    assert [(each.name, each.state) for each in machine_check.check_packages()] == [("not-there-0", "missing")]


def test_missing_ableton_link_does_not_prevent_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    def not_there(name: str) -> str:
        raise PackageNotFoundError

    monkeypatch.setattr("importlib.metadata.requires", lambda name: ['linkpython-extern>=1.3; extra == "link"'])
    monkeypatch.setattr("importlib.metadata.version", not_there)
    (found,) = machine_check.check_packages()
    assert (found.state, found.detail) == ("limited", "not installed: no Ableton Link")
    assert found.remedy == ".venv/bin/uv sync --frozen --inexact --extra link"


def test_remedies_outside_a_checkout_are_of_pip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_check, "_IN_CHECKOUT", False)
    asked = ['surely-not-there>=1; extra == "usd"', 'nor-this>=1; extra == "bench"']
    monkeypatch.setattr("importlib.metadata.requires", lambda name: asked)
    (found,) = machine_check.check_packages()
    assert found.remedy == "pip install 'choreographics-live[usd]'"
    assert found.detail == "not installed: no USD files of a show's motion"
    monkeypatch.setattr(machine_check, "_IN_ARCHIVE", True)  # which has no pip
    (found,) = machine_check.check_packages()
    assert found.remedy == "not in the archive: pipx install 'choreographics-live[usd]'"


def test_missing_portaudio_names_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    def not_there() -> str:
        raise OSError("PortAudio library not found")

    monkeypatch.setattr(machine_check, "_portaudio_version", not_there)
    monkeypatch.setattr(machine_check.shutil, "which", lambda name: name if name == "dnf" else None)
    (found,) = machine_check.check_audio()
    assert found.remedy == "sudo dnf install portaudio"


@pytest.mark.parametrize(
    ("why", "remedy"),
    [
        ("ALSA: cannot load library 'libasound.so.2': libasound.so.2: cannot open …", "sudo dnf install alsa-lib"),
        ("No module named 'rtmidi': on macOS and Windows MIDI needs …", "make clean play PYTHON=python3.12"),
        ("ALSA: No module named 'alsa_midi', no JACK server runs", "make play"),
        ("ALSA: /dev/snd/seq: Permission denied, no JACK server runs", "and log in again"),
        ("the kernel has no ALSA sequencer, no JACK server runs", "or start a JACK server"),
        ("MIDI is available, but no device is connected", "plug in a MIDI device"),
    ],
)
def test_midi_remedies_match_reason(monkeypatch: pytest.MonkeyPatch, why: str, remedy: str) -> None:
    monkeypatch.setattr(
        machine_check, "midi_sections", lambda: (Section("midi_inputs", (), why), Section("midi_outputs", (), why))
    )
    monkeypatch.setattr(machine_check.shutil, "which", lambda name: name if name == "dnf" else None)
    for found in machine_check.check_midi():
        assert found.state == "limited"
        assert found.remedy.endswith(remedy)


@pytest.mark.parametrize(
    ("manager", "library", "line"),
    [
        ("apt-get", "opengl", "sudo apt-get install --no-install-recommends libegl1 libgl1"),
        ("dnf", "alsa", "sudo dnf install alsa-lib"),
        ("brew", "portaudio", "brew install portaudio"),
        ("brew", "opengl", "opengl comes with this system"),
        ("none", "x11", "install x11 with this system's package manager"),
    ],
)
def test_install_command_matches_package_manager(
    monkeypatch: pytest.MonkeyPatch, manager: str, library: str, line: str
) -> None:
    monkeypatch.setattr(machine_check.shutil, "which", lambda name: name if name == manager else None)
    assert machine_check.install_command(library) == line


def _answer(stdout: str, stderr: str = "", code: int = 0) -> "subprocess.CompletedProcess[str]":
    return subprocess.CompletedProcess([], code, stdout, stderr)


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        (_answer("", "Traceback…\nException: libEGL.so not loaded\n", 1), "Exception: libEGL.so not loaded"),
        (_answer("", "", -11), "the driver crashed (exit -11)"),
    ],
)
def test_failing_or_crashing_opengl_is_reported(
    monkeypatch: pytest.MonkeyPatch, answer: "subprocess.CompletedProcess[str]", why: str
) -> None:
    monkeypatch.setattr(machine_check.subprocess, "run", lambda *_, **__: answer)
    assert machine_check.probe_opengl() == machine_check.OpenGL(None, why=why)


def test_hanging_opengl_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def hang(*_: object, timeout: float, **__: object) -> None:
        raise subprocess.TimeoutExpired("probe", timeout)

    monkeypatch.setattr(machine_check.subprocess, "run", hang)
    assert machine_check.probe_opengl(timeout=3).why == "the driver did not answer within 3 s"


def test_old_opengl_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_check, "probe_opengl", lambda: machine_check.OpenGL("old card", "3.3 driver", 330))
    found = machine_check.check_opengl()
    assert (found.state, found.needed) == ("missing", True)
    assert "4.1 is needed" in found.detail


def test_full_disk_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(**_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(machine_check.tempfile, "TemporaryFile", full)
    found = machine_check.check_kernels()
    assert (found.state, found.remedy) == ("limited", "free some space")
