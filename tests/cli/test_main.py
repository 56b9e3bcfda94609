"""The frame of the command line: help, version, errors and exit codes."""

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

import pytest
import typer

from live.base.errors import PersonError
from live.cli import main as main_module
from tests.cli.command import SIGNALS, run_live

COMMANDS = ("play", "render", "replay", "check", "devices", "doctor", "bench", "warm", "sync")


def test_help_lists_every_command() -> None:
    done = run_live("--help")
    assert done.returncode == 0, done.stderr
    for command in COMMANDS:
        assert f" {command} " in done.stdout


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command: str) -> None:
    done = run_live(command, "--help")
    assert done.returncode == 0, done.stderr
    assert f"live {command}" in done.stdout


def _commands(command: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    yield path, command
    for name, below in getattr(command, "commands", {}).items():
        yield from _commands(below, (*path, name))


def test_no_help_loses_what_stands_in_brackets() -> None:
    """Tables such as [[react]] and units such as [s] are text, not markup."""
    tree, seen = typer.main.get_command(main_module.app), 0
    for path, command in _commands(tree):
        texts = [getattr(each, "help", None) or "" for each in (command, *command.params)]
        wanted = {found for text in texts for found in re.findall(r"\[+[^\[\]]+\]+", text)}
        if wanted:
            shown = run_live(*path, "--help-all", COLUMNS="400").stdout
            assert {each for each in wanted if each not in shown} == set(), path
            seen += len(wanted)
    assert seen >= 4


def test_commands_are_listed_by_whom_they_are_for() -> None:
    shown = run_live("--help").stdout
    places = [shown.index(f"─ {panel} ─") for panel in main_module.PANELS]
    assert places == sorted(places)
    assert "─ Commands ─" not in shown
    for name in ("layout", "mocap"):  # of bridges
        assert shown.index(f" {name} ") > shown.index(main_module.HALL)


def test_version_is_installed_version() -> None:
    assert run_live("--version").stdout == f"live {version('choreographics-live')}\n"


def test_help_imports_no_heavy_package() -> None:
    heavy = ["numpy", "numba", "scipy", "moderngl", "glfw", "sounddevice", "mido", "av", "aubio", "pydantic"]
    code = f"import sys, live.cli.main; print(*[name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == []


def test_unknown_command_is_usage_error() -> None:
    done = run_live("dnace")
    assert done.returncode == 2
    assert "No such command 'dnace'" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.fixture(autouse=True)
def _signals() -> Iterator[None]:
    """`main` changes the signal handlers of the process."""
    before = {number: signal.getsignal(number) for number in SIGNALS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def _main_exit_code(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> int:
    def fail() -> None:
        raise error

    monkeypatch.setattr(main_module, "app", fail)
    with pytest.raises(SystemExit) as stopped:
        main_module.main()
    assert isinstance(stopped.value.code, int)
    return stopped.value.code


def test_person_error_is_one_line_with_remedy(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    error = PersonError("no monitor [red]9[/]:\nthere are 1 and 2" + " x" * 100, "--monitor 1")
    assert _main_exit_code(monkeypatch, error) == 2
    first, second, rest = capsys.readouterr().err.split("\n", 2)
    assert first == "error: no monitor [red]9[/]: there are 1 and 2" + " x" * 100
    assert second.strip() == "try: --monitor 1"
    assert rest == ""


def test_other_errors_propagate(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail() -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(main_module, "app", fail)
    with pytest.raises(ZeroDivisionError):
        main_module.main()


def test_ctrl_c_exits_quietly_with_130(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    assert _main_exit_code(monkeypatch, KeyboardInterrupt()) == 128 + signal.SIGINT
    assert capsys.readouterr().err == ""


def test_ctrl_c_within_command_exits_with_130() -> None:
    code = """
import os, signal, sys
from live.cli import main
main.app.command("wait")(lambda: (os.kill(os.getpid(), signal.SIGINT), signal.pause()))
sys.argv = ["live", "wait"]
main.main()
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (130, "")


@pytest.mark.long
def test_help_of_play_shows_what_many_need_and_all_on_request():
    short, whole = (run_live("play", word).stdout for word in ("--help", "--help-all"))
    options = [set(re.findall(r"│ (--[a-z-]+)", text)) for text in (short, whole)]
    assert {"--audio", "--fullscreen", "--journal"} <= options[0] < options[1]
    assert len(options[0]) < len(options[1]) / 2
    assert "live play --help-all" in short
    assert "--help-all" not in whole
    assert run_live("play", "--dmx").returncode == 2  # what help leaves out is there
