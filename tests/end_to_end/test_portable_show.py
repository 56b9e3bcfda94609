"""A show on a system like Windows: no descriptors to inherit, no fork, no /proc (`tests/base/system/foreign`)."""

import os
import signal
import socket
from pathlib import Path

import pytest

from live.show.patch.patch_search_path import PATCHES
from tests.base.system.foreign_system import foreign_environment
from tests.control.waiting import wait_for
from tests.end_to_end.conftest import children
from tests.end_to_end.test_alive import page_status, verify_journal, wait_for_spare
from tests.fixtures.two_monitor_x import TwoMonitorX


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])


def test_a_show_runs_and_leaves_a_whole_journal(play, patch: Path, tmp_path: Path):
    """Processes are started and not forked, and talk through what every system has."""
    journal = tmp_path / "j.jsonl"
    running = play(
        str(patch), "--bpm", "120", "--headless", "--osc", f"127.0.0.1:{free_port()}", "--journal", str(journal),
        env=foreign_environment(),
    )  # fmt: skip
    running.wait_for(lambda line: line["measure"] >= 2, 30)
    assert len(children(running, "engine_main")) >= 1
    assert "Traceback" not in running.stop()
    assert running.process.returncode == 130
    found = verify_journal(journal)
    assert found["complete"]
    assert found["measures"] >= 1


@pytest.mark.long
def test_the_next_engine_continues_show_music_and_pages(play, patch: Path, tmp_path: Path):
    """The supervisor has no sockets to give, so the engine itself plays the music and binds OSC."""
    journal, page = tmp_path / "j.jsonl", free_port()
    music = str(PATCHES / "music" / "first_show.ogg")
    running = play(
        str(patch), "--audio", music, "--headless", "--osc", f"127.0.0.1:{free_port()}", "--web", str(page),
        "--journal", str(journal), env=foreign_environment() | {"LIVE_CONFIG_DIR": str(tmp_path / "config")},
    )  # fmt: skip
    wait_for_spare(running)
    key = (tmp_path / "config" / "web-key").read_text().strip()
    assert wait_for(lambda: page_status(page, key) == 200, 20)
    before = running.lines()[-1]
    os.kill(children(running, "engine_main")[0], signal.SIGKILL)
    after = running.wait_for(
        lambda line: line["alive"].get("restarts") == 1 and line["measure"] > before["measure"], 30
    )
    beats = (after["time"] - before["time"]) * after["bpm"] / 60  # the music did not begin again
    assert after["measure"] - before["measure"] == pytest.approx(beats / 4, abs=1.0)
    assert wait_for(lambda: page_status(page, key) == 200, 30)
    processes = children(running, "process")
    assert "Traceback" not in running.stop()
    assert running.process.returncode == 130
    assert wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in processes), 5)
    found = verify_journal(journal)
    assert found["complete"]


@pytest.mark.long
@pytest.mark.x11
def test_the_fallback_window_covers_the_desktop(play, patch: Path, two_monitor_x: TwoMonitorX):
    two_monitor_x.plug_both()
    running = play(
        str(patch), "--bpm", "120", "--fullscreen", "--osc", f"127.0.0.1:{free_port()}",
        env=foreign_environment() | {"DISPLAY": two_monitor_x.display},
    )  # fmt: skip
    wait_for_spare(running)
    assert running.lines()[-1]["alive"]["guard"]
    os.kill(children(running, "fallback_window_main")[0], signal.SIGKILL)
    assert wait_for(lambda: bool(children(running, "fallback_window_main")), 10)
    frames = running.lines()[-1]["frames"]
    os.kill(children(running, "engine_main")[0], signal.SIGKILL)
    running.wait_for(lambda line: line["alive"].get("restarts") == 1 and line["frames"] != frames, 30)
    assert "Traceback" not in running.stop()
