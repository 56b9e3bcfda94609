"""The unit written by `live service install`, read back by systemd's rules."""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.app.machine.systemd_unit import SystemdService, default_service_name, quote_word, unit_name
from live.base.errors import PersonError
from tests.cli.command import run_live


def parse_unit(text: str) -> dict[str, list[str]]:
    """Assignments of the unit by name."""
    found: dict[str, list[str]] = {}
    for line in text.splitlines():
        if "=" in line and not line.startswith("#"):
            name, _, value = line.partition("=")
            found.setdefault(name, []).append(value)
    return found


def split_command_line(line: str) -> list[str]:
    """A command line split as specified by systemd.service(5) and systemd.syntax(7)."""
    found = []
    for quoted, plain in re.findall(r'"((?:[^"\\]|\\.)*)"|(\S+)', line):
        text = re.sub(r"\\(.)", r"\1", quoted) if quoted or not plain else plain
        found.append(text.replace("%%", "%").replace("$$", "$"))
    return found


TEXTS = st.text(st.characters(min_codepoint=32, blacklist_categories=("Cs", "Cc")), max_size=30)


@given(st.lists(TEXTS, max_size=5))
def test_systemd_reads_any_arguments_unchanged(arguments):
    service = SystemdService("a", arguments, Path("/tmp"), True, {})
    line = parse_unit(service.text(version=252))["ExecStart"][0]
    assert split_command_line(line) == service.command()


@pytest.mark.parametrize("text", ["a\nExecStartPre=/bin/evil", "a\0b", "a\x7fb", "\udcff"])
def test_text_invalid_in_unit_line_is_refused(text):
    with pytest.raises(PersonError):
        quote_word(text)
    with pytest.raises(PersonError):
        SystemdService("a", [text], Path("/tmp"), True, {}).text(version=252)


@pytest.mark.parametrize("name", ["", "../x", "A", "a b", "a%n", "a" * 41, "-a"])
def test_service_name_with_other_characters_is_refused(name):
    with pytest.raises(PersonError):
        unit_name(name)


def test_default_service_name_comes_from_patch(tmp_path: Path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert [default_service_name(patch) for patch in (None, "Contemporary", "a/b c.toml", "x/show.toml", "ü")] == [
        "first-show", "contemporary", "b-c", "x", "show",
    ]  # fmt: skip


def test_windowed_service_follows_session_and_headless_service_follows_machine():
    there = {"DISPLAY": ":0", "XAUTHORITY": "/run/x y", "HOME": "/h", "PULSE_SERVER": "unix:/p"}
    window = parse_unit(SystemdService("a", [], Path("/tmp"), False, there).text(version=254))
    assert window["WantedBy"] == window["PartOf"] == ["graphical-session.target"]
    assert window["Environment"] == ["PULSE_SERVER=unix:/p", "DISPLAY=:0", '"XAUTHORITY=/run/x y"']
    assert window["RestartMaxDelaySec"] == ["10s"]
    bare = parse_unit(SystemdService("a", [], Path("/tmp"), True, there).text(version=252))
    assert bare["WantedBy"] == ["default.target"]
    assert "PartOf" not in bare
    assert bare["Environment"] == ["PULSE_SERVER=unix:/p"]
    assert "RestartMaxDelaySec" not in bare


def test_engines_survive_crash_and_stop_ends_all_in_order():
    """KillMode=process: of a failed service systemd kills only the supervisor, which is already dead; on a stop it
    receives SIGTERM and ends the others.
    """
    found = parse_unit(SystemdService("a", [], Path("/tmp"), True, {}).text(version=252))
    assert (found["KillMode"], found["Restart"], found["OOMPolicy"]) == (["process"], ["on-failure"], ["continue"])
    assert set(found["SuccessExitStatus"][0].split()) == {"129", "130", "143"}
    assert found["RestartPreventExitStatus"] == ["2"]
    assert int(found["StartLimitBurst"][0]) > 0


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="needs systemd-analyze")
@pytest.mark.parametrize("headless", [True, False])
def test_systemd_verifies_unit_without_messages(tmp_path: Path, headless):
    service = SystemdService("a", ["my show.toml", "--bpm", "100%", "$HOME"], tmp_path, headless, dict(os.environ))
    path = tmp_path / service.unit
    path.write_text(service.text(version=252))
    done = subprocess.run(
        ["systemd-analyze", "--user", "verify", str(path)],
        env={**os.environ, "XDG_RUNTIME_DIR": str(tmp_path)}, capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.stderr == ""
    assert done.returncode == 0


def test_install_and_uninstall_write_and_remove_one_file(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    done = run_live("service", "install", "--name", "one", "contemporary", "--headless", "--audience", "--bpm", "120")
    assert done.returncode == 0, done.stderr
    path = tmp_path / "config" / "systemd" / "user" / "live-one.service"
    line = split_command_line(parse_unit(path.read_text())["ExecStart"][0])
    assert line[1:] == [
        "-m", "live", "play", "--service", "one", "contemporary", "--headless", "--audience", "127.0.0.1:8020",
        "--bpm", "120", "--journal", str(tmp_path / "state" / "choreographics-live" / "one.jsonl"),
    ]  # fmt: skip
    assert "one:" in run_live("service", "status").stdout
    assert run_live("service", "uninstall", "one").returncode == 0
    assert not path.exists()
    assert "no service" in run_live("service", "uninstall", "one").stderr


@pytest.mark.parametrize(
    "wrong", [["--no-such-option"], ["--bpm", "fast"], ["--alone"], ["--record=x.mp4"], ["--help"]]
)
def test_options_invalid_for_play_are_refused_before_writing(tmp_path: Path, monkeypatch, wrong):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    done = run_live("service", "install", "contemporary", *wrong)
    assert done.returncode in ((0, 2) if wrong == ["--help"] else (2,))
    assert not list(tmp_path.rglob("*.service"))
