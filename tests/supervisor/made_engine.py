"""An engine without a show, as a process: counts ticks and ends as its brief specifies.

The brief's `show` is a JSON object: `ends` (exit code once it has counted to `ticks`), `kills` (ticks at which engines
that began or took over kill themselves, one after another), `crashes` (tick and exit code of one engine after
another, in the tick stage given by `stage`), `hangs` (tick at which the heartbeat stops), `hangs_again` (the first
replacement hangs too), `cannot` (reason why it cannot stand by), `burns` (processor seconds used by each tick),
`cuts` (tick at which the first engine's channel is cut while it keeps running), `loops` (tick at which it enters an
infinite loop), `helpers` (number of child processes that end with it), `journal` (where it continues the journal
without a supervisor), `alone` (maximum seconds of running without a supervisor; without it, not at all).
"""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from live.supervisor.heartbeat import Phase
from live.supervisor.journal_relay import RelaySink
from live.supervisor.prefork import serve_forks
from live.supervisor.supervisor_link import Brief, SupervisorLink, is_abandoned


def follow(lifeline: SupervisorLink, role: str, nursery: int | None, plan: dict[str, Any]) -> int:
    """Receive lines until the go message; return the tick to continue from. `nursery`: the prefork parent process."""
    tick = 0
    while not is_abandoned(lifeline):
        lifeline.receive()
        if lifeline.pop_request("anew") is not None:
            tick = 0
        for line in lifeline.lines:
            told = json.loads(line)
            tick = max(tick, told.get("tick", 0))
            lifeline.log.add_line(line)
        if role == "standby" and "cannot" in plan and lifeline.lines:
            lifeline.channel.send_json(alive="cannot", why=plan["cannot"])
            lifeline.send_end(2)
            sys.exit(2)
        lifeline.lines.clear()
        if (order := lifeline.pop_request("go")) is not None:
            origin = {"parent": os.getppid(), "nursery": nursery}
            went = {"tick": tick, "went": role, "calm": order["calm"], "death": order["death"], **origin}
            lifeline.send_line(compact(went))
            if plan.get("hangs_again") and order["death"]["times"] == 1:
                lifeline.heartbeat.stage[0] = plan["stage"]
                lifeline.heartbeat.begin_tick(tick + 1)
                time.sleep(600)
            return tick
        lifeline.beat(tick, Phase.RUNNING if role == "standby" else Phase.WAITING)
        if role == "standby":
            ready = int(tick > 20 and not plan.get("never_ready"))
            lifeline.send_following({"compared": 1, "different": 0, "repaired": 0, "ready": ready})
        lifeline.wait(0.02)
    sys.exit(0)


def connect_supervisor() -> tuple[SupervisorLink, Brief, int | None]:
    """The link to the supervisor, the brief, and the prefork parent that created this process."""
    lifeline = SupervisorLink.of_arguments(*sys.argv[1:3])
    brief = lifeline.receive_brief()
    if brief.role != "nursery":
        return lifeline, brief, None
    if json.loads(brief.show).get("nursery_dies"):
        lifeline.beat(0, Phase.WAITING)
        os.kill(os.getpid(), signal.SIGKILL)
    nursery, born = os.getpid(), serve_forks(lifeline)
    if born is None:
        sys.exit(0)
    return born, born.receive_brief(), nursery


def burn(seconds: float) -> None:
    """Use the processor for this many seconds of thread time."""
    until = time.thread_time() + seconds
    while time.thread_time() < until:
        pass


def start_helpers(count: int) -> list[subprocess.Popen[bytes]]:
    """Processes that end together with this one, each in a session of its own like those of a show."""
    wait = [sys.executable, "-S", "-c", "import sys; sys.stdin.read()"]
    return [subprocess.Popen(wait, stdin=subprocess.PIPE, start_new_session=True) for _ in range(count)]


def work(plan: dict[str, Any], tick: int, *, first: bool, wire: socket.socket) -> None:
    """The work of a tick, possibly endless. `first`: for the engine that began the show."""
    if first and tick == plan.get("cuts"):
        wire.shutdown(socket.SHUT_RDWR)
    if first and tick == plan.get("hangs"):
        time.sleep(600)
    if first and tick == plan.get("loops"):
        burn(600.0)
    burn(plan.get("burns", 0.0))


def journal_path(plan: dict[str, Any]) -> Path | None:
    """Path of the journal that an engine without a supervisor writes."""
    return Path(plan["journal"]) if "journal" in plan else None


def compact(line: dict[str, Any]) -> str:
    """JSON without spaces, as in a journal."""
    return json.dumps(line, separators=(",", ":"))


def main() -> None:
    begun_at = time.monotonic()
    lifeline, brief, nursery = connect_supervisor()
    plan = json.loads(brief.show)
    if "start" in plan and brief.role == "engine":
        sys.exit(plan["start"])
    sink = None
    if brief.role == "engine":
        sink = RelaySink(lifeline, journal_path(plan))
        sink.put(
            compact({"journal": 2, "pid": os.getpid(), **({"origin": plan["origin"]} if "origin" in plan else {})})
        )
        tick = 0
    else:
        tick = follow(lifeline, brief.role, nursery, plan)
    if brief.role != "engine":
        time.sleep(plan.get("slow", 0.0))
    sink = sink or RelaySink(lifeline, journal_path(plan))
    crashes = plan.get("crashes", [])[lifeline.facts.get("restarts", 0) :]
    helpers = start_helpers(plan.get("helpers", 0))
    kills = [at for at in plan.get("kills", []) if at > tick]
    while True:
        tick += 1
        lifeline.heartbeat.begin_tick(tick)
        if crashes and tick == crashes[0][0]:
            lifeline.heartbeat.stage[0] = plan.get("stage", 0)
            os._exit(crashes[0][1])
        sink.put(compact({"tick": tick, "event": {"type": "made", "number": tick}}))
        if kills and tick >= kills[0]:
            os.kill(os.getpid(), signal.SIGKILL)
        work(plan, tick, first=brief.role == "engine", wire=lifeline.channel.socket)
        sink.flush()
        lifeline.end_frame(tick)
        if lifeline.fenced:
            lifeline.channel.send_line(json.dumps({"tick": tick, "event": {"type": "dark"}}))
            while not lifeline.orphaned:  # dark, until the supervisor ends it
                lifeline.wait(0.1)
                lifeline.end_frame(tick)
            sys.exit(0)
        if tick >= plan.get("ticks", 1 << 40):
            lifeline.beat(tick, Phase.LEAVING)
            sink.put(compact({"tick": tick, "end": True}))
            sink.close()
            lifeline.send_end(plan.get("ends", 0))
            for helper in helpers:
                helper.communicate()
            sys.exit(plan.get("ends", 0))
        if lifeline.orphaned and (not plan.get("alone") or time.monotonic() - begun_at > plan["alone"]):
            sys.exit(0)  # the test that began this has gone
        time.sleep(plan.get("pace", 0.005))


if __name__ == "__main__":
    main()
