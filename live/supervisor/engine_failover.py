"""Engine failover: runs the active and the spare engine and moves the show from one to the other."""

import contextlib
import json
import signal
from collections.abc import Callable
from typing import Any, Final

from live.base.system.features import LINUX
from live.base.system.process_control import KILL_CODE
from live.supervisor.adoption.adoption import AdoptedProcess, Adoption
from live.supervisor.adoption.journal_resume import InterruptedShow
from live.supervisor.cpu_priority import restore_priority
from live.supervisor.engine_deaths import DeathHistory, DeathReport
from live.supervisor.heartbeat import Phase
from live.supervisor.line_channel import LineChannel
from live.supervisor.prefork import PreforkProcess
from live.supervisor.process import Child, ProcessManager
from live.supervisor.recovery_log import RecoveryLog
from live.supervisor.restart_policy import HANGS_AFTER, LEAVES_WITHIN, SETTLED, Backoff
from live.supervisor.supervisor_config import Report, SupervisorConfig
from live.supervisor.watchdog import overload

ENDS_WITHIN: Final = 0.2
"""Seconds within which a process ends after its channel has closed."""
ENDS_BEFORE_BEGIN: Final = 3.0
"""The same before the show has begun: nobody waits, and its exit code says why it does not begin."""
STEP_EVENTS: Final = ('"StepsAdded"', '"StepsChanged"', '"ExamplesChanged"')
"""Events that an engine can apply only if it has loaded the steps and examples after them."""
RETRY_DELAY: Final = 0.2
"""Seconds until the next attempt if the system has no resources for an engine: no engine runs meanwhile."""
CALM_RESTART_DELAY: Final = 5.0
"""Seconds between two starts if engines crash in calm mode; doubled each time, up to a minute."""
MAX_SPARE_DELAY: Final = 60.0
"""Most seconds for which an overload delays the spare engine; after that it is needed more than it costs."""
MAX_LIMIT_FACTOR: Final = 8.0
"""Largest factor on the limit for silence, reached if the machine was overloaded each time."""
READY_NOTE: Final = "this machine stands by: it runs the same show as the leader"
"""Shown to the person. Before that, a take-over takes seconds, because the engine still starts."""
MAX_RESUME_FAILURES: Final = 3
"""Engines that may end before one resumes an interrupted show."""


class EngineFailover:
    """The engines of a show: the active one and the spare. Thread: the supervisor's."""

    def __init__(
        self,
        config: SupervisorConfig,
        starter: ProcessManager,
        report: Report,
        say: Callable[[str], None],
        inherit: dict[str, int],
    ) -> None:
        """`inherit`: descriptors that every engine inherits, by their names in its first message."""
        self._config, self._starter, self._report, self._say, self._inherit = config, starter, report, say, inherit
        self.log = RecoveryLog()
        self.show = config.show
        """The show of engines that are started, in their format."""
        self.prefork = PreforkProcess(starter)
        self.engine: Child | None = None
        self.spare: Child | None = None
        self.code: int | None = None
        """Exit code of the show, once it is over."""
        self.on_line: Callable[[str, bool], None] = lambda line, kept: None
        """Called with each line of the show and whether it belongs into the journal."""
        self.on_request: Callable[[dict[str, Any]], None] = lambda asked: None
        """Called with each request of an engine to other parts."""
        self.line_position: tuple[LineChannel | None, int] = (None, 0)
        """Channel of the last line of the show, and its number there."""
        self.screen: dict[str, Any] = {}
        self.role = "engine"
        """Role of the next engine: engine, heir (resumes a running show), standby."""
        self.running_since: float | None = None
        """When the engine began to run [s, monotonic]."""
        self._deaths = DeathHistory()
        self._death_report = DeathReport()
        self._why = ""  # error that the last engine reported
        self._announced_codes: dict[int, int] = {}  # announced exit codes, by process
        self._restart_backoff, self._spare_backoff = Backoff(free=0, first=CALM_RESTART_DELAY), Backoff()
        self._limit_factor = 1.0  # factor on the usual limits for silence
        self._blamed = True  # whether the engine's end counts as its own fault
        self._overloaded_since: float | None = None
        self.has_run = False
        """Whether any engine has run."""
        self._max_failures: int | None = None  # engines that may end before one has run; None: any number
        self._start_at = self._spare_at = self._begun_at = 0.0
        self._died_at: float | None = None
        self._dead: list[Child] = []  # dead, but not reaped yet
        self._crashed_calm = False  # crashed although already calm
        self._downtime = 0.0  # downtime [s], so that slow starts do not make crashes seem rare

    def handle_line(self, line: str) -> None:
        """Handle a line of the show: log it, send it to the spare engine and pass it on."""
        begun = bool(self.log.header)
        if begun and line.startswith('{"journal"'):
            return  # an engine that resumes sends a header, too; only the first one counts
        kept = self.log.add_line(line)
        if self.spare is not None and begun:
            self.spare.channel.send_line(line)
            if any(name in line for name in STEP_EVENTS) and kept:
                self.spare.terminate()  # it has loaded outdated steps
                self.prefork.stop()
        self.on_line(line, kept)

    def adopt(self, found: Adoption) -> None:
        """Adopt an engine that another supervisor started."""
        for line in found.lines:
            self.log.add_line(line)
        child = Child.adopted("engine", found.channel, found.heartbeat, found.process)
        hear = self._line_handler(lambda: child)
        self.role, self.engine = "heir", child
        self.screen = found.screen or self.screen
        self._deaths.count, self._spare_at = self._report.restarts, 0.0
        for line in found.early_lines:
            child.channel.received += 1
            hear(line)
        self._starter.register(child.channel, hear, child.kill)

    def resume(self, left: InterruptedShow) -> None:
        """Resume a show of which no process is left."""
        for line in left.lines:
            self.log.add_line(line)
        self.role, self._max_failures = "heir", MAX_RESUME_FAILURES

    def update(self, now: float) -> None:
        """Check all engines; start, kill and replace them as needed."""
        for child in [child for child in self._dead if child.process.poll() is not None]:
            self._dead.remove(child)
            child.end()
        if self.engine is None and now >= self._start_at:
            self._begin(now)
        engine = self.engine
        if engine is not None:
            engine.channel.flush()
            self._look_at(engine, now)
        self._look_at_spare(now)

    def facts(self) -> dict[str, Any]:
        """Update the report and return it as plain values."""
        self._report.restarts = self._deaths.count
        self._report.late = 0 if self.engine is None else self.engine.watchdog.late
        self._report.spared = 0 if self.engine is None else self.engine.watchdog.overload_silences
        self._report.overload = round(self.overload, 2)
        self._report.spare = self.spare is not None and self.spare.phase is Phase.WAITING
        return self._report.facts()

    @property
    def overload(self) -> float:
        """Overload of the machine, 0 to 1, as far as the engine or this process notices it."""
        dances = self.code is None and self.engine is not None and self.engine.phase is Phase.RUNNING
        return overload(self._starter.load, self.engine.watchdog if self.engine is not None and dances else None)

    def promote_engine(self, **more: Any) -> None:
        """Tell the engine that follows to run the show itself."""
        if self.engine is not None:
            order = {"calm": self._report.calm, "screen": self.screen, "facts": self.facts()}
            order["death"], order["show"] = self._death_report.as_dict(), self.show
            self.engine.channel.send_json(alive="go", **order, **more)

    def stand_by(self) -> None:
        """Follow another machine's show from its first line, whatever ran here before."""
        self.log = RecoveryLog()
        if self.role == "standby":
            if self.engine is not None:
                self.engine.channel.send_json(alive="anew")
            return
        self.role, self.running_since, self._died_at, self._death_report, self._start_at = (
            "standby",
            None,
            None,
            DeathReport(),
            0.0,
        )
        for child in (self.engine, self.spare):
            if child is not None:
                self._starter.unregister(child.channel)
                child.channel.close()
                child.kill()
                self._dead.append(child)
        self.engine = self.spare = None

    def leave(self, number: int) -> int:
        """Pass the signal on and wait until the engine has closed everything; return the exit code."""
        engine = self.engine
        if engine is None:
            return 128 + number
        starting = engine.phase is Phase.STARTING
        engine.channel.send_json(alive="leave", signal=number)
        if LINUX:
            engine.signal(signal.SIGTERM if starting else number)  # a starting interpreter handles only SIGTERM
        elif starting:
            engine.kill()  # it has nothing to close
        self._starter.drain(engine.channel, LEAVES_WITHIN)
        code, self.engine = engine.end(within=LEAVES_WITHIN), None
        if starting or isinstance(
            engine.process, AdoptedProcess
        ):  # the exit code of a process that is no child is unknown
            return 128 + number
        return code if code >= 0 else 128 - code

    def close(self) -> None:
        """End all engines and the prefork process."""
        for child in (self.spare, self.engine, *self._dead):
            if child is not None:
                # a starting engine has nothing to close, and Python might drop the signal's exception
                begins = child.process.poll() is None and child.phase is Phase.STARTING
                (child.kill if begins else child.terminate)()
                child.end()
        self.prefork.close()

    def _discard(self, child: Child, code: int | None) -> int:
        """Discard a dead child, now or once the system has reaped it; return its exit code."""
        self._starter.unregister(child.channel)
        if code is None or child.process.poll() is not None:
            return child.end(within=LEAVES_WITHIN)
        child.channel.close()
        self._dead.append(child)
        return code

    def _begin(self, now: float) -> None:
        try:
            self.engine = self._start(self.role)
        except OSError:  # the system has no room for one now
            if not self.log.header:
                raise
            self._start_at = now + RETRY_DELAY
            return
        self._begun_at = self._start_at  # or a little later
        if self.role == "heir":
            self._send_log(self.engine)
            self.promote_engine()
        elif self.role == "standby" and self.log.header:
            self._send_log(self.engine)

    def _start(self, role: str) -> Child:
        child: Child | None = None
        hear = self._line_handler(lambda: child)
        child = self._fork_engine(role, hear)
        if child is None:
            child = self._starter.start(role, self._config.engine, hear, *self._inherit.values())
        child.channel.send_json(alive=role, show=self.show, **self._inherit)
        return child

    def _line_handler(self, whose: Callable[[], Child | None]) -> Callable[[str], None]:
        """Return a handler for the lines of a child that may not exist yet."""

        def hear(line: str) -> None:
            if line.startswith('{"alive"'):
                if (told := whose()) is not None:
                    self._handle_message(told, json.loads(line))
            elif (child := whose()) is self.engine and child is not None:
                self._report.lines += 1
                self.line_position = child.channel, child.channel.received
                self.handle_line(line)

        return hear

    def _fork_engine(self, role: str, hear: Callable[[str], None]) -> Child | None:
        """Start one from the prefork process, if it is ready. If engines crash even in calm mode, the prefork process
        may be the cause and is not used."""
        if role in ("spare", "heir") and self.prefork.ready and not self._crashed_calm:
            with contextlib.suppress(OSError):
                return self._starter.start(role, (), hear, spawn=self.prefork.fork_engine)
        return None

    def _send_log(self, child: Child) -> None:
        for line in self.log.replay_lines():
            child.channel.send_line(line)

    # -- the active engine ---------------------------------------------------------------------------------------

    def _look_at(self, engine: Child, now: float) -> None:
        if engine.phase is Phase.RUNNING and self.running_since is None:
            self._max_failures, self.has_run = None, True
            self.running_since, self._spare_at = now, now + (0.0 if self.prefork.ready else self._config.spare_after)
            if self._died_at is not None:
                self._record_takeover(engine, self._died_at)
            if self.role == "standby":
                self._say(READY_NOTE)
        if self.running_since is not None and now - self.running_since > SETTLED:
            self._limit_factor = 1.0
        engine.watchdog.limit_factor = self._limit_factor
        if not engine.killed and engine.hangs(now, self._starter.load.slowdown):
            self._end_hung(engine, now)
        code = engine.exit_code()
        if not engine.channel.ended and code is None:
            return
        self._starter.drain(engine.channel, LEAVES_WITHIN, dead=code is not None)
        ended, running = self._announced_codes.pop(engine.process.pid, None), engine.heartbeat.running
        within = ENDS_WITHIN if self.log.header else ENDS_BEFORE_BEGIN
        if ended is None and code is None and not engine.wait_for_end(within):
            engine.kill()  # only its channel broke: it would go on next to its successor
            code = KILL_CODE
        code = self._discard(engine, code)
        if ended is not None:
            self.code = ended
        elif not self.log.header or (self._max_failures is not None and self._deaths.count >= self._max_failures):
            self.code = code if code >= 0 else 1
            self._say(f"the engine ended before it could begin: {describe_exit(code)}")
        else:
            self._replace_engine(code, now, *running)

    def _handle_message(self, child: Child, told: dict[str, Any]) -> None:
        """Handle a message of an engine that is no line of the show."""
        if told["alive"] == "end":  # the only message that marks an end as requested
            if child is self.engine and isinstance(told.get("code"), int):
                self._announced_codes[child.process.pid] = told["code"]
        elif told["alive"] == "crash":
            self._why = str(told.get("why"))
        elif told["alive"] == "note":
            self._say(str(told.get("words")))
        else:
            self.on_request(told)

    def _replace_engine(self, code: int, now: float, tick: int, stage: int) -> None:
        """Replace the dead engine."""
        self._died_at, self.running_since = self._died_at or now, None
        self._crashed_calm = self._report.calm
        self._death_report = self._deaths.record(self._died_at - self._downtime, tick, stage, blamed=self._blamed)
        self._report.calm, self._blamed = self._death_report.calm, True
        words = (
            "without sound and other clocks, because it has happened too often" if self._report.calm else "in its place"
        )
        why, self._why = self._why or describe_exit(code), ""
        self._say(f"the engine ended ({why}); another one goes on {words}")
        self.engine, self.spare = self.spare, None
        if self.role == "engine":
            self.role = "heir"
        if self.engine is not None and (dead := self.engine.exit_code()) is not None:
            self._discard(self.engine, dead)
            self.engine = None
        if self.engine is None:
            self._start_at = (
                max(now, self._begun_at + self._restart_backoff.next_delay(now)) if self._crashed_calm else now
            )
        else:
            if self.engine.phase is Phase.STARTING:
                restore_priority(self.engine.process.pid)
            self.promote_engine()

    def _end_hung(self, engine: Child, now: float) -> None:
        """Kill an engine that gives no sign of life. On an overloaded machine the next one gets a longer limit."""
        words = f"the engine has given no sign of life for {now - engine.heartbeat.last:.1f} s"
        if self.overload > 0.0:
            self._blamed = self._limit_factor >= MAX_LIMIT_FACTOR
            self._limit_factor = min(2.0 * self._limit_factor, MAX_LIMIT_FACTOR)
            words += f", and the machine is {self._starter.load.slowdown:.1f} times slower than it should be"
        self._say(words)
        engine.kill()

    def _record_takeover(self, engine: Child, died: float) -> None:
        self._report.takeover_s = round(engine.heartbeat.last - died, 3)
        self._died_at, self._downtime = None, self._downtime + engine.heartbeat.last - died
        self._say(f"the show goes on, {self._report.takeover_s:.1f} s later")

    # -- the spare engine ----------------------------------------------------------------------------------------

    def _look_at_spare(self, now: float) -> None:
        self.prefork.update()
        spare, ready = self.spare, self._ready_for_a_spare(now)
        if spare is not None:
            spare.channel.flush()
            if (code := spare.exit_code()) is not None:
                self._discard(spare, code)
                wait = max(5.0 * self._config.spare_after, self._spare_backoff.next_delay(now))
                self.spare, self._spare_at = None, now + wait
        elif ready:
            try:
                self.spare = self._start("spare")
            except OSError:  # the system has no room for one now
                self._spare_at = now + max(1.0, self._spare_backoff.next_delay(now))
                return
            self._send_log(self.spare)

    def _ready_for_a_spare(self, now: float) -> bool:
        """Whether a spare may start now. The prefork process starts first, because engines forked from it are ready
        sooner."""
        leads = self.role != "standby" and self.running_since is not None
        if not (self._config.spare and leads and now >= self._spare_at and self.log.header) or self.engine is None:
            return False
        if self._delays_spare(now):
            return False
        brief, engine = {"show": self.show}, self.engine.memory
        return self.prefork.ready or not self.prefork.ensure_started(self._config.engine, brief, self._inherit, engine)

    def _delays_spare(self, now: float) -> bool:
        """Whether an overload delays the spare. It does not if the engine seems to be dying."""
        if self.overload == 0.0:
            self._overloaded_since = None
            return False
        if self._overloaded_since is None:
            self._overloaded_since = now
        dying = self.engine is not None and self.engine.watchdog.own_silence > 0.5 * HANGS_AFTER
        return now - self._overloaded_since < MAX_SPARE_DELAY and not dying


def describe_exit(code: int) -> str:
    """Return how a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"
