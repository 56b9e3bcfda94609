"""Engine failover: runs the active and the spare engine and moves the show from one to the other."""

import contextlib
import json
import signal
from collections.abc import Callable
from typing import Any, Final

from live.supervisor.adoption.adoption import Adopted, Adoption
from live.supervisor.adoption.journal_resume import CutOff
from live.supervisor.cpu_priority import bring_forward
from live.supervisor.engine_deaths import Deaths, Lesson
from live.supervisor.heartbeat import Phase
from live.supervisor.line_channel import Wire
from live.supervisor.prefork import Nursery
from live.supervisor.process import Child, Starter
from live.supervisor.recovery_log import Log
from live.supervisor.restart_policy import HANGS_AFTER, LEAVES_WITHIN, SETTLED, Backoff
from live.supervisor.supervisor_config import Orders, Report
from live.supervisor.watchdog import overload

ENDS_WITHIN: Final = 0.2
"""Seconds within which a process ends after its channel has closed."""
STEPS: Final = ('"StepsAdded"', '"StepsChanged"')
"""Events that an engine can apply only if it has loaded the steps after them."""
TRY_AGAIN: Final = 0.2
"""Seconds until the next attempt if the system has no resources for an engine: no engine runs meanwhile."""
CALM_APART: Final = 5.0
"""Seconds between two starts if engines crash in calm mode; doubled each time, up to a minute."""
STANDS_BACK: Final = 60.0
"""Most seconds for which an overload delays the spare engine; after that it is needed more than it costs."""
PATIENT: Final = 8.0
"""Largest factor on the limit for silence, reached if the machine was overloaded each time."""
READY: Final = "this machine stands by: it runs the same show as the leader"
"""Shown to the person. Before that, a take-over takes seconds, because the engine still starts."""
TRIES: Final = 3
"""Engines that may end before one resumes an interrupted show."""


class Engines:
    """The engines of a show: the active one and the spare. Thread: the supervisor's."""

    def __init__(
        self, orders: Orders, starter: Starter, report: Report, say: Callable[[str], None], inherit: dict[str, int]
    ) -> None:
        """`inherit`: descriptors that every engine inherits, by their names in its first message."""
        self._orders, self._starter, self._report, self._say, self._inherit = orders, starter, report, say, inherit
        self.log = Log()
        self.nursery = Nursery(starter)
        self.engine: Child | None = None
        self.spare: Child | None = None
        self.code: int | None = None
        """Exit code of the show, once it is over."""
        self.on_line: Callable[[str, bool], None] = lambda line, kept: None
        """Called with each line of the show and whether it belongs into the journal."""
        self.on_asked: Callable[[dict[str, Any]], None] = lambda asked: None
        """Called with each request of an engine to other parts."""
        self.mark: tuple[Wire | None, int] = (None, 0)
        """Channel of the last line of the show, and its number there."""
        self.screen: dict[str, Any] = {}
        self.role = "engine"
        """Role of the next engine: engine, heir (resumes a running show), standby."""
        self.since: float | None = None
        """When the engine began to run [s, monotonic]."""
        self._deaths = Deaths()
        self._lesson = Lesson()
        self._why = ""  # error that the last engine reported
        self._ended: dict[int, int] = {}  # announced exit codes, by process
        self._apart, self._spare_backoff = Backoff(free=0, first=CALM_APART), Backoff()
        self._patience = 1.0  # factor on the usual limits for silence
        self._blamed = True  # whether the engine's end counts as its own fault
        self._overloaded_since: float | None = None
        self.danced = False
        """Whether any engine has run."""
        self._most: int | None = None  # engines that may end before one has run; None: any number
        self._start_at = self._spare_at = self._begun_at = 0.0
        self._died: float | None = None
        self._dead: list[Child] = []  # dead, but not reaped yet
        self._anew = False  # crashed although already calm
        self._undanced = 0.0  # downtime [s], so that slow starts do not make crashes seem rare

    def take(self, line: str) -> None:
        """Handle a line of the show: log it, send it to the spare engine and pass it on."""
        begun = bool(self.log.header)
        if begun and line.startswith('{"journal"'):
            return  # an engine that resumes sends a header, too; only the first one counts
        kept = self.log.take(line)
        if self.spare is not None and begun:
            self.spare.wire.put(line)
            if any(name in line for name in STEPS) and kept:
                self.spare.terminate()  # it has loaded outdated steps
                self.nursery.stop()
        self.on_line(line, kept)

    def adopt(self, found: Adoption) -> None:
        """Adopt an engine that another supervisor started."""
        for line in found.lines:
            self.log.take(line)
        child = Child.adopted("engine", found.wire, found.heart, found.process)
        hear = self._hearing(lambda: child)
        self.role, self.engine = "heir", child
        self.screen = found.screen or self.screen
        self._deaths.count, self._spare_at = self._report.restarts, 0.0
        for line in found.early:
            child.wire.heard += 1
            hear(line)
        self._starter.listen(child.wire, hear, child.kill)

    def resume(self, left: CutOff) -> None:
        """Resume a show of which no process is left."""
        for line in left.lines:
            self.log.take(line)
        self.role, self._most = "heir", TRIES

    def look(self, now: float) -> None:
        """Check all engines; start, kill and replace them as needed."""
        for child in [child for child in self._dead if child.process.poll() is not None]:
            self._dead.remove(child)
            child.end()
        if self.engine is None and now >= self._start_at:
            self._begin(now)
        engine = self.engine
        if engine is not None:
            engine.wire.flush()
            self._look_at(engine, now)
        self._look_at_spare(now)

    def facts(self) -> dict[str, Any]:
        """Update the report and return it as plain values."""
        self._report.restarts = self._deaths.count
        self._report.late = 0 if self.engine is None else self.engine.watch.late
        self._report.spared = 0 if self.engine is None else self.engine.watch.spared
        self._report.overload = round(self.overload, 2)
        self._report.spare = self.spare is not None and self.spare.phase is Phase.WAITING
        return self._report.facts()

    @property
    def overload(self) -> float:
        """Overload of the machine, 0 to 1, as far as the engine or this process notices it."""
        dances = self.code is None and self.engine is not None and self.engine.phase is Phase.RUNNING
        return overload(self._starter.load, self.engine.watch if self.engine is not None and dances else None)

    def go(self, **more: Any) -> None:
        """Tell the engine that follows to run the show itself."""
        if self.engine is not None:
            order = {"calm": self._report.calm, "screen": self.screen, "facts": self.facts()}
            order["death"] = self._lesson.told()
            self.engine.wire.tell(alive="go", **order, **more)

    def stand_by(self) -> None:
        """Follow another machine's show from its first line, whatever ran here before."""
        self.log = Log()
        if self.role == "standby":
            if self.engine is not None:
                self.engine.wire.tell(alive="anew")
            return
        self.role, self.since, self._died, self._lesson, self._start_at = "standby", None, None, Lesson(), 0.0
        for child in (self.engine, self.spare):
            if child is not None:
                self._starter.forget(child.wire)
                child.wire.close()
                child.kill()
                self._dead.append(child)
        self.engine = self.spare = None

    def leave(self, number: int) -> int:
        """Pass the signal on and wait until the engine has closed everything; return the exit code."""
        engine = self.engine
        if engine is None:
            return 128 + number
        starting = engine.phase is Phase.STARTING
        engine.wire.tell(alive="leave")
        engine.signal(signal.SIGTERM if starting else number)  # a starting interpreter handles only SIGTERM
        self._starter.hear_rest(engine.wire, LEAVES_WITHIN)
        code, self.engine = engine.end(within=LEAVES_WITHIN), None
        if starting or isinstance(engine.process, Adopted):  # the exit code of a process that is no child is unknown
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
        self.nursery.close()

    def _bury(self, child: Child, code: int | None) -> int:
        """Discard a dead child, now or once the system has reaped it; return its exit code."""
        self._starter.forget(child.wire)
        if code is None or child.process.poll() is not None:
            return child.end(within=LEAVES_WITHIN)
        child.wire.close()
        self._dead.append(child)
        return code

    def _begin(self, now: float) -> None:
        try:
            self.engine = self._start(self.role)
        except OSError:  # the system has no room for one now
            if not self.log.header:
                raise
            self._start_at = now + TRY_AGAIN
            return
        self._begun_at = self._start_at  # or a little later
        if self.role == "heir":
            self._brief(self.engine)
            self.go()
        elif self.role == "standby" and self.log.header:
            self._brief(self.engine)

    def _start(self, role: str) -> Child:
        child: Child | None = None
        hear = self._hearing(lambda: child)
        child = self._born(role, hear)
        if child is None:
            child = self._starter.start(role, self._orders.engine, hear, *self._inherit.values())
        child.wire.tell(alive=role, show=self._orders.show, **self._inherit)
        return child

    def _hearing(self, whose: Callable[[], Child | None]) -> Callable[[str], None]:
        """Return a handler for the lines of a child that may not exist yet."""

        def hear(line: str) -> None:
            if line.startswith('{"alive"'):
                if (told := whose()) is not None:
                    self._hear(told, json.loads(line))
            elif (child := whose()) is self.engine and child is not None:
                self._report.lines += 1
                self.mark = child.wire, child.wire.heard
                self.take(line)

        return hear

    def _born(self, role: str, hear: Callable[[str], None]) -> Child | None:
        """Start one from the prefork process, if it is ready. If engines crash even in calm mode, the prefork process
        may be the cause and is not used."""
        if role in ("spare", "heir") and self.nursery.ready and not self._anew:
            with contextlib.suppress(OSError):
                return self._starter.start(role, (), hear, born=self.nursery.bear)
        return None

    def _brief(self, child: Child) -> None:
        for line in self.log.since():
            child.wire.put(line)

    # -- the active engine ---------------------------------------------------------------------------------------

    def _look_at(self, engine: Child, now: float) -> None:
        if engine.phase is Phase.RUNNING and self.since is None:
            self._most, self.danced = None, True
            self.since, self._spare_at = now, now + (0.0 if self.nursery.ready else self._orders.spare_after)
            if self._died is not None:
                self._taken_over(engine, self._died)
            if self.role == "standby":
                self._say(READY)
        if self.since is not None and now - self.since > SETTLED:
            self._patience = 1.0
        engine.watch.patience = self._patience
        if not engine.killed and engine.hangs(now, self._starter.load.slowdown):
            self._end_hung(engine, now)
        code = engine.gone()
        if not engine.wire.ended and code is None:
            return
        self._starter.hear_rest(engine.wire, LEAVES_WITHIN, dead=code is not None)
        ended, running = self._ended.pop(engine.process.pid, None), engine.heart.running
        if ended is None and code is None and not engine.ends(ENDS_WITHIN):
            engine.kill()  # only its channel broke: it would go on next to its successor
            code = -signal.SIGKILL
        code = self._bury(engine, code)
        if ended is not None:
            self.code = ended
        elif not self.log.header or (self._most is not None and self._deaths.count >= self._most):
            self.code = code if code >= 0 else 1
            self._say(f"the engine ended before it could begin: {how(code)}")
        else:
            self._go_on(code, now, *running)

    def _hear(self, child: Child, told: dict[str, Any]) -> None:
        """Handle a message of an engine that is no line of the show."""
        if told["alive"] == "end":  # the only message that marks an end as requested
            if child is self.engine and isinstance(told.get("code"), int):
                self._ended[child.process.pid] = told["code"]
        elif told["alive"] == "crash":
            self._why = str(told.get("why"))
        elif told["alive"] == "note":
            self._say(str(told.get("words")))
        else:
            self.on_asked(told)

    def _go_on(self, code: int, now: float, tick: int, stage: int) -> None:
        """Replace the dead engine."""
        self._died, self.since = self._died or now, None
        self._anew = self._report.calm
        self._lesson = self._deaths.note(self._died - self._undanced, tick, stage, blamed=self._blamed)
        self._report.calm, self._blamed = self._lesson.calm, True
        words = (
            "without sound and other clocks, because it has happened too often" if self._report.calm else "in its place"
        )
        why, self._why = self._why or how(code), ""
        self._say(f"the engine ended ({why}); another one goes on {words}")
        self.engine, self.spare = self.spare, None
        if self.role == "engine":
            self.role = "heir"
        if self.engine is not None and (dead := self.engine.gone()) is not None:
            self._bury(self.engine, dead)
            self.engine = None
        if self.engine is None:
            self._start_at = max(now, self._begun_at + self._apart.after(now)) if self._anew else now
        else:
            if self.engine.phase is Phase.STARTING:
                bring_forward(self.engine.process.pid)
            self.go()

    def _end_hung(self, engine: Child, now: float) -> None:
        """Kill an engine that gives no sign of life. On an overloaded machine the next one gets a longer limit."""
        words = f"the engine has given no sign of life for {now - engine.heart.last:.1f} s"
        if self.overload > 0.0:
            self._blamed = self._patience >= PATIENT
            self._patience = min(2.0 * self._patience, PATIENT)
            words += f", and the machine is {self._starter.load.slowdown:.1f} times slower than it should be"
        self._say(words)
        engine.kill()

    def _taken_over(self, engine: Child, died: float) -> None:
        self._report.takeover_s = round(engine.heart.last - died, 3)
        self._died, self._undanced = None, self._undanced + engine.heart.last - died
        self._say(f"the show goes on, {self._report.takeover_s:.1f} s later")

    # -- the spare engine ----------------------------------------------------------------------------------------

    def _look_at_spare(self, now: float) -> None:
        self.nursery.look()
        spare, ready = self.spare, self._ready_for_a_spare(now)
        if spare is not None:
            spare.wire.flush()
            if (code := spare.gone()) is not None:
                self._bury(spare, code)
                wait = max(5.0 * self._orders.spare_after, self._spare_backoff.after(now))
                self.spare, self._spare_at = None, now + wait
        elif ready:
            try:
                self.spare = self._start("spare")
            except OSError:  # the system has no room for one now
                self._spare_at = now + max(1.0, self._spare_backoff.after(now))
                return
            self._brief(self.spare)

    def _ready_for_a_spare(self, now: float) -> bool:
        """Whether a spare may start now. The prefork process starts first, because engines forked from it are ready
        sooner."""
        leads = self.role != "standby" and self.since is not None
        if not (self._orders.spare and leads and now >= self._spare_at and self.log.header) or self.engine is None:
            return False
        if self._stands_back(now):
            return False
        brief, engine = {"show": self._orders.show}, self.engine.memory
        return self.nursery.ready or not self.nursery.begin(self._orders.engine, brief, self._inherit, engine)

    def _stands_back(self, now: float) -> bool:
        """Whether an overload delays the spare. It does not if the engine seems to be dying."""
        if self.overload == 0.0:
            self._overloaded_since = None
            return False
        if self._overloaded_since is None:
            self._overloaded_since = now
        dying = self.engine is not None and self.engine.watch.own > 0.5 * HANGS_AFTER
        return now - self._overloaded_since < STANDS_BACK and not dying


def how(code: int) -> str:
    """Return how a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"
