"""The supervisor with real processes that end in all ways: what one had said another goes on from."""

import errno
import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from live.supervisor.process import ProcessManager
from live.supervisor.restart_policy import RestartLimit
from live.supervisor.supervisor import Supervisor
from live.supervisor.supervisor_config import SupervisorConfig

ENGINE = [sys.executable, "-m", "tests.supervisor.made_engine"]


def supervised(
    tmp_path: Path, plan: dict[str, Any], **how: Any
) -> tuple[int, list[dict[str, Any]], Supervisor, list[str]]:
    """Exit code, lines of the journal, the supervisor, and what it said."""
    said: list[str] = []
    orders = SupervisorConfig(
        engine=ENGINE, show=json.dumps(plan), journal=tmp_path / "j", **{"spare_after": 0.1, **how}
    )
    supervisor = Supervisor(orders, said.append)
    code = supervisor.run()
    path = tmp_path / "j"
    lines = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return code, lines, supervisor, said


def numbers(lines: list[dict[str, Any]]) -> list[int]:
    return [line["event"]["number"] for line in lines if "event" in line]


def test_a_show_that_ends_well_ends_the_supervisor_with_its_code_and_leaves_a_whole_journal(tmp_path):
    code, lines, supervisor, said = supervised(tmp_path, {"ticks": 30, "pace": 0.001})
    assert code == 0
    assert numbers(lines) == list(range(1, 31))
    assert lines[-1] == {"tick": 30, "end": True}
    assert (supervisor.report.restarts, said) == (0, [])


@pytest.mark.parametrize("code", [0, 1, 2, 130])
def test_an_engine_that_ends_before_it_runs_is_not_started_again(tmp_path, code):
    found, lines, supervisor, _ = supervised(tmp_path, {"start": code})
    assert (found, lines, supervisor.report.restarts) == (code, [], 0)


@pytest.mark.parametrize("code", [0, 1, 2, 70, 130, 143])
def test_an_end_that_nobody_told_of_is_a_crash_whatever_its_code(tmp_path, code):
    """An uncaught exception in the engine ended the show for good: it had left the loop and seemed to be leaving."""
    found, lines, supervisor, said = supervised(tmp_path, {"crashes": [[20, code]], "ticks": 40}, spare=False)
    assert found == 0
    assert numbers(lines) == list(range(1, 41))
    assert [line for line in lines if line.get("end")] == [lines[-1]]
    assert supervisor.report.restarts == 1
    assert "another one goes on in its place" in said[0]


def test_the_next_engine_is_told_in_which_stage_of_which_tick_others_ended(tmp_path):
    plan = {"stage": 9, "crashes": [[20, 1], [20, 1], [20, 1], [30, 1]], "ticks": 40}
    _, lines, supervisor, _ = supervised(tmp_path, plan, spare=False)
    deaths = [line["death"] for line in lines if "death" in line]
    assert [(death["tick"], death["stage"], death["times"], death["trip"]) for death in deaths] == [
        (20, 9, 1, False), (20, 9, 2, False), (20, 9, 3, True), (30, 9, 1, True),
    ]  # fmt: skip
    assert not supervisor.report.calm  # devices are not to blame


def test_who_hangs_before_it_dances_is_ended_as_well(tmp_path):
    """A tick without end that is run again by who goes on: it says nothing, and it does not dance yet."""
    plan = {"stage": 9, "crashes": [[20, 1]], "hangs_again": True, "ticks": 40}
    code, lines, supervisor, said = supervised(tmp_path, plan, spare=False)
    assert code == 0
    assert numbers(lines) == list(range(1, 41))
    assert supervisor.report.restarts == 2
    assert any("no sign of life" in line for line in said)


def test_an_engine_whose_wire_is_cut_does_not_dance_and_write_beside_the_next_one(tmp_path):
    """It takes its supervisor for dead, and would go on with the journal by itself. (Found by chaos: for 20 s it did,
    in the same file.)"""
    plan = {"cuts": 60, "ticks": 160, "alone": 60.0, "journal": str(tmp_path / "j")}
    code, lines, supervisor, said = supervised(tmp_path, plan, spare=False)
    assert code == 0
    assert numbers(lines) == sorted(set(numbers(lines)))
    assert set(range(1, 59)) | set(range(70, 161)) <= set(numbers(lines))
    assert [line for line in lines if line.get("end")] == [lines[-1]]
    assert supervisor.report.restarts == 1
    assert supervisor.report.takeover_s < 5.0
    assert "SIGKILL" in said[0]


def test_a_killed_engine_has_lost_no_line_and_the_spare_goes_on_from_the_last_one(tmp_path):
    """Every line was with the supervisor before the engine killed itself right after it."""
    code, lines, supervisor, said = supervised(tmp_path, {"kills": [200], "ticks": 260})
    assert code == 0
    assert numbers(lines) == list(range(1, 261))
    assert [line["went"] for line in lines if "went" in line] == ["spare"]
    assert supervisor.report.restarts == 1
    assert supervisor.report.takeover_s is not None
    assert supervisor.report.takeover_s < 3.0
    assert "SIGKILL" in said[0]


def test_without_a_spare_another_engine_is_started_and_goes_on(tmp_path):
    code, lines, _, _ = supervised(tmp_path, {"kills": [20], "ticks": 40}, spare=False)
    assert code == 0
    assert numbers(lines) == list(range(1, 41))
    assert [line["went"] for line in lines if "went" in line] == ["heir"]


def test_where_the_system_has_no_room_for_an_engine_the_next_begins_as_soon_as_there_is(tmp_path, monkeypatch):
    """Without descriptors it was tried again after five seconds, then ten."""
    started, refused = ProcessManager.start, []

    def start(self, role, *arguments, **how):
        if role == "heir" and len(refused) < 5:
            refused.append(role)
            raise OSError(errno.EMFILE, "Too many open files")
        return started(self, role, *arguments, **how)

    monkeypatch.setattr(ProcessManager, "start", start)
    code, lines, supervisor, _ = supervised(tmp_path, {"crashes": [[20, 1]], "ticks": 40}, spare=False)
    assert code == 0
    assert numbers(lines) == list(range(1, 41))
    assert len(refused) == 5
    assert supervisor.report.takeover_s < 4.5


def test_where_the_system_has_no_room_for_the_other_processes_the_show_runs_and_they_come_later(tmp_path, monkeypatch):
    """One start of the OSC reader without descriptors ended the supervisor."""
    started, refused = ProcessManager.start, []

    def start(self, role, *arguments, **how):
        if role != "engine" and role not in refused:
            refused.append(role)
            raise OSError(errno.EMFILE, "Too many open files")
        return started(self, role, *arguments, **how)

    monkeypatch.setattr(ProcessManager, "start", start)
    sleeper = [sys.executable, "-c", "import time; time.sleep(60)"]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        reader = {"osc": port, "osc_reader": sleeper}
        plan = {"ticks": 150, "pace": 0.02}
        code, lines, supervisor, _ = supervised(
            tmp_path, plan, spare=False, audio=sleeper, fallback_window=sleeper, **reader
        )
    assert code == 0
    assert numbers(lines) == list(range(1, 151))
    assert sorted(refused) == ["OSC", "audio", "guard"]
    assert (supervisor.audio.restarts, supervisor.fallback_window.restarts, supervisor.osc_reader.restarts) == (1, 1, 1)


def test_an_engine_that_gives_no_sign_of_life_is_killed_and_replaced(tmp_path):
    code, lines, supervisor, said = supervised(tmp_path, {"hangs": 120, "ticks": 160})
    assert code == 0
    assert numbers(lines) == list(range(1, 161))
    assert supervisor.report.restarts == 1
    assert ["no sign of life" in line for line in said] == [True, False, False]


def test_after_three_restarts_in_thirty_seconds_the_show_is_calmer(tmp_path, monkeypatch):
    monkeypatch.setattr("live.supervisor.engine_failover.CALM_RESTART_DELAY", 0.0)
    code, lines, supervisor, _ = supervised(tmp_path, {"kills": [10, 20, 30, 40], "ticks": 50}, spare=False)
    assert code == 0
    assert numbers(lines) == list(range(1, 51))
    assert [line["calm"] for line in lines if "calm" in line] == [False, False, False, True]
    assert supervisor.report.calm


@pytest.mark.long
def test_engines_that_begin_slowly_and_crash_at_once_make_a_show_calmer_too(tmp_path, monkeypatch):
    """Only seconds in which somebody danced count: four crashes lie nearly two seconds apart here."""
    monkeypatch.setattr("live.supervisor.engine_failover.CALM_RESTART_DELAY", 0.0)
    monkeypatch.setattr("live.supervisor.engine_deaths.RestartLimit", lambda: RestartLimit(3, 2.0))
    plan = {"kills": [5, 10, 15, 20], "ticks": 25, "slow": 1.5}
    _, lines, _, _ = supervised(tmp_path, plan, spare=False)
    assert [line["calm"] for line in lines if "calm" in line] == [False, False, False, True]


def test_the_supervisor_needs_no_array_no_window_and_no_device():
    heavy = ("numpy", "numba", "glfw", "moderngl", "sounddevice", "pydantic", "av", "rtmidi")
    code = f"import sys, live.app.processes.engine_main; print([name for name in {heavy!r} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_engines_killed_again_and_again_before_a_spare_is_ready_come_out_of_the_nursery(tmp_path):
    """Their parent is the supervisor, and their memory holds what the nursery had loaded: its number."""
    plan = {"kills": [300, 302, 304], "ticks": 340}
    code, lines, supervisor, _ = supervised(tmp_path, plan)
    assert code == 0
    assert numbers(lines) == list(range(1, 341))
    went = [line for line in lines if "went" in line]
    assert [line["parent"] for line in went] == [os.getpid()] * 3
    assert len({line["nursery"] for line in went}) == 1
    assert went[0]["nursery"] not in (None, os.getpid())
    assert supervisor.report.restarts == 3


def test_a_show_that_becomes_calmer_is_not_dark_for_longer(tmp_path, monkeypatch):
    """The first calm engine comes out of the nursery like those before it, and is not waited for; a spare waits for it,
    too. Only where calm engines crash as well does one begin without the nursery, some seconds after the last."""
    monkeypatch.setattr("live.supervisor.engine_failover.CALM_RESTART_DELAY", 0.2)
    kills = [300, 302, 304, 306, 700, 702, 704]
    code, lines, supervisor, _ = supervised(tmp_path, {"kills": kills, "ticks": 720})
    assert code == 0
    assert numbers(lines) == list(range(1, 721))
    went = [line for line in lines if "went" in line]
    assert [line["calm"] for line in went] == [False, False, False, True, True, True, True]
    assert len({line["nursery"] for line in went[:5]} | {None}) == 2
    assert all(line["nursery"] for line in went[:4])
    assert went[4]["went"] == "spare"
    assert went[-1]["nursery"] is None
    assert supervisor.report.restarts == 7


def test_a_nursery_that_is_killed_is_begun_again_and_engines_begin_without_it_meanwhile(tmp_path):
    code, lines, supervisor, _ = supervised(tmp_path, {"kills": [300, 400], "ticks": 420, "nursery_dies": True})
    assert code == 0
    assert numbers(lines) == list(range(1, 421))
    assert supervisor.report.restarts == 2


def test_without_room_there_is_no_nursery(tmp_path, monkeypatch):
    monkeypatch.setattr("live.supervisor.prefork.free_memory", lambda: 1_000_000)
    code, lines, _, _ = supervised(tmp_path, {"kills": [200], "ticks": 240})
    assert code == 0
    assert [(line["went"], line["nursery"]) for line in lines if "went" in line] == [("spare", None)]
