"""Machines with config folders of their own, paired or not, and supervisors with test engines, as processes."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

from live.supervisor.network.identity import Identity, Pairings, load_identity
from tests.control.waiting import wait_for

MACHINE = """
    import signal
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored in the background
    import json, socket, sys
    from pathlib import Path
    from live.supervisor.network.identity import Pairings, load_identity
    from live.supervisor.supervisor_config import SupervisorConfig
    from live.supervisor.supervisor import Supervisor

    plan, journal, lead, follow = json.loads(sys.argv[1])
    there = None if lead is None else socket.socket(fileno=lead)
    orders = SupervisorConfig(
        engine=[sys.executable, "-m", "tests.supervisor.made_engine"], show=json.dumps(plan), journal=Path(journal),
        lead=there, follow=None if follow is None else ("127.0.0.1", follow), spare=False,
        identity=load_identity(), pairings=Pairings(),
    )
    supervisor = Supervisor(orders, lambda line: print(line, flush=True))
    code = supervisor.run()
    print(json.dumps(supervisor.report.facts()), flush=True)
    sys.exit(code)
"""


def network(config: Path) -> Path:
    """The folder of keys and pairings of a machine with that config folder."""
    config.mkdir(mode=0o700, exist_ok=True)
    return config / "network"


def machine(config: Path) -> tuple[Identity, Pairings]:
    """A machine's key and pairings."""
    return load_identity(network(config)), Pairings(network(config))


def pair_folders(one: Path, other: Path) -> None:
    """Pair two machines with each other."""
    (mine, my_pairings), (theirs, their_pairings) = machine(one), machine(other)
    my_pairings.add(other.name, theirs.certificate)
    their_pairings.add(one.name, mine.certificate)


class Machine:
    """A supervisor with its engine, in a process of its own."""

    def __init__(
        self, folder: Path, name: str, plan: dict[str, Any], *, lead: Any = None, follow: int | None = None,
        config: Path | None = None,
    ) -> None:  # fmt: skip
        self.journal = folder / name
        self.said = folder / f"{name}.out"
        self.config = config or folder / f"config-{name}"
        machine(self.config)
        told = [plan, str(self.journal), None if lead is None else lead.fileno(), follow]
        with self.said.open("w") as out:
            self.process = subprocess.Popen(
                [sys.executable, "-c", textwrap.dedent(MACHINE), json.dumps(told)],
                pass_fds=() if lead is None else (lead.fileno(),), stdout=out, stderr=out, start_new_session=True,
                env={**os.environ, "LIVE_CONFIG_DIR": str(self.config)},
            )  # fmt: skip

    def lines(self, journal: Path | None = None) -> list[dict[str, Any]]:
        journal = journal or self.journal
        text = journal.read_text() if journal.exists() else ""
        return [json.loads(line) for line in text.splitlines(keepends=True) if line.endswith("\n")]

    def numbers(self) -> list[int]:
        return [line["event"]["number"] for line in self.lines() if "number" in line.get("event", {})]

    def engine(self) -> int:
        """The engine's process number."""
        return int(self.lines()[0]["pid"])

    def signal_all(self, number: int) -> None:
        """Send a signal to supervisor and engine in an order without restart or hang detection."""
        both = (self.engine(), self.process.pid)
        for pid in both[::-1] if number == signal.SIGKILL else both:
            with contextlib.suppress(ProcessLookupError):  # it ends by itself when its supervisor has gone
                os.kill(pid, number)

    def prints(self, words: str, seconds: float = 20.0) -> bool:
        """Whether the output contains these words in time."""
        return wait_for(lambda: words in self.said.read_text(), seconds)

    def report(self) -> dict[str, Any]:
        """The report printed at its end."""
        found: dict[str, Any] = json.loads(self.said.read_text().splitlines()[-1])
        return found

    def stop(self) -> dict[str, Any]:
        """End it as Ctrl-C does and return its report."""
        self.process.send_signal(signal.SIGINT)
        self.process.wait(30)
        return self.report()


def stop_all(machines: list[Machine]) -> None:
    """End the processes still running."""
    for one in machines:
        if one.process.poll() is None:
            one.process.send_signal(signal.SIGCONT)
            one.process.send_signal(signal.SIGINT)
    for one in machines:
        try:
            one.process.wait(30)
        except subprocess.TimeoutExpired:
            one.process.kill()
            one.process.wait()


Start = Callable[..., tuple[Machine, Machine]]


def free_port() -> int:
    """A loopback port without a listener."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        return int(free.getsockname()[1])
