"""The programs of the programmers' tutorial run against a show, as they stand on its page."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.documentation.snippets import snippets

pytestmark = [pytest.mark.long, pytest.mark.xdist_group("tour")]

PAGE = "docs/tutorials/programmer.md"
ASK, LISTEN, JOURNAL, MOTION, PEDAL = (each.text for each in snippets("python") if each.page == PAGE)
DEADLINE = 120.0
METADATA = "Metadata-Version: 2.1\nName: live-pedal\nVersion: 1.0\n"


def start_show(folder: Path, *words: str, **environment: str) -> "subprocess.Popen[bytes]":
    return subprocess.Popen(
        [sys.executable, "-m", "live", "play", *words, "--headless"], cwd=folder, env={**os.environ, **environment},
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip


def end_show(show: "subprocess.Popen[bytes]") -> None:
    show.send_signal(signal.SIGINT)
    _, said = show.communicate(timeout=DEADLINE)
    assert show.returncode in (0, 130), said.decode()  # 130: Ctrl-C


def run_program(folder: Path, text: str) -> str:
    done = subprocess.run([sys.executable, "-c", text], cwd=folder, capture_output=True, text=True, timeout=DEADLINE)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_programs_talk_to_a_show_and_read_what_it_leaves(tmp_path: Path) -> None:
    show = start_show(tmp_path, "first_show", "--osc-out", "127.0.0.1:9020", "--journal", "night.jsonl")
    try:
        assert "\nmeasure " in run_program(tmp_path, LISTEN.replace("server.timeout = 10", "server.timeout = 60"))
        assert run_program(tmp_path, ASK).startswith("/dance/clock/tempo ")
    finally:
        end_show(show)
    assert "BeatHeard" in run_program(tmp_path, JOURNAL)
    render = [
        sys.executable,
        "-m",
        "live",
        "render",
        "first_show",
        "--out",
        "show.glb",
        "--fps",
        "30",
        "--seconds",
        "2",
    ]
    subprocess.run(render, cwd=tmp_path, check=True, capture_output=True, timeout=DEADLINE)
    ways = run_program(tmp_path, MOTION).splitlines()
    assert len(ways) == 24
    assert all(" m in 2 s" in way for way in ways)


def test_a_bridge_of_a_readers_own_is_found_and_acts(tmp_path: Path) -> None:
    """The package stands beside the program, as an installer leaves it."""
    (tmp_path / "live_pedal.py").write_text(PEDAL)
    facts = tmp_path / "live_pedal-1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text(METADATA)
    (facts / "entry_points.txt").write_text("[live.bridges]\npedal = live_pedal\n")
    with socket.socket(type=socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = ("cues", "--pedal", str(port), "--journal", "cues.jsonl")
    show, journal = start_show(tmp_path, *words, PYTHONPATH=str(tmp_path)), tmp_path / "cues.jsonl"
    try:
        end = time.monotonic() + DEADLINE
        with socket.socket(type=socket.SOCK_DGRAM) as pedal:
            while not (journal.is_file() and '"Go"' in journal.read_text()):
                assert time.monotonic() < end, "no cue was given"
                pedal.sendto(b"go", ("127.0.0.1", port))
                assert show.poll() is None
                pedal.settimeout(0.2)
                with pytest.raises(TimeoutError):
                    pedal.recv(1)
    finally:
        end_show(show)
