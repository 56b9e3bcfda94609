"""The commands: a leader, a node that is killed and comes back, status, a restart, and a node that is refused."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest

from tests.control.waiting import wait_for
from tests.places import ROOT
from tests.supervisor.made_machines import free_port

pytest.importorskip("zenoh", reason="Eclipse Zenoh is not installed: pip install 'choreographics-live[nodes]'")
pytestmark = pytest.mark.long

SHOW = f"""name = "small"
steps = "{ROOT / "patches" / "steps"}"
[camera]
[[group]]
name = "front"
dancers = 3
size = [6.0, 2.0]
steps = ["groove", "side step"]
"""


class Cluster:
    """Processes of the commands, with keys of their own."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.port, self.processes = folder, free_port(), list[subprocess.Popen[bytes]]()
        self.show = folder / "show.toml"
        self.show.write_text(SHOW)
        self.env = {**os.environ, "LIVE_CONFIG_DIR": str(folder / "config")}

    def start(self, name: str, *words: str) -> "subprocess.Popen[bytes]":
        with (self.folder / name).open("wb") as said:
            command = [sys.executable, "-m", "live", *words]
            process = subprocess.Popen(command, stdout=said, stderr=said, env=self.env, start_new_session=True)
        self.processes.append(process)
        return process

    def node(self, name: str, show: Path | None = None) -> "subprocess.Popen[bytes]":
        words = ("--name", name, "--patch", str(show or self.show), "--headless")
        return self.start(name, "node", f"127.0.0.1:{self.port}", *words)

    def said(self, name: str) -> str:
        return (self.folder / name).read_text()

    def status(self) -> dict[str, dict[str, object]]:
        words = ("cluster", "status", "--json", "--leader", f"127.0.0.1:{self.port}")
        done = subprocess.run([sys.executable, "-m", "live", *words], capture_output=True, env=self.env, check=False)
        nodes = json.loads(done.stdout)["nodes"] if done.stdout else []
        return {node["name"]: node for node in nodes}

    def follows(self, name: str, *, process: object = None) -> bool:
        told = self.status().get(name, {})
        return told.get("state") == "follows" and told.get("process") != process

    def stop(self) -> None:
        for process in self.processes[::-1]:
            children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
            process.send_signal(signal.SIGINT)
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
            for child in children:
                if child.is_running():
                    child.kill()


@pytest.fixture
def cluster(tmp_path):
    made = Cluster(tmp_path)
    try:
        yield made
    finally:
        made.stop()


def test_node_follows_is_killed_comes_back_and_starts_again_on_order(cluster):
    nodes = ("--nodes", f"127.0.0.1:{cluster.port}")
    cluster.start("leader", "play", str(cluster.show), "--headless", "--bpm", "120", "--osc", "127.0.0.1:0", *nodes)
    keeper = cluster.node("left")
    assert wait_for(lambda: cluster.follows("left"), 90.0), cluster.said("left") + cluster.said("leader")
    first = cluster.status()["left"]
    assert first["different"] == 0
    assert abs(first["offset_ms"]) < 5.0  # both read the same clock
    min(psutil.Process(keeper.pid).children(), key=lambda child: child.pid).kill()  # the other one waits
    assert wait_for(lambda: cluster.follows("left", process=first["process"]), 60.0), cluster.said("left")
    second = cluster.status()["left"]
    done = subprocess.run(
        [sys.executable, "-m", "live", "cluster", "restart", "left", "--leader", f"127.0.0.1:{cluster.port}"],
        capture_output=True, env=cluster.env, check=False, timeout=90,
    )  # fmt: skip
    assert done.stdout == b"left is back\n", done.stderr
    assert cluster.status()["left"]["process"] not in (first["process"], second["process"])
    other = cluster.folder / "other.toml"
    other.write_text(SHOW.replace("dancers = 3", "dancers = 4"))
    refused = cluster.node("right", other)
    assert refused.wait(60) == 2
    assert "the leader plays another show" in cluster.said("right")
    assert wait_for(lambda: "node right: refused" in cluster.said("leader"), 10.0)
