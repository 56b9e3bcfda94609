"""Supervisor: starts the processes of a show, watches their hearts, and lets another engine go on where one ended.

It holds no device, no window and no array: what does so little does not fail. It runs in the process that the person
started, so the terminal, its signals and the exit code are its own. One loop, no threads but the journal's writer.
"""

import json
import selectors
import signal
import socket
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Final

from live.alive.child import Child
from live.alive.disk import Disk
from live.alive.heartbeat import Phase
from live.alive.limits import LEAVES_WITHIN, RestartLimit
from live.alive.log import Log
from live.alive.orders import Orders, Report
from live.alive.wire import WireBroken

ROUND: Final = 0.05
"""Seconds between two looks at the hearts."""
TELL_EVERY: Final = 1.0
ENDED_WELL: Final = (0, 2, 130, 128 + signal.SIGTERM, 128 + signal.SIGHUP)
"""Exit codes that somebody wanted; any other one of a running engine is a crash."""
CALM_APART: Final = 5.0
"""Seconds between two starts once there were too many."""
GIVE_UP: Final = 50
"""Engines that ended in crashes; a show whose engines cannot even begin any more is over then."""


class Supervisor:
    """Runs a show until it ends. Thread: the one that made it."""

    def __init__(self, orders: Orders, say: Callable[[str], None]) -> None:
        """`say`: tells the person a line."""
        self._orders = orders
        self._say = say
        self.report = Report()
        self.log = Log()
        self.engine: Child | None = None
        self.spare: Child | None = None
        self.audio: Child | None = None
        self.guard: Child | None = None
        self._selector = selectors.DefaultSelector()
        self._limit, self._audio_limit, self._guard_limit = RestartLimit(), RestartLimit(), RestartLimit()
        self._disk = Disk(orders.journal)
        self._osc = orders.osc
        self._sound: tuple[socket.socket, socket.socket] | None = None
        self._awake = time.monotonic()
        self._engine_since: float | None = None
        self._spare_at = self._tell_at = self._start_at = 0.0
        fullscreen, monitor = orders.screen
        self._screen: dict[str, object] = {"alive": "screen", "fullscreen": fullscreen, "monitor": monitor}
        self._died: float | None = None
        self._code: int | None = None

    def run(self) -> int:
        """Start everything, keep it going, and return the exit code of the engine that ended well (or could not)."""
        try:
            if self._orders.audio:
                self._sound = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
                self._start_audio()
            if self._orders.guard:
                self._start_guard()
            self.engine = self._start_engine("engine")
            while self._code is None:
                self._turn()
            return self._code
        except (KeyboardInterrupt, SystemExit) as ended:
            number = signal.SIGINT if isinstance(ended, KeyboardInterrupt) else int(str(ended.code)) - 128
            return self._leave(number)
        finally:
            self._close()

    # -- the loop ------------------------------------------------------------------------------------------------

    def _turn(self) -> None:
        slept = time.monotonic()
        for key, _ in self._selector.select(ROUND):
            key.data()
        now = time.monotonic()
        if now - slept > 10 * ROUND:  # this process itself was stopped: nobody's heart is to blame
            self._awake = now
        for child in (self.engine, self.spare, self.audio, self.guard):
            if child is not None:
                child.wire.flush()
        self._look_at_engine(now)
        self._look_at_spare(now)
        self._look_at_audio(now)
        if self.guard is not None and self.guard.process.poll() is not None:
            self._replace_guard(self.guard)
        if now >= self._tell_at:
            self._tell_at = now + TELL_EVERY
            self._tell(now)

    def _hear_engine(self, child: Child) -> None:
        """Lines of the engine: they go into the log, to the spare and to the disk."""
        for line in self._lines(child):
            self.report.lines += 1
            if line.startswith('{"alive"'):
                self._obey(json.loads(line))
                continue
            first = not self.log.header
            kept = self.log.take(line)
            if self.spare is not None and (kept or line.startswith('{"tick"')) and not first:
                self.spare.wire.put(line)
            if kept:
                self._disk.put(line)

    def _lines(self, child: Child) -> list[str]:
        try:
            lines = child.wire.lines()
        except WireBroken:
            child.signal(signal.SIGKILL)
            lines, child.wire.ended = [], True
        if child.wire.ended:
            self._selector.unregister(child.wire.socket)
        return lines

    def _obey(self, asked: dict[str, object]) -> None:
        """What an engine asks of the others."""
        if asked["alive"] == "screen":
            self._screen = asked
            if self.guard is not None:
                self.guard.wire.tell(**asked)

    # -- the engine ----------------------------------------------------------------------------------------------

    def _look_at_engine(self, now: float) -> None:
        if self.engine is None and now >= self._start_at:
            self._start_heir()
        engine = self.engine
        if engine is None:
            return
        running = engine.phase is Phase.RUNNING
        if running and self._engine_since is None:
            self._engine_since, self._spare_at = now, now + self._orders.spare_after
            if self._died is not None:
                self._taken_over(engine)
        if engine.hangs(now, self._awake):
            self._say(f"the engine has given no sign of life for {now - engine.heart.last:.1f} s; another takes over")
            engine.signal(signal.SIGKILL)
        if not engine.wire.ended and engine.process.poll() is None:
            return
        self._hear_rest(engine)
        phase = engine.phase
        code = engine.end(within=LEAVES_WITHIN)
        begun = phase is Phase.RUNNING or self._died is not None
        if (code in ENDED_WELL and phase is not Phase.STARTING) or not begun or self._limit.count >= GIVE_UP:
            self._code = code if code >= 0 else 1
            if code not in ENDED_WELL:
                self._say(f"the engine ended while it was {phase.name.lower()}: {_how(code)}")
            return
        self._go_on(code, now)

    def _hear_rest(self, engine: Child) -> None:
        """What it said last is still to be read, however it ended."""
        deadline = time.monotonic() + LEAVES_WITHIN
        while not engine.wire.ended and time.monotonic() < deadline:
            for key, _ in self._selector.select(ROUND):
                key.data()

    def _go_on(self, code: int, now: float) -> None:
        """The engine died: let another one go on."""
        calm = self._limit.note(now)
        self.report.restarts = self._limit.count
        self.report.calm = self.report.calm or calm
        self._died = self._died or now
        self._engine_since = None
        words = "in a calmer mode, without sound, audience and other clocks" if self.report.calm else "in its place"
        self._say(f"the engine ended ({_how(code)}); another one goes on {words}")
        heir, self.spare = self.spare, None
        if heir is not None and heir.process.poll() is not None:
            heir.end()
            heir = None
        if heir is None:
            self.engine, self._start_at = None, now + (CALM_APART if self.report.calm else 0.0)
            return
        heir.wire.tell(alive="go", calm=self.report.calm, screen=self._screen, **self._facts())
        self.engine = heir

    def _start_heir(self) -> None:
        """An engine that goes on at once; none was ready."""
        heir = self._start_engine("heir")
        for line in self.log.since():
            heir.wire.put(line)
        heir.wire.tell(alive="go", calm=self.report.calm, screen=self._screen, **self._facts())
        self.engine = heir

    def _taken_over(self, engine: Child) -> None:
        assert self._died is not None
        self.report.takeover_s = round(engine.heart.last - self._died, 3)
        self._died = None
        self._say(f"the show goes on, {self.report.takeover_s:.1f} s later, at tick {engine.heart.tick}")

    # -- the spare -----------------------------------------------------------------------------------------------

    def _look_at_spare(self, now: float) -> None:
        if self.spare is not None:
            if self.spare.process.poll() is None:
                return
            self._lines(self.spare)
            self.spare.end()
            self.spare, self._spare_at = None, now + 5.0 * self._orders.spare_after
        wanted = self._orders.spare and self._engine_since is not None and not self.report.calm
        if wanted and now >= self._spare_at and self.log.header:
            self.spare = self._start_engine("spare")
            for line in self.log.since():
                self.spare.wire.put(line)

    # -- sound ---------------------------------------------------------------------------------------------------

    def _start_audio(self) -> None:
        assert self._sound is not None
        self.audio = self._start("audio", [*self._orders.audio, str(self._sound[1].fileno())], self._sound[1].fileno())

    def _look_at_audio(self, now: float) -> None:
        audio = self.audio
        if audio is None:
            return
        if audio.hangs(now, self._awake):
            audio.signal(signal.SIGKILL)
        if audio.process.poll() is None:
            return
        code = audio.end()
        self.audio = None
        if self._audio_limit.note(now):
            self._say(f"the process that listens ended again ({_how(code)}); the show goes on by its own clock")
            return
        self.report.audio_restarts += 1
        self._say(f"the process that listens ended ({_how(code)}); it is started again")
        self._start_audio()

    # -- the guard -----------------------------------------------------------------------------------------------

    def _start_guard(self) -> None:
        self.guard = self._start("guard", self._orders.guard)
        self.guard.wire.tell(**self._screen)

    def _replace_guard(self, guard: Child) -> None:
        """Another one, if it did not end by itself (then there can be none here)."""
        self.guard = None
        if guard.end() != 0 and not self._guard_limit.note(time.monotonic()):
            self._start_guard()

    # -- all of them ---------------------------------------------------------------------------------------------

    def _start(self, role: str, command: Sequence[str], *inherit: int) -> Child:
        child = Child(role, command, inherit=inherit)
        self._selector.register(child.wire.socket, selectors.EVENT_READ, lambda: self._hear(child))
        return child

    def _hear(self, child: Child) -> None:
        if child is self.engine:
            self._hear_engine(child)
        else:
            self._lines(child)

    def _start_engine(self, role: str) -> Child:
        inherit = [each.fileno() for each in (self._osc,) if each is not None]
        if self._sound is not None:
            inherit.append(self._sound[0].fileno())
        child = self._start(role, self._orders.engine, *inherit)
        child.wire.tell(
            alive=role,
            show=self._orders.show,
            sound=None if self._sound is None else self._sound[0].fileno(),
            osc=None if self._osc is None else self._osc.fileno(),
        )
        return child

    def _facts(self) -> dict[str, object]:
        self.report.late = 0 if self.engine is None else self.engine.watch.late
        self.report.spare = self.spare is not None and self.spare.phase is Phase.WAITING
        self.report.guard = self.guard is not None and self.guard.process.poll() is None
        return {"facts": asdict(self.report)}

    def _tell(self, now: float) -> None:
        children = (self.engine, self.spare, self.audio, self.guard)
        self.report.memory_mb = {one.role: round(one.memory() / 1e6, 1) for one in children if one is not None}
        if self.engine is None or self._engine_since is None:
            return
        self.engine.wire.tell(alive="facts", **self._facts())
        over = 0 < self._orders.budget < self.engine.memory()
        if over and self.report.spare and now - self._engine_since > 30.0:
            self._say("the engine needs more memory than it may; another one takes over")
            self.engine.signal(signal.SIGKILL)

    def _leave(self, number: int) -> int:
        """Pass the signal on, and wait until the engine has closed everything."""
        engine = self.engine
        if engine is None:
            return 128 + number
        engine.signal(number)
        deadline = time.monotonic() + LEAVES_WITHIN
        while engine.process.poll() is None and time.monotonic() < deadline:
            for key, _ in self._selector.select(ROUND):
                key.data()
            engine.wire.flush()
        self._hear_rest(engine)
        self.engine = None
        code = engine.end(within=1.0)
        return code if code >= 0 else 128 - code

    def _close(self) -> None:
        for child in (self.spare, self.engine, self.audio, self.guard):
            if child is not None:
                child.signal(signal.SIGTERM)
                child.end()
        for pair in (self._sound or (), (self._osc,) if self._osc is not None else ()):
            for one in pair:
                one.close()
        self._selector.close()
        for note in self._disk.close():
            self._say(note)


def _how(code: int) -> str:
    """How a process ended, in words."""
    if code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"
