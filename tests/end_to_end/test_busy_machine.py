"""A show beside three busy loops for each processor: it continues, and no process is killed for being slow."""

import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator

import pytest

from tests.supervisor.test_process_stats import PER_PROCESSOR, zombie_children

SECONDS = 75.0
BPM = 120.0


@pytest.fixture
def busy_machine() -> Iterator[None]:
    """Loops with the same priority as any other program."""
    loop = [sys.executable, "-S", "-c", "while True: pass"]
    count = PER_PROCESSOR * len(os.sched_getaffinity(0))
    loops = [subprocess.Popen(loop, start_new_session=True) for _ in range(count)]
    yield
    for one in loops:
        one.kill()
        one.wait()


def answers(port: int) -> bool:
    """Whether the page answers a request without its key with any status."""
    try:
        urllib.request.urlopen(f"http://127.0.0.1:{port}/", timeout=10.0).close()
    except urllib.error.HTTPError:
        return True
    except OSError:
        return False
    return True


@pytest.mark.soak
def test_show_of_24_dancers_continues_without_kills(play, request):
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    running = play("--bpm", f"{BPM:g}", "--headless", "--osc", "127.0.0.1:0", "--web", f"127.0.0.1:{port}")
    running.wait_for(lambda line: line["dancers"] == 24 and answers(port), 60)
    request.getfixturevalue("busy_machine")
    until, before, asked = time.monotonic() + SECONDS, running.lines()[-1], list[bool]()
    while time.monotonic() < until:
        assert running.process.poll() is None
        asked.append(answers(port))
        time.sleep(0.5)
    now = running.lines()[-1]
    assert (now["alive"]["restarts"], now["alive"]["calm"], now["alive"]["audio_restarts"]) == (0, False, 0)
    assert now["alive"]["slowdown"] > 2.0
    measures = (now["time"] - before["time"]) * BPM / 240.0
    assert now["measure"] - before["measure"] == pytest.approx(measures, abs=1.0)
    assert all(asked)
    assert zombie_children(running.process.pid) == []
    assert "no sign of life" not in running.stop()
