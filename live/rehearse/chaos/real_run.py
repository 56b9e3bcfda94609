"""Chaos run with real processes: a headless show whose processes are killed, stopped, starved and disconnected.

The show is started like a normal one, except that its engines read faults from a page of shared memory
(`live.cli.chaos_main`). It is observed from outside: status, journal, that page and /proc.
"""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.rehearse.chaos.call_sites import Site
from live.rehearse.chaos.fault_actions import Acts, stall_of
from live.rehearse.chaos.fault_page import FaultPage, Word
from live.rehearse.chaos.fault_plan import DISK, ENDS_ENGINE, LEAST, Blow, blows
from live.rehearse.chaos.injection import PAGE, ROLES, SITES, THREADS
from live.rehearse.chaos.journal_checks import measures_of
from live.rehearse.chaos.process_tree import Tree, pressure
from live.rehearse.chaos.process_tree import process as process_of
from live.rehearse.chaos.small_disk import SmallDisk
from live.rehearse.chaos.virtual_run import find_sites
from live.rehearse.failure import Failure
from live.rehearse.invariants import prove
from live.rehearse.network_sender import Outlet, packets, send_all
from live.rehearse.simulated_players import FakePlayers, Words
from live.rehearse.soak_test import Plan
from live.show.loader import load_show

READY_WITHIN: Final = 180.0
"""Time limit for the start of the show and its spare engine [s]; kernels may have to be compiled."""
BACK_WITHIN: Final = 3.0
"""Maximum time without a tick after a fault, in addition to the fault's own pause [s]."""
BUSY_WITHIN: Final = 12.0
"""The same on a busy machine, with CPU pressure above `BUSY` [s]."""
BUSY: Final = 0.4
NEVER: Final = 120.0
"""Time without a tick after which the show is considered ended [s]."""
MOST_ENGINES: Final = 6
"""Maximum number of engines that one fault may end: more is a loop."""
LEAVES: Final = 30.0
ADOPTS_WITHIN: Final = 20.0
OUTPUT: Final = "output.txt"


def real_chaos(plan: Plan, folder: Path, tell: Callable[[str], None]) -> dict[str, Any]:
    """Execute a chaos run with its files in `folder`; always returns a report."""
    run = ChaosRun(plan, folder, tell)
    try:
        run.run()
    except (KeyboardInterrupt, SystemExit):  # Ctrl-C, or `kill`
        run.problem("interrupted")
    except Exception as error:
        run.fail(Failure.of(error), "the harness itself failed: ")
    finally:
        run.close()
    return run.report()


class ChaosRun:
    """One show under faults. Threads: one, and one that sends the players' calls."""

    def __init__(self, plan: Plan, folder: Path, tell: Callable[[str], None]) -> None:
        self._plan, self._folder, self._tell = plan, folder, tell
        self._problems: list[str] = []
        self._failures: list[dict[str, Any]] = []
        self._blows: list[dict[str, Any]] = []
        self._zombies: dict[int, float] = {}
        self._page: FaultPage | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._over = threading.Event()
        self._people: threading.Thread | None = None
        self._facts: dict[str, Any] = {}
        self._sites: list[Site] = []
        self._ended_engines = 0
        self._lines_may_lack = False
        self._disk = SmallDisk(folder / "disk")
        self._begun = time.monotonic()
        self._status_read = 0
        self._last_status: dict[str, Any] = {}

    # -- the whole of it -----------------------------------------------------------------------------------------

    def run(self) -> None:
        """Start the show, execute all faults, end it, and check its files."""
        self._prepare()
        self._start()
        if not self._wait_until_ready():
            return
        page, begun = self._page, time.monotonic()
        assert page is not None
        until = self._plan.hours * 3600.0
        for blow in blows(self._plan.seed, until=until, rate=max(min(self._plan.faults, 4.0), 0.25)):
            if not self._rest_until(begun + blow.time):
                break
            if not self._strike(blow):
                break
        else:
            self._rest_until(begun + until)
        self._end_show()
        self._judge()

    def _prepare(self) -> None:
        folder = self._folder
        (folder / ROLES).mkdir(parents=True, exist_ok=True)
        for name in (PAGE, THREADS, "status.jsonl"):
            (folder / name).unlink(missing_ok=True)
        self._page = FaultPage(folder / PAGE, make=True)
        self._tell("looking for call sites ...")
        self._sites = find_sites(self._plan, folder / "looking")
        rows = [[site.caller, site.line, site.callee] for site in self._sites]
        (folder / SITES).write_text(json.dumps(rows), encoding="utf-8")
        self._disk.open()

    def _start(self, *more: str) -> None:
        ports = {name: _free_port() for name in ("osc", "web", "audience", "oscquery", "midi", "vmc")}
        here = "127.0.0.1"
        self._command = [
            sys.executable, "-m", "live.cli.chaos_main", str(self._folder), "play", str(self._plan.patch),
            "--headless", "--seed", str(self._plan.seed), "--fps", str(self._plan.fps),
            "--osc", f"{here}:{ports['osc']}", "--web", f"{here}:{ports['web']}",
            "--audience", f"{here}:{ports['audience']}", "--oscquery", f"{here}:{ports['oscquery']}",
            "--midi", f"tcp:{here}:{ports['midi']}", "--vmc", f"{here}:{ports['vmc']}",
            "--journal", str(self._disk.path / "journal.jsonl"), "--status-json", str(self._folder / "status.jsonl"),
            *more,
        ]  # fmt: skip
        (self._folder / OUTPUT).unlink(missing_ok=True)
        self._process, self._ports = self._run(), ports
        self._tree = Tree(self._process.pid, self._folder)
        assert self._page is not None
        self._acts = Acts(
            self._page, self._tree, self._disk, self._folder, self._plan.seed, self._sites, ports, self._gone,
            self._start_again,
        )  # fmt: skip

    def _run(self) -> subprocess.Popen[bytes]:
        with (self._folder / OUTPUT).open("ab") as output:
            return subprocess.Popen(
                self._command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True
            )

    def _start_again(self) -> None:
        assert self._process is not None
        self._process.wait(LEAVES)
        self._process = self._run()
        self._tree.supervisor = self._process.pid

    def _wait_until_ready(self) -> bool:
        deadline = time.monotonic() + READY_WITHIN
        while time.monotonic() < deadline:
            alive = self._status().get("alive", {})
            if alive.get("spare") and self._word(Word.FRAMES) > 60:
                self._people = threading.Thread(target=self._send, name="people", daemon=True)
                self._people.start()
                return True
            if self._gone() and "the audio did not start" in self._tail() and "sound" not in self._facts:
                self._facts["sound"] = "none: its process did not start in time"
                self._start("--bpm", "120")
            elif self._gone():
                self.problem(f"the show did not start: {self._tail()}")
                return False
            time.sleep(0.1)
        self.problem(f"the show was not ready within {READY_WITHIN:.0f} s: {self._tail()}")
        return False

    def _send(self) -> None:
        """Send the players' calls, as in a soak test."""
        try:
            loaded = load_show(self._plan.patch)
            words = Words(loaded.patch, loaded.graph.library.steps)
            players = FakePlayers(self._plan.seed, words, count=self._plan.players, rate=self._plan.calls)
            outlet, begin = Outlet("127.0.0.1", self._ports["osc"]), time.monotonic()
            send_all(
                [(packets(players.calls()), outlet.send)], now=lambda: time.monotonic() - begin,
                wait=self._over.wait, until=self._plan.hours * 3600.0,
            )  # fmt: skip
            outlet.close()
        except Exception as error:
            self.fail(Failure.of(error), "the simulated players failed: ")

    # -- one fault -----------------------------------------------------------------------------------------------

    def _strike(self, blow: Blow) -> bool:
        """Execute a fault, and wait until ticks continue; False if the show has ended."""
        page = self._page
        assert page is not None
        restarts = self._restarts()
        stall = stall_of(blow)
        self._lines_may_lack = self._lines_may_lack or blow.kind in DISK
        page[Word.GAP] = 0
        at, busy = time.monotonic(), pressure()
        words = self._acts.do(blow)
        back = self._wait_until_back(at + stall)
        gap, busy = page[Word.GAP] / 1e9, max(busy, pressure())
        fact = {
            "time": round(at - self._begun, 1), "kind": blow.kind, "what": words, "stall_s": round(stall, 2),
            "gap_s": round(gap, 3), "busy": round(busy, 2), "back": back,
        }  # fmt: skip
        self._blows.append(fact)
        if blow.kind in ENDS_ENGINE and words:
            fact["engines"] = self._count_engines(blow, restarts)
        if blow.kind == "kill supervisor" and not self._is_adopted():
            self.problem(f"no supervisor adopted the engine within {ADOPTS_WITHIN:.0f} s; {self._tail()}")
        page[Word.SITE] = page[Word.CALLS] = 0
        if not back:
            self.problem(f"{blow.kind} ({words}): no tick for {NEVER:.0f} s; {self._tail()}")
            return False
        if gap > stall + (BACK_WITHIN if busy < BUSY else BUSY_WITHIN):
            self.problem(f"{blow.kind} ({words}): {gap:.1f} s without a tick, {stall:.1f} expected")
        self._look_for_zombies()
        return not self._ended_early()

    def _count_engines(self, blow: Blow, before: int) -> int:
        """Return how many engines the fault ended, from the status."""
        deadline = time.monotonic() + 4.0
        least = LEAST.get(blow.kind, 1)
        while (count := self._restarts() - before) < least and time.monotonic() < deadline and not self._gone():
            time.sleep(0.1)
        self._ended_engines += max(count, 0)
        raised = self._word(Word.RAISED)
        if count < least and (not blow.kind.startswith("exception") or raised):
            self.problem(f"{blow.kind}: {count} restarts counted, at least {least} expected")
        if count > MOST_ENGINES:
            self.problem(f"{blow.kind}: {count} engines ended one after another")
        return count

    def _is_adopted(self) -> bool:
        """Wait until the next supervisor has adopted the engine, from the status; False if it does not."""
        deadline = time.monotonic() + ADOPTS_WITHIN
        while time.monotonic() < deadline and not self._gone():
            alive = self._status().get("alive", {})
            if alive.get("adopted") and alive.get("supervised"):
                return True
            time.sleep(0.1)
        return False

    def _wait_until_back(self, since: float) -> bool:
        """Wait until ticks are run after `since`; False after `NEVER` seconds without them."""
        frames, deadline = None, max(since, time.monotonic()) + NEVER
        while time.monotonic() < deadline and not self._gone():
            now = self._word(Word.FRAMES)
            if time.monotonic() >= since:
                if frames is None:
                    frames = now
                elif now > frames + 20:
                    return True
            time.sleep(0.02)
        return False

    def _rest_until(self, until: float) -> bool:
        while time.monotonic() < until:
            if self._ended_early():
                return False
            time.sleep(min(0.1, max(until - time.monotonic(), 0.0)))
        return not self._ended_early()

    def _ended_early(self) -> bool:
        if self._gone():
            assert self._process is not None
            self.problem(f"the show ended unexpectedly, exit code {self._process.returncode}: {self._tail()}")
            return True
        if time.monotonic_ns() - self._word(Word.LAST) > NEVER * 1e9:
            self.problem(f"the show hangs: no tick for {NEVER:.0f} s")
            return True
        return False

    def _look_for_zombies(self) -> None:
        now, found = time.monotonic(), self._tree.zombies()
        self._zombies = {pid: self._zombies.get(pid, now) for pid in found}
        old = [pid for pid, since in self._zombies.items() if now - since > 10.0]
        if old:
            self.problem(f"{len(old)} zombie processes have not been reaped for 10 s")
            self._zombies.clear()

    # -- the end -------------------------------------------------------------------------------------------------

    def _end_show(self) -> None:
        self._over.set()
        if self._people is not None:
            self._people.join(5.0)
        process = self._process
        if process is None or process.poll() is not None:
            return
        self._tree.go_on()
        left = [one.pid for one in self._tree.below()]
        process.send_signal(signal.SIGINT)
        try:
            code = process.wait(LEAVES)
        except subprocess.TimeoutExpired:
            self.problem(f"the show does not end {LEAVES:.0f} s after Ctrl-C")
            return
        if code not in (0, 130):
            self.problem(f"Ctrl-C ends the show with exit code {code}: {self._tail()}")
        deadline = time.monotonic() + 10.0
        while (still := [one for one in map(process_of, left) if one is not None and one.state != "Z"]) and (
            time.monotonic() < deadline
        ):
            time.sleep(0.05)
        if still:
            what = ", ".join(sorted({one.command.split(" -m ")[-1][:40] for one in still}))
            self.problem(f"{len(still)} processes remain after the end of the show: {what}")

    def _judge(self) -> None:
        """Check the files of the show."""
        self._disk.keep(self._folder)
        journal = self._folder / "journal.jsonl"
        try:
            measures = measures_of(journal)
        except OSError as error:
            self.problem(f"there is no journal: {error.strerror}")
            return
        self._facts["journal"] = measures.facts()
        if measures.twice:
            self.problem(f"measures danced twice: {_some(measures.twice)}")
        if measures.missed:
            self.problem(f"measures missed: {_some(measures.missed)}")
        if measures.lost and not self._lines_may_lack:
            self.problem(f"{measures.lost} lines of the journal are missing without a disk fault")
        if not measures.ended:
            self.problem("the journal has no end line, although the show was ended normally")
        if back := self._word(Word.BACK):
            self.problem(f"engines ran completed ticks again, {back} times")
        replayed = self._facts["replay"] = prove(journal, seed=self._plan.seed, stretches=2)
        expected = ("could not be written", "the replay resumes at the snapshot")
        told = [words for words in replayed["problems"] if not any(part in words for part in expected)]
        replayed["gaps"] = len(replayed["problems"]) - len(told)
        replayed["problems"] = told if self._lines_may_lack else replayed["problems"] or told
        for words in replayed["problems"]:
            self.problem(f"replay: {words}")
        if replayed["different"]:
            self.problem(f"replay: {replayed['different']} measures differ, the first: {replayed['differences'][:1]}")
        output = (self._folder / OUTPUT).read_text(encoding="utf-8", errors="replace")
        self._facts["tracebacks"] = output.count("Traceback (most recent call last)")

    def close(self) -> None:
        """Kill all remaining processes, by process id."""
        self._over.set()
        process = self._process
        if process is not None:
            below = [one.pid for one in self._tree.below()]
            self._tree.go_on()
            if process.poll() is None:
                process.kill()
                process.wait()
            for pid in below:
                self._tree.signal(pid, signal.SIGKILL)
        self._disk.close()
        if self._page is not None:
            self._facts["frames"] = self._page[Word.FRAMES]
            self._page.close()
            self._page = None

    def report(self) -> dict[str, Any]:
        """Return the report of the run."""
        gaps: dict[str, list[float]] = {}
        for fact in self._blows:
            gaps.setdefault(fact["kind"], []).append(max(fact["gap_s"] - fact["stall_s"], 0.0))
        worst = {kind: {"count": len(all_of), "median_s": round(float(np.median(all_of)), 3), "worst_s": max(all_of)}
                 for kind, all_of in gaps.items()}  # fmt: skip
        replay, journal = self._facts.get("replay", {}), self._facts.get("journal", {})
        longest = max((gap for all_of in gaps.values() for gap in all_of), default=0.0)
        return {
            "ok": not self._problems, "problems": self._problems[:50], "count": len(self._problems),
            "failures": self._failures, "faults": self._blows, "gaps": worst, "engines_ended": self._ended_engines,
            "status": self._last_status.get("alive", {}), "parts": self._last_status.get("parts", {}), **self._facts,
            "took": round(time.monotonic() - self._begun, 1),
            "summary": [
                f"{len(self._blows)} faults, {self._ended_engines} engines ended, at most {longest:.2f} s "
                "without a tick",
                f"{journal.get('begun', 0)} measures, {len(journal.get('leapt', ()))} leapt, "
                f"{len(journal.get('lacking', ()))} missing in the journal; {replay.get('measures', 0)} replayed, "
                f"{replay.get('different', 0)} differ",
            ],
        }  # fmt: skip

    # -- small things --------------------------------------------------------------------------------------------

    def problem(self, words: str) -> None:
        """Record a problem."""
        self._problems.append(words)
        self._tell(words)

    def fail(self, failure: Failure, what: str) -> None:
        """Record an exception of the test harness."""
        self._failures.append(failure.facts())
        self.problem(f"{what}{failure}")

    def _word(self, word: Word) -> int:
        return 0 if self._page is None else self._page[word]

    def _gone(self) -> bool:
        return self._process is not None and self._process.poll() is not None

    def _restarts(self) -> int:
        return int(self._status().get("alive", {}).get("restarts", 0))

    def _status(self) -> dict[str, Any]:
        """Return the last complete line of the status."""
        for line in _new_lines(self._folder / "status.jsonl", self):
            with contextlib.suppress(ValueError):
                self._last_status = json.loads(line)
        return self._last_status

    def _tail(self) -> str:
        with contextlib.suppress(OSError):
            text = (self._folder / OUTPUT).read_text(encoding="utf-8", errors="replace")
            return " | ".join(line.strip() for line in text.splitlines()[-4:])
        return ""


def _new_lines(path: Path, run: ChaosRun) -> Iterator[str]:
    with contextlib.suppress(OSError), path.open("rb") as file:
        if file.seek(0, 2) < run._status_read:
            run._status_read = 0
        file.seek(run._status_read)
        data = file.read()
        whole = data[: data.rfind(b"\n") + 1]
        run._status_read += len(whole)
        yield from whole.decode("utf-8", "replace").splitlines()


def _free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def _some(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers[:8])) + (f" and {len(numbers) - 8} more" if len(numbers) > 8 else "")
