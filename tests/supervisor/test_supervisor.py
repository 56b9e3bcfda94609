"""The supervisor with real processes that end in all ways: the next engine continues from the recorded lines."""

import errno
import json
import os
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from live.supervisor.heartbeat import Phase
from live.supervisor.process import ProcessManager
from live.supervisor.restart_policy import RestartLimit
from live.supervisor.supervisor import Supervisor
from live.supervisor.supervisor_config import SupervisorConfig
from tests.fixtures.mostly_long import mostly_long

ENGINE = [sys.executable, "-m", "tests.supervisor.made_engine"]


def run_supervisor(
    tmp_path: Path, plan: dict[str, Any], **how: Any
) -> tuple[int, list[dict[str, Any]], Supervisor, list[str]]:
    """Exit code, lines of the journal, the supervisor, and its messages."""
    said: list[str] = []
    orders = SupervisorConfig(
        engine=ENGINE, show=json.dumps(plan), journal=tmp_path / "j", **{"spare_after": 0.1, **how}
    )
    supervisor = Supervisor(orders, said.append)
    code = supervisor.run()
    path = tmp_path / "j"
    lines = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    return code, lines, supervisor, said


def event_numbers(lines: list[dict[str, Any]]) -> list[int]:
    return [line["event"]["number"] for line in lines if "event" in line]


def test_show_that_ends_normally_passes_exit_code_and_whole_journal(tmp_path):
    code, lines, supervisor, said = run_supervisor(tmp_path, {"ticks": 30, "pace": 0.001})
    assert code == 0
    assert event_numbers(lines) == list(range(1, 31))
    assert lines[-1] == {"tick": 30, "end": True}
    assert (supervisor.report.restarts, said) == (0, [])


@pytest.mark.parametrize("code", [0, 1, 2, 130])
def test_engine_that_ends_before_running_is_not_restarted(tmp_path, code):
    found, lines, supervisor, _ = run_supervisor(tmp_path, {"start": code})
    assert (found, lines, supervisor.report.restarts) == (code, [], 0)


@mostly_long("code", [0, 1, 2, 70, 130, 143], quick=[5])
def test_unannounced_end_is_crash_with_any_exit_code(tmp_path, code):
    """An uncaught exception in the engine once ended the show for good: it looked like a normal end."""
    found, lines, supervisor, said = run_supervisor(tmp_path, {"crashes": [[20, code]], "ticks": 40}, spare=False)
    assert found == 0
    assert event_numbers(lines) == list(range(1, 41))
    assert [line for line in lines if line.get("end")] == [lines[-1]]
    assert supervisor.report.restarts == 1
    assert "another one goes on in its place" in said[0]


@pytest.mark.long
def test_next_engine_receives_stage_and_tick_of_previous_deaths(tmp_path):
    plan = {"stage": 9, "crashes": [[20, 1], [20, 1], [20, 1], [30, 1]], "ticks": 40}
    _, lines, supervisor, _ = run_supervisor(tmp_path, plan, spare=False)
    deaths = [line["death"] for line in lines if "death" in line]
    assert [(death["tick"], death["stage"], death["times"], death["trip"]) for death in deaths] == [
        (20, 9, 1, False), (20, 9, 2, False), (20, 9, 3, True), (30, 9, 1, True),
    ]  # fmt: skip
    assert not supervisor.report.calm  # devices are not to blame


@pytest.mark.long
def test_engine_that_hangs_before_running_is_ended(tmp_path):
    """An endless tick that is run again by the next engine: it sends no heartbeat and does not dance yet."""
    plan = {"stage": 9, "crashes": [[20, 1]], "hangs_again": True, "ticks": 40}
    code, lines, supervisor, said = run_supervisor(tmp_path, plan, spare=False)
    assert code == 0
    assert event_numbers(lines) == list(range(1, 41))
    assert supervisor.report.restarts == 2
    assert any("no sign of life" in line for line in said)


@pytest.mark.long
def test_engine_with_cut_channel_does_not_write_beside_next_engine(tmp_path):
    """It takes its supervisor for dead and would continue the journal by itself. (Found by chaos: for 20 s it did,
    in the same file.)
    """
    plan = {"cuts": 60, "ticks": 160, "alone": 60.0, "journal": str(tmp_path / "j")}
    code, lines, supervisor, said = run_supervisor(tmp_path, plan, spare=False)
    assert code == 0
    assert event_numbers(lines) == sorted(set(event_numbers(lines)))
    assert set(range(1, 59)) | set(range(70, 161)) <= set(event_numbers(lines))
    assert [line for line in lines if line.get("end")] == [lines[-1]]
    assert supervisor.report.restarts == 1
    assert supervisor.report.takeover_s < 5.0
    assert "SIGKILL" in said[0]


def test_killed_engine_loses_no_line_and_spare_continues_from_last_line(tmp_path):
    """The supervisor had every line before the engine killed itself right after it."""
    code, lines, supervisor, said = run_supervisor(tmp_path, {"kills": [400], "ticks": 460})
    assert code == 0
    assert event_numbers(lines) == list(range(1, 461))
    assert [line["went"] for line in lines if "went" in line] == ["spare"]
    assert supervisor.report.restarts == 1
    assert supervisor.report.takeover_s is not None
    assert supervisor.report.takeover_s < 3.0
    assert "SIGKILL" in said[0]


def test_another_engine_is_started_when_no_spare_exists(tmp_path):
    code, lines, _, _ = run_supervisor(tmp_path, {"kills": [20], "ticks": 40}, spare=False)
    assert code == 0
    assert event_numbers(lines) == list(range(1, 41))
    assert [line["went"] for line in lines if "went" in line] == ["heir"]


@pytest.mark.long
def test_engine_start_is_retried_as_soon_as_system_has_room(tmp_path, monkeypatch):
    """Without descriptors the start was retried after five seconds, then ten."""
    started, refused = ProcessManager.start, []

    def start(self, role, *arguments, **how):
        if role == "heir" and len(refused) < 5:
            refused.append(role)
            raise OSError(errno.EMFILE, "Too many open files")
        return started(self, role, *arguments, **how)

    monkeypatch.setattr(ProcessManager, "start", start)
    code, lines, supervisor, _ = run_supervisor(tmp_path, {"crashes": [[20, 1]], "ticks": 40}, spare=False)
    assert code == 0
    assert event_numbers(lines) == list(range(1, 41))
    assert len(refused) == 5
    assert supervisor.report.takeover_s < 4.5


@pytest.mark.long
def test_auxiliary_process_start_failure_is_retried_while_show_runs(tmp_path, monkeypatch):
    """One start of the OSC reader without descriptors once ended the supervisor."""
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
        code, lines, supervisor, _ = run_supervisor(
            tmp_path, plan, spare=False, audio=sleeper, fallback_window=sleeper, **reader
        )
    assert code == 0
    assert event_numbers(lines) == list(range(1, 151))
    assert sorted(refused) == ["OSC", "audio", "guard"]
    assert (supervisor.audio.restarts, supervisor.fallback_window.restarts, supervisor.osc_reader.restarts) == (1, 1, 1)


@pytest.mark.long
def test_osc_reader_takes_no_processor_from_an_engine_that_starts(tmp_path, monkeypatch):
    started, phases = ProcessManager.start, []
    engines = []

    def start(self, role, *arguments, **how):
        child = started(self, role, *arguments, **how)
        if role == "engine":
            engines.append(child)
        elif role == "OSC":
            phases.append(engines[0].phase)
        return child

    monkeypatch.setattr(ProcessManager, "start", start)
    sleeper = [sys.executable, "-c", "import time; time.sleep(60)"]
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:
        reader = {"osc": port, "osc_reader": sleeper}
        code, *_ = run_supervisor(tmp_path, {"ticks": 60, "pace": 0.02}, spare=False, **reader)
    assert code == 0
    assert phases == [Phase.RUNNING]


def test_engine_without_heartbeat_is_killed_and_replaced(tmp_path):
    code, lines, supervisor, said = run_supervisor(tmp_path, {"hangs": 120, "ticks": 160})
    assert code == 0
    assert event_numbers(lines) == list(range(1, 161))
    assert supervisor.report.restarts == 1
    assert ["no sign of life" in line for line in said] == [True, False, False]


@pytest.mark.long
def test_three_restarts_in_thirty_seconds_make_show_calm(tmp_path, monkeypatch):
    monkeypatch.setattr("live.supervisor.engine_failover.CALM_RESTART_DELAY", 0.0)
    code, lines, supervisor, _ = run_supervisor(tmp_path, {"kills": [10, 20, 30, 40], "ticks": 50}, spare=False)
    assert code == 0
    assert event_numbers(lines) == list(range(1, 51))
    assert [line["calm"] for line in lines if "calm" in line] == [False, False, False, True]
    assert supervisor.report.calm


@pytest.mark.long
def test_slowly_starting_engines_that_crash_make_show_calm(tmp_path, monkeypatch):
    """Only seconds of dancing count: four crashes lie nearly two seconds apart here."""
    monkeypatch.setattr("live.supervisor.engine_failover.CALM_RESTART_DELAY", 0.0)
    monkeypatch.setattr("live.supervisor.engine_deaths.RestartLimit", lambda: RestartLimit(3, 2.0))
    plan = {"kills": [5, 10, 15, 20], "ticks": 25, "slow": 1.5}
    _, lines, _, _ = run_supervisor(tmp_path, plan, spare=False)
    assert [line["calm"] for line in lines if "calm" in line] == [False, False, False, True]


def test_supervisor_imports_no_array_window_or_device_library():
    heavy = ("numpy", "numba", "glfw", "moderngl", "sounddevice", "pydantic", "av", "alsa_midi", "jack")
    code = f"import sys, live.app.processes.engine_main; print([name for name in {heavy!r} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.long
def test_engines_killed_before_spare_is_ready_come_from_nursery(tmp_path):
    """Their parent is the supervisor, and their memory holds the nursery's process number."""
    plan = {"kills": [300, 302, 304], "ticks": 340}
    code, lines, supervisor, _ = run_supervisor(tmp_path, plan)
    assert code == 0
    assert event_numbers(lines) == list(range(1, 341))
    went = [line for line in lines if "went" in line]
    assert [line["parent"] for line in went] == [os.getpid()] * 3
    assert len({line["nursery"] for line in went}) == 1
    assert went[0]["nursery"] not in (None, os.getpid())
    assert supervisor.report.restarts == 3


@pytest.mark.long
def test_calm_show_takes_over_without_longer_gap(tmp_path, monkeypatch):
    """The first calm engine comes from the nursery like those before it, without a wait; a spare follows it.
    Only after crashes of calm engines does one start without the nursery, some seconds after the last.
    """
    monkeypatch.setattr("live.supervisor.engine_failover.CALM_RESTART_DELAY", 0.2)
    kills = [300, 302, 304, 306, 700, 702, 704]
    code, lines, supervisor, _ = run_supervisor(tmp_path, {"kills": kills, "ticks": 720})
    assert code == 0
    assert event_numbers(lines) == list(range(1, 721))
    went = [line for line in lines if "went" in line]
    assert [line["calm"] for line in went] == [False, False, False, True, True, True, True]
    assert len({line["nursery"] for line in went[:5]} | {None}) == 2
    assert all(line["nursery"] for line in went[:4])
    assert went[4]["went"] == "spare"
    assert went[-1]["nursery"] is None
    assert supervisor.report.restarts == 7


@pytest.mark.long
def test_killed_nursery_is_restarted_and_engines_start_without_it_meanwhile(tmp_path):
    code, lines, supervisor, _ = run_supervisor(tmp_path, {"kills": [300, 400], "ticks": 420, "nursery_dies": True})
    assert code == 0
    assert event_numbers(lines) == list(range(1, 421))
    assert supervisor.report.restarts == 2


@pytest.mark.long
def test_nursery_is_not_started_without_free_memory(tmp_path, monkeypatch):
    monkeypatch.setattr("live.supervisor.prefork.free_memory", lambda: 1_000_000)
    code, lines, _, _ = run_supervisor(tmp_path, {"kills": [200], "ticks": 240})
    assert code == 0
    assert [(line["went"], line["nursery"]) for line in lines if "went" in line] == [("spare", None)]
