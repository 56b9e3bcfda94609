"""Rows of the cluster bench: render nodes that present the same ticks as their leader's schedule.

Leader and nodes are processes of the real commands, on loopback. Each node reaches the leader through a relay that
holds every piece of data back for a random time, and for longer where a packet would have been lost and sent again: TCP
hides loss as delay. (The kernel's own emulation is not used, because few machines have it.) Half of the nodes have
clocks that run 100 ppm fast or slow and are two seconds off.

A node writes for each frame the true time and the tick: the machine's clock is the leader's, and only the clock that
the node is given is wrong. So each frame is compared with the schedule in true time.
"""

import asyncio
import contextlib
import itertools
import json
import os
import random
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, Final

import psutil
from pythonosc.osc_message_builder import OscMessageBuilder

from live.cli.bench import Row
from live.clock.ticks import TICK

PATIENCE: Final = 120.0
TOLERANCE: Final = 0.002
"""A frame is right if its tick was the schedule's at some moment within this [s] of it."""
DRIFT: Final = 1e-4
OFFSET: Final = 2.0
JITTER: Final = 0.005
LOSS: Final = 0.01
SETTLES: Final = 15.0
"""Seconds in which clocks are learnt, and each node's spare process is loaded."""
ANEW: Final = 5
CUT_OFF: Final = 1.0
"""So often a node is cut off, and for this long before and after an event that it misses [s]."""
RESENT_AFTER: Final = 0.03
"""Seconds until a lost packet has been sent again, when more follow it (RFC 8985)."""
SHOW: Final = """name = "small"
steps = "{steps}"
[camera]
[[group]]
name = "front"
dancers = {dancers}
size = [6.0, 2.0]
steps = ["groove", "side step", "samba"]
"""


def rows(full: bool) -> list[Row]:
    """Rows of two nodes, with `full` also of four, eight, two that draw, and one that takes the show anew."""
    found: list[Row] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        alone = _leader_load(folder / "alone", seconds=10.0 if full else 5.0)
        for count in (2, 4, 8) if full else (2,):
            found += _measure(folder / str(count), count, 60.0 if full else 10.0, alone=alone)
        if full:
            found += _measure(folder / "drawn", 2, 30.0, draws=True)
            found.append(_joined_anew(folder / "anew"))
    return found


def _measure(
    folder: Path, count: int, seconds: float, *, alone: float | None = None, draws: bool = False
) -> list[Row]:  # fmt: skip
    """Rows of so many nodes over so many seconds. `alone`: the leader's load without nodes."""
    folder.mkdir()
    words = f"{count} nodes that {'draw 320x180' if draws else 'present without drawing'}"
    with _leading(folder) as leader, contextlib.ExitStack() as stack:
        begun = time.perf_counter()
        nodes = [stack.enter_context(_node(folder, number, draws=draws)) for number in range(count)]
        for node in nodes:
            _until(partial(_has_drawn, folder, node.number), f"node {node.number}")
        joined = max(_first(folder, node.number) for node in nodes)
        time.sleep(SETTLES)
        since, load = time.perf_counter(), _processor_time(leader)
        time.sleep(seconds)
        load = (_processor_time(leader) - load) / (time.perf_counter() - since)
        origin = _origin(folder)
        shares, drifts, missed = [], [], []
        for node in nodes:
            frames = [each for each in _frames(folder, node.number) if each[0] >= since]
            shares.append(sum(_is_right(at, tick, origin) for at, tick in frames) / max(len(frames), 1))
            drifts.append(_drift(frames, origin))
            missed.append(_missed(frames))
        found = [
            Row(f"{words}: frames with the schedule's tick within 2 ms, worst", min(shares), "", 0.999, "at least",
                peers={} if draws else {"ticks that no frame showed, worst": max(missed)}),
            Row(f"{words}: change of lateness from the first to the last third", max(map(abs, drifts)), "ms", 2.0),
            Row(f"{words}: from connection to the first frame", joined - begun if joined else None, "s",
                note="with the start of the processes"),
        ]  # fmt: skip
        if alone is not None:
            found.append(
                Row(f"{words}: leader's processor time over that without nodes", load / alone, "", 1.1,
                    peers={"without, s/s": alone})
            )  # fmt: skip
        if not draws and count == 2:
            found += _killed(folder, nodes[0])
    return found


def _killed(folder: Path, node: "Node") -> list[Row]:
    """A node is killed: how long until its next frame."""
    last = _frames(folder, node.number)[-1][0]
    os.kill(node.child(), signal.SIGKILL)
    _until(lambda: _frames(folder, node.number)[-1][0] > last + 0.3, "the node that was killed")
    gap = max(after[0] - before[0] for before, after in itertools.pairwise(_frames(folder, node.number)))
    log = _joins(folder, node.number)
    return [
        Row("a node is killed: to its next frame", gap, "s", 5.0),
        Row("a node joins: from the leader's first pulse to the first frame", log[0]["joined_s"], "s", 3.0),
    ]


def _joined_anew(folder: Path) -> Row:
    """A node of 24 dancers hears nothing for a while, misses an event, and takes the show anew while it draws on."""
    folder.mkdir()
    gaps, busy = [], []
    with _leading(folder, dancers=24), _node(folder, 0, draws=False) as node:
        _until(partial(_has_drawn, folder, 0), "the node")
        time.sleep(SETTLES)
        usual = max(_gaps(_frames(folder, 0)[-500:]))
        for times in range(1, ANEW + 1):
            os.kill(node.process.pid, signal.SIGSTOP)  # its relay
            time.sleep(CUT_OFF)
            _send_osc(folder, "/dance/clock/tempo", 110.0 + 2 * times)
            time.sleep(CUT_OFF)
            since = time.perf_counter()
            os.kill(node.process.pid, signal.SIGCONT)
            _until(lambda: len(_joins(folder, 0)) > times, "the snapshot")  # noqa: B023 (called at once)
            time.sleep(2.0)
            gaps.append(max(_gaps([each for each in _frames(folder, 0) if each[0] >= since])))
            busy += [after[2] - before[2] for before, after in itertools.pairwise(_loads(folder, 0, since))]
    return Row(
        f"a node of 24 dancers takes the show anew, {ANEW} times: longest time between two frames", 1e3 * max(gaps),
        "ms", 50.0,
        peers={
            "before, while it follows": 1e3 * usual, "processor time of the process in between, most": 1e3 * max(busy),
        },
    )  # fmt: skip


def _gaps(frames: list[tuple[float, int]]) -> list[float]:
    return [after[0] - before[0] for before, after in itertools.pairwise(frames)]


def _send_osc(folder: Path, address: str, value: float) -> None:
    builder = OscMessageBuilder(address)
    builder.add_arg(value)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(builder.build().dgram, ("127.0.0.1", _port(folder, "osc")))


def _is_right(at: float, tick: int, origin: float) -> bool:
    low, high = (int((at + off - origin) / TICK) for off in (-TOLERANCE, TOLERANCE))
    return low <= tick <= high


def _missed(frames: list[tuple[float, int]]) -> float:
    """Share of the ticks from the first frame to the last that no frame showed."""
    ticks = {tick for _, tick in frames}
    return 1.0 - len(ticks) / (max(ticks) - min(ticks) + 1) if ticks else 1.0


def _drift(frames: list[tuple[float, int]], origin: float) -> float:
    """Change of the median lateness [ms] from the first third of the frames to the last."""
    late = [1e3 * (at - origin - tick * TICK) for at, tick in frames]
    third = max(len(late) // 3, 1)
    return statistics.median(late[-third:]) - statistics.median(late[:third])


class Node:
    """A node's keeper, and what is needed to find its process."""

    def __init__(self, folder: Path, number: int, process: "subprocess.Popen[bytes]") -> None:
        self.folder, self.number, self.process = folder, number, process

    def child(self) -> int:
        """The process that follows."""
        return int(_joins(self.folder, self.number)[-1]["process"])


def _port(folder: Path, name: str = "port") -> int:
    path = folder / name
    if not path.exists():
        with socket.create_server(("127.0.0.1", 0)) as free:
            path.write_text(str(free.getsockname()[1]))
    return int(path.read_text())


@contextlib.contextmanager
def _leading(folder: Path, *how: str, dancers: int = 4) -> Iterator["subprocess.Popen[bytes]"]:
    """A leader of a small show, once it plays."""
    show = folder / "show.toml"
    show.write_text(SHOW.format(steps=Path("patches/steps").resolve(), dancers=dancers))
    osc = f"127.0.0.1:{_port(folder, 'osc')}"
    options = ["--headless", "--bpm", "120", "--osc", osc, "--journal", str(folder / "journal.jsonl")]
    options += how or ("--nodes", f"127.0.0.1:{_port(folder)}")
    with (folder / "leader.said").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "live", "play", str(show), *options],
            stdout=said,
            stderr=said,
            start_new_session=True,
        )
    try:
        _until(lambda: (folder / "journal.jsonl").exists() and _origin(folder) > 0.0, "the leader")
        time.sleep(4.0)  # its spare engine has started
        yield process
    finally:
        _end(process)


@contextlib.contextmanager
def _node(folder: Path, number: int, *, draws: bool) -> Iterator[Node]:
    """A node with a relay of its own."""
    skew = (0.0, 0.0) if number % 2 == 0 else ((1 if number % 4 == 1 else -1) * DRIFT, OFFSET)
    plan = json.dumps([str(folder), number, _port(folder), *skew, draws])
    with (folder / f"node-{number}.said").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, "-m", "bench._cluster_nodes", "node", plan],
            stdout=said,
            stderr=said,
            start_new_session=True,
        )
    try:
        yield Node(folder, number, process)
    finally:
        _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    children = psutil.Process(process.pid).children(recursive=True) if process.poll() is None else []
    process.send_signal(signal.SIGINT)
    try:
        process.wait(20.0)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    for one in children:
        with contextlib.suppress(psutil.NoSuchProcess):
            one.kill()


def _processor_time(process: "subprocess.Popen[bytes]") -> float:
    """Processor seconds of a leader: its supervisor and its engine."""
    total = 0.0
    for one in [psutil.Process(process.pid), *psutil.Process(process.pid).children()]:
        with contextlib.suppress(psutil.NoSuchProcess):
            times = one.cpu_times()
            total += times.user + times.system
    return total


def _leader_load(folder: Path, seconds: float) -> float:
    """Processor seconds per second of a leader that other machines could follow, without any."""
    folder.mkdir()
    with _leading(folder, "--lead", f"127.0.0.1:{_port(folder)}") as leader:
        time.sleep(5.0)
        since, load = time.perf_counter(), _processor_time(leader)
        time.sleep(seconds)
        return (_processor_time(leader) - load) / (time.perf_counter() - since)


def _origin(folder: Path) -> float:
    with (folder / "journal.jsonl").open(encoding="utf-8") as file:
        line = file.readline()
    return float(json.loads(line)["origin"]) if line.endswith("\n") else 0.0


def _frames(folder: Path, number: int) -> list[tuple[float, int]]:
    """All frames of a node so far: true time [s] and tick."""
    return [(at, tick) for at, tick, _ in _loads(folder, number, 0.0)]


def _loads(folder: Path, number: int, since: float) -> list[tuple[float, int, float]]:
    """Frames of a node from `since` on: true time [s], tick, and processor time of its process so far [s]."""
    path = folder / f"frames-{number}"
    text = path.read_text() if path.exists() else ""
    rows = (line.split() for line in text.splitlines(keepends=True) if line.endswith("\n"))
    return [(float(at), int(tick), float(load)) for at, tick, load in rows if float(at) >= since]


def _joins(folder: Path, number: int) -> list[dict[str, Any]]:
    """What a node has noted of each time that it began with a snapshot."""
    path = folder / f"joins-{number}"
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def _has_drawn(folder: Path, number: int) -> bool:
    return bool(_frames(folder, number))


def _first(folder: Path, number: int) -> float:
    return _frames(folder, number)[0][0]


def _until(holds: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError(f"waited {PATIENCE:.0f} s for {what}")
        time.sleep(0.05)


# -- in a node's processes -------------------------------------------------------------------------------------------


async def _relay(here: int, there: int, seed: int) -> None:
    """Pass connections on, with delays."""
    chance = random.Random(seed)

    async def pump(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        loop, due = asyncio.get_running_loop(), 0.0
        with contextlib.suppress(OSError):
            while data := await reader.read(1 << 16):
                wait = chance.random() * JITTER + (RESENT_AFTER if chance.random() < LOSS else 0.0)
                due = max(due, loop.time() + wait)  # TCP keeps the order
                loop.call_at(due, _write, writer, data)
        loop.call_at(max(due, loop.time()), writer.close)

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            back, on = await asyncio.open_connection("127.0.0.1", there)
        except OSError:
            writer.close()
            return
        await asyncio.gather(pump(reader, on), pump(back, writer))

    server = await asyncio.start_server(serve, "127.0.0.1", here)
    await server.serve_forever()


def _write(writer: asyncio.StreamWriter, data: bytes) -> None:
    with contextlib.suppress(OSError):
        writer.write(data)


def node_main(word: str) -> int:
    """Keep a node running, behind a relay."""
    import threading

    from live.app.processes import node_main as process
    from live.supervisor.cpu_priority import ENGINE_NICE, raise_priority

    folder, number, port, drift, offset, draws = json.loads(word)
    raise_priority(ENGINE_NICE)  # the delays are those that are asked for, not those of a busy machine
    with socket.create_server(("127.0.0.1", 0)) as free:
        mine = int(free.getsockname()[1])
    threading.Thread(target=lambda: asyncio.run(_relay(mine, port, number)), daemon=True).start()
    options = _options(Path(folder), number, draws=draws)
    command = [sys.executable, "-m", "bench._cluster_nodes", "node_child", folder, str(number), str(drift), str(offset)]
    return process.keep_node(process.NodePlan(options, (("127.0.0.1", mine),)), command)


def _options(folder: Path, number: int, *, draws: bool) -> Any:
    from live.app.launch_options import LaunchOptions

    return LaunchOptions(
        patch=str(folder / "show.toml"), headless=True, node=f"node-{number}", size=(320, 180),
        share=(f"shm:bench-{os.getpid()}-{number}",) if draws else (), fps=30.0 if draws else None,
    )  # fmt: skip


def child_main(folder: Path, number: int, drift: float, offset: float) -> None:
    """Follow, with a clock that is wrong, and note each frame in true time."""
    from live.app.processes import node_main as process
    from live.nodes.follower import NodeFollower, Phase, Presentation

    base = time.perf_counter()

    def skewed() -> float:
        now = time.perf_counter()
        return now + offset + drift * (now - base)

    noted = (folder / f"frames-{number}").open("a", buffering=1)
    present, hear = NodeFollower.present, NodeFollower._hear_pulse
    first: list[float] = []
    joined = 0

    def hear_pulse(self: NodeFollower, pulse: Any, now: float) -> None:
        if not first:
            first.append(time.perf_counter())
        hear(self, pulse, now)

    def noting(self: NodeFollower, lead: float) -> Presentation | None:
        nonlocal joined
        shown = present(self, lead)
        if shown is not None:
            if joined < self.joins and self.phase is Phase.FOLLOWS:
                joined = self.joins
                with (folder / f"joins-{number}").open("a") as file:
                    file.write(json.dumps({"joined_s": time.perf_counter() - first[0], "process": os.getpid()}) + "\n")
            noted.write(f"{time.perf_counter() + lead:.6f} {shown.tick} {time.process_time():.4f}\n")
        return shown

    NodeFollower.present = noting  # type: ignore[method-assign]
    NodeFollower._hear_pulse = hear_pulse  # type: ignore[method-assign]
    process.main(skewed)


if __name__ == "__main__":
    if sys.argv[1] == "node":
        sys.exit(node_main(sys.argv[2]))
    del sys.argv[1]
    child_main(Path(sys.argv.pop(1)), int(sys.argv.pop(1)), float(sys.argv.pop(1)), float(sys.argv.pop(1)))
