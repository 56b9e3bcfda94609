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

from live.rehearse.chaos.call_sites import CallSite
from live.rehearse.chaos.fault_actions import FaultActions, expected_stall
from live.rehearse.chaos.fault_page import FaultPage, PageWord
from live.rehearse.chaos.fault_plan import DISK_FAULTS, ENGINE_FAULTS, MIN_ENDED_ENGINES, ChaosFault, chaos_schedule
from live.rehearse.chaos.injection import PAGE_FILE, ROLES_FOLDER, SITES_FILE, THREADS_FILE
from live.rehearse.chaos.journal_checks import read_measures
from live.rehearse.chaos.process_tree import ProcessTree, cpu_pressure
from live.rehearse.chaos.process_tree import read_process as process_of
from live.rehearse.chaos.small_disk import SmallDisk
from live.rehearse.chaos.virtual_run import find_sites
from live.rehearse.failure import Failure
from live.rehearse.invariants import check_replay
from live.rehearse.network_sender import UdpSender, osc_packets, send_all
from live.rehearse.simulated_players import ArgumentGenerator, SimulatedPlayers
from live.rehearse.soak_test import SoakOptions
from live.show.loader import load_show

START_TIMEOUT: Final = 180.0
"""Time limit for the start of the show and its spare engine [s]; kernels may have to be compiled."""
MAX_GAP: Final = 3.0
"""Maximum time without a tick after a fault, in addition to the fault's own pause [s]."""
MAX_BUSY_GAP: Final = 12.0
"""The same on a busy machine, with CPU pressure above `BUSY` [s]."""
BUSY_PRESSURE: Final = 0.4
TICK_TIMEOUT: Final = 120.0
"""Time without a tick after which the show is considered ended [s]."""
MAX_ENDED_ENGINES: Final = 6
"""Maximum number of engines that one fault may end: more is a loop."""
EXIT_TIMEOUT: Final = 30.0
ADOPTION_TIMEOUT: Final = 20.0
OUTPUT_FILE: Final = "output.txt"


def real_chaos(plan: SoakOptions, folder: Path, on_progress: Callable[[str], None]) -> dict[str, Any]:
    """Execute a chaos run with its files in `folder`; always returns a report."""
    run = ChaosRun(plan, folder, on_progress)
    try:
        run.run()
    except (KeyboardInterrupt, SystemExit):  # Ctrl-C, or `kill`
        run.add_problem("interrupted")
    except Exception as error:
        run.record_failure(Failure.from_exception(error), "the harness itself failed: ")
    finally:
        run.close()
    return run.report()


class ChaosRun:
    """One show under faults. Threads: one, and one that sends the players' calls."""

    def __init__(self, plan: SoakOptions, folder: Path, on_progress: Callable[[str], None]) -> None:
        self._plan, self._folder, self._on_progress = plan, folder, on_progress
        self._problems: list[str] = []
        self._failures: list[dict[str, Any]] = []
        self._faults: list[dict[str, Any]] = []
        self._zombies: dict[int, float] = {}
        self._page: FaultPage | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._stopped = threading.Event()
        self._players_thread: threading.Thread | None = None
        self._facts: dict[str, Any] = {}
        self._sites: list[CallSite] = []
        self._ended_engines = 0
        self._lines_may_be_missing = False
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
        for blow in chaos_schedule(self._plan.seed, until=until, rate=max(min(self._plan.faults, 4.0), 0.25)):
            if not self._idle_until(begun + blow.time):
                break
            if not self._execute(blow):
                break
        else:
            self._idle_until(begun + until)
        self._end_show()
        self._check_results()

    def _prepare(self) -> None:
        folder = self._folder
        (folder / ROLES_FOLDER).mkdir(parents=True, exist_ok=True)
        for name in (PAGE_FILE, THREADS_FILE, "status.jsonl"):
            (folder / name).unlink(missing_ok=True)
        self._page = FaultPage(folder / PAGE_FILE, make=True)
        self._on_progress("looking for call sites ...")
        self._sites = find_sites(self._plan, folder / "looking")
        rows = [[site.caller, site.line, site.callee] for site in self._sites]
        (folder / SITES_FILE).write_text(json.dumps(rows), encoding="utf-8")
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
        (self._folder / OUTPUT_FILE).unlink(missing_ok=True)
        self._process, self._ports = self._spawn(), ports
        self._tree = ProcessTree(self._process.pid, self._folder)
        assert self._page is not None
        self._actions = FaultActions(
            self._page, self._tree, self._disk, self._folder, self._plan.seed, self._sites, ports, self._has_ended,
            self._restart_show,
        )  # fmt: skip

    def _spawn(self) -> subprocess.Popen[bytes]:
        with (self._folder / OUTPUT_FILE).open("ab") as output:
            return subprocess.Popen(
                self._command, stdin=subprocess.DEVNULL, stdout=output, stderr=output, start_new_session=True
            )

    def _restart_show(self) -> None:
        assert self._process is not None
        self._process.wait(EXIT_TIMEOUT)
        self._process = self._spawn()
        self._tree.supervisor = self._process.pid

    def _wait_until_ready(self) -> bool:
        deadline = time.monotonic() + START_TIMEOUT
        while time.monotonic() < deadline:
            alive = self._status().get("alive", {})
            if alive.get("spare") and self._read_word(PageWord.FRAMES) > 60:
                self._players_thread = threading.Thread(target=self._send, name="people", daemon=True)
                self._players_thread.start()
                return True
            if self._has_ended() and "the audio did not start" in self._output_tail() and "sound" not in self._facts:
                self._facts["sound"] = "none: its process did not start in time"
                self._start("--bpm", "120")
            elif self._has_ended():
                self.add_problem(f"the show did not start: {self._output_tail()}")
                return False
            time.sleep(0.1)
        self.add_problem(f"the show was not ready within {START_TIMEOUT:.0f} s: {self._output_tail()}")
        return False

    def _send(self) -> None:
        """Send the players' calls, as in a soak test."""
        try:
            loaded = load_show(self._plan.patch)
            words = ArgumentGenerator(loaded.patch, loaded.graph.library.steps)
            players = SimulatedPlayers(self._plan.seed, words, count=self._plan.players, rate=self._plan.calls)
            outlet, begin = UdpSender("127.0.0.1", self._ports["osc"]), time.monotonic()
            send_all(
                [(osc_packets(players.calls()), outlet.send)], now=lambda: time.monotonic() - begin,
                wait=self._stopped.wait, until=self._plan.hours * 3600.0,
            )  # fmt: skip
            outlet.close()
        except Exception as error:
            self.record_failure(Failure.from_exception(error), "the simulated players failed: ")

    # -- one fault -----------------------------------------------------------------------------------------------

    def _execute(self, blow: ChaosFault) -> bool:
        """Execute a fault, and wait until ticks continue; False if the show has ended."""
        page = self._page
        assert page is not None
        restarts = self._restarts()
        stall = expected_stall(blow)
        self._lines_may_be_missing = self._lines_may_be_missing or blow.kind in DISK_FAULTS
        page[PageWord.GAP] = 0
        at, busy = time.monotonic(), cpu_pressure()
        words = self._actions.execute(blow)
        back = self._wait_for_ticks(at + stall)
        gap, busy = page[PageWord.GAP] / 1e9, max(busy, cpu_pressure())
        fact = {
            "time": round(at - self._begun, 1), "kind": blow.kind, "what": words, "stall_s": round(stall, 2),
            "gap_s": round(gap, 3), "busy": round(busy, 2), "back": back,
        }  # fmt: skip
        self._faults.append(fact)
        if blow.kind in ENGINE_FAULTS and words:
            fact["engines"] = self._count_engines(blow, restarts)
        if blow.kind == "kill supervisor" and not self._is_adopted():
            self.add_problem(f"no supervisor adopted the engine within {ADOPTION_TIMEOUT:.0f} s; {self._output_tail()}")
        page[PageWord.SITE] = page[PageWord.CALLS] = 0
        if not back:
            self.add_problem(f"{blow.kind} ({words}): no tick for {TICK_TIMEOUT:.0f} s; {self._output_tail()}")
            return False
        if gap > stall + (MAX_GAP if busy < BUSY_PRESSURE else MAX_BUSY_GAP):
            self.add_problem(f"{blow.kind} ({words}): {gap:.1f} s without a tick, {stall:.1f} expected")
        self._check_zombies()
        return not self._ended_early()

    def _count_engines(self, blow: ChaosFault, before: int) -> int:
        """Return how many engines the fault ended, from the status."""
        deadline = time.monotonic() + 4.0
        least = MIN_ENDED_ENGINES.get(blow.kind, 1)
        while (count := self._restarts() - before) < least and time.monotonic() < deadline and not self._has_ended():
            time.sleep(0.1)
        self._ended_engines += max(count, 0)
        raised = self._read_word(PageWord.RAISED)
        if count < least and (not blow.kind.startswith("exception") or raised):
            self.add_problem(f"{blow.kind}: {count} restarts counted, at least {least} expected")
        if count > MAX_ENDED_ENGINES:
            self.add_problem(f"{blow.kind}: {count} engines ended one after another")
        return count

    def _is_adopted(self) -> bool:
        """Wait until the next supervisor has adopted the engine, from the status; False if it does not."""
        deadline = time.monotonic() + ADOPTION_TIMEOUT
        while time.monotonic() < deadline and not self._has_ended():
            alive = self._status().get("alive", {})
            if alive.get("adopted") and alive.get("supervised"):
                return True
            time.sleep(0.1)
        return False

    def _wait_for_ticks(self, since: float) -> bool:
        """Wait until ticks are run after `since`; False after `TICK_TIMEOUT` seconds without them."""
        frames, deadline = None, max(since, time.monotonic()) + TICK_TIMEOUT
        while time.monotonic() < deadline and not self._has_ended():
            now = self._read_word(PageWord.FRAMES)
            if time.monotonic() >= since:
                if frames is None:
                    frames = now
                elif now > frames + 20:
                    return True
            time.sleep(0.02)
        return False

    def _idle_until(self, until: float) -> bool:
        while time.monotonic() < until:
            if self._ended_early():
                return False
            time.sleep(min(0.1, max(until - time.monotonic(), 0.0)))
        return not self._ended_early()

    def _ended_early(self) -> bool:
        if self._has_ended():
            assert self._process is not None
            self.add_problem(
                f"the show ended unexpectedly, exit code {self._process.returncode}: {self._output_tail()}"
            )
            return True
        if time.monotonic_ns() - self._read_word(PageWord.LAST) > TICK_TIMEOUT * 1e9:
            self.add_problem(f"the show hangs: no tick for {TICK_TIMEOUT:.0f} s")
            return True
        return False

    def _check_zombies(self) -> None:
        now, found = time.monotonic(), self._tree.zombies()
        self._zombies = {pid: self._zombies.get(pid, now) for pid in found}
        old = [pid for pid, since in self._zombies.items() if now - since > 10.0]
        if old:
            self.add_problem(f"{len(old)} zombie processes have not been reaped for 10 s")
            self._zombies.clear()

    # -- the end -------------------------------------------------------------------------------------------------

    def _end_show(self) -> None:
        self._stopped.set()
        if self._players_thread is not None:
            self._players_thread.join(5.0)
        process = self._process
        if process is None or process.poll() is not None:
            return
        self._tree.resume_all()
        left = [one.pid for one in self._tree.descendants()]
        process.send_signal(signal.SIGINT)
        try:
            code = process.wait(EXIT_TIMEOUT)
        except subprocess.TimeoutExpired:
            self.add_problem(f"the show does not end {EXIT_TIMEOUT:.0f} s after Ctrl-C")
            return
        if code not in (0, 130):
            self.add_problem(f"Ctrl-C ends the show with exit code {code}: {self._output_tail()}")
        deadline = time.monotonic() + 10.0
        while (still := [one for one in map(process_of, left) if one is not None and one.state != "Z"]) and (
            time.monotonic() < deadline
        ):
            time.sleep(0.05)
        if still:
            what = ", ".join(sorted({one.command.split(" -m ")[-1][:40] for one in still}))
            self.add_problem(f"{len(still)} processes remain after the end of the show: {what}")

    def _check_results(self) -> None:
        """Check the files of the show."""
        self._disk.copy_to(self._folder)
        journal = self._folder / "journal.jsonl"
        try:
            measures = read_measures(journal)
        except OSError as error:
            self.add_problem(f"there is no journal: {error.strerror}")
            return
        self._facts["journal"] = measures.facts()
        if measures.twice:
            self.add_problem(f"measures danced twice: {_format_numbers(measures.twice)}")
        if measures.missed:
            self.add_problem(f"measures missed: {_format_numbers(measures.missed)}")
        if measures.lost and not self._lines_may_be_missing:
            self.add_problem(f"{measures.lost} lines of the journal are missing without a disk fault")
        if not measures.ended:
            self.add_problem("the journal has no end line, although the show was ended normally")
        if back := self._read_word(PageWord.REPEATED_TICKS):
            self.add_problem(f"engines ran completed ticks again, {back} times")
        replayed = self._facts["replay"] = check_replay(journal, seed=self._plan.seed, parts=2)
        expected = ("could not be written", "the replay resumes at the snapshot")
        told = [words for words in replayed["problems"] if not any(part in words for part in expected)]
        replayed["gaps"] = len(replayed["problems"]) - len(told)
        replayed["problems"] = told if self._lines_may_be_missing else replayed["problems"] or told
        for words in replayed["problems"]:
            self.add_problem(f"replay: {words}")
        if replayed["different"]:
            self.add_problem(
                f"replay: {replayed['different']} measures differ, the first: {replayed['differences'][:1]}"
            )
        output = (self._folder / OUTPUT_FILE).read_text(encoding="utf-8", errors="replace")
        self._facts["tracebacks"] = output.count("Traceback (most recent call last)")

    def close(self) -> None:
        """Kill all remaining processes, by process id."""
        self._stopped.set()
        process = self._process
        if process is not None:
            below = [one.pid for one in self._tree.descendants()]
            self._tree.resume_all()
            if process.poll() is None:
                process.kill()
                process.wait()
            for pid in below:
                self._tree.signal(pid, signal.SIGKILL)
        self._disk.close()
        if self._page is not None:
            self._facts["frames"] = self._page[PageWord.FRAMES]
            self._page.close()
            self._page = None

    def report(self) -> dict[str, Any]:
        """Return the report of the run."""
        gaps: dict[str, list[float]] = {}
        for fact in self._faults:
            gaps.setdefault(fact["kind"], []).append(max(fact["gap_s"] - fact["stall_s"], 0.0))
        worst = {kind: {"count": len(all_of), "median_s": round(float(np.median(all_of)), 3), "worst_s": max(all_of)}
                 for kind, all_of in gaps.items()}  # fmt: skip
        replay, journal = self._facts.get("replay", {}), self._facts.get("journal", {})
        longest = max((gap for all_of in gaps.values() for gap in all_of), default=0.0)
        return {
            "ok": not self._problems, "problems": self._problems[:50], "count": len(self._problems),
            "failures": self._failures, "faults": self._faults, "gaps": worst, "engines_ended": self._ended_engines,
            "status": self._last_status.get("alive", {}), "parts": self._last_status.get("parts", {}), **self._facts,
            "took": round(time.monotonic() - self._begun, 1),
            "summary": [
                f"{len(self._faults)} faults, {self._ended_engines} engines ended, at most {longest:.2f} s "
                "without a tick",
                f"{journal.get('begun', 0)} measures, {len(journal.get('leapt', ()))} leapt, "
                f"{len(journal.get('lacking', ()))} missing in the journal; {replay.get('measures', 0)} replayed, "
                f"{replay.get('different', 0)} differ",
            ],
        }  # fmt: skip

    # -- small things --------------------------------------------------------------------------------------------

    def add_problem(self, words: str) -> None:
        """Record a problem."""
        self._problems.append(words)
        self._on_progress(words)

    def record_failure(self, failure: Failure, what: str) -> None:
        """Record an exception of the test harness."""
        self._failures.append(failure.facts())
        self.add_problem(f"{what}{failure}")

    def _read_word(self, word: PageWord) -> int:
        return 0 if self._page is None else self._page[word]

    def _has_ended(self) -> bool:
        return self._process is not None and self._process.poll() is not None

    def _restarts(self) -> int:
        return int(self._status().get("alive", {}).get("restarts", 0))

    def _status(self) -> dict[str, Any]:
        """Return the last complete line of the status."""
        for line in _new_lines(self._folder / "status.jsonl", self):
            with contextlib.suppress(ValueError):
                self._last_status = json.loads(line)
        return self._last_status

    def _output_tail(self) -> str:
        with contextlib.suppress(OSError):
            text = (self._folder / OUTPUT_FILE).read_text(encoding="utf-8", errors="replace")
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


def _format_numbers(numbers: list[int]) -> str:
    return ", ".join(map(str, numbers[:8])) + (f" and {len(numbers) - 8} more" if len(numbers) > 8 else "")
