"""Supervisor: starts the processes of a show, watches their heartbeats and replaces a failed engine.

It opens no device and no window and computes nothing, which leaves little that can fail. It runs in the process that
the person started, so it has the terminal, its signals and the exit code. It is one loop without threads, except for
the journal's writer and the one that connects to other machines.
"""

import selectors
import signal
import socket
import time
from collections.abc import Callable
from typing import Any, Final

from live.base.system.channel import packet_pair
from live.show.journal.line_writer import WriteProgress
from live.supervisor.adoption.adoption import Adoption
from live.supervisor.adoption.audio_adoption import adopt_audio
from live.supervisor.adoption.journal_resume import InterruptedShow
from live.supervisor.adoption.rendezvous import RendezvousListener
from live.supervisor.engine_failover import EngineFailover
from live.supervisor.line_channel import LineChannel
from live.supervisor.network.peer_messages import read_line
from live.supervisor.network.remote_standby import RemoteStandby
from live.supervisor.process import AuxiliaryProcess, Child, ProcessManager
from live.supervisor.process_stats import Reaper
from live.supervisor.recovery_log import JournalDisk
from live.supervisor.supervisor_config import Report, SupervisorConfig

REPORT_INTERVAL: Final = 1.0
CONFIRM_EVERY: Final = 0.2
CHANNEL_SHIFT: Final = 40
"""Bits of a line's number for its count on its channel; the bits above count the channels."""
SETTLED: Final = 30.0
"""Seconds that an engine has run before its memory is judged."""


class Supervisor:
    """Runs a show until it ends. Thread: the one that made it."""

    def __init__(
        self,
        config: SupervisorConfig,
        say: Callable[[str], None],
        adoption: Adoption | None = None,
        interrupted: InterruptedShow | None = None,
    ) -> None:
        """`say`: prints a line for the person; `adoption`: a running engine whose supervisor has died; `interrupted`:
        an interrupted show of which no process is left."""
        self._config, self._say = config, say
        self.report = Report()
        self._starter = ProcessManager()
        self._reaper = Reaper()
        self._disk = JournalDisk(config.journal, say)
        there = {} if adoption is None else adoption.descriptors
        self._sound = self._sound_pair(there) if config.audio else None
        self._rendezvous = self._open_rendezvous(adoption)
        self._osc_pair = packet_pair() if config.osc_reader else None
        inherit = {} if config.osc is None else {"osc": config.osc.fileno()}
        if self._osc_pair is not None:
            inherit["osc_reader"] = self._osc_pair[0].fileno()
        if self._sound is not None:
            inherit |= {"sound": self._sound[0].fileno(), "sound_peer": self._sound[1].fileno()}
        if self._rendezvous is not None:
            inherit["rendezvous"] = self._rendezvous.socket.fileno()
        self.engines = EngineFailover(config, self._starter, self.report, say, inherit)
        self.engines.on_line, self.engines.on_request = self._broadcast, self._handle_request
        fullscreen, monitor = config.screen
        self.engines.screen = {"alive": "screen", "fullscreen": fullscreen, "monitor": monitor}
        self.audio, self.fallback_window = (
            AuxiliaryProcess(self._start_audio, say),
            AuxiliaryProcess(self._start_fallback_window, say),
        )
        self.osc_reader = AuxiliaryProcess(self._start_osc_reader, say)
        self._remote = RemoteStandby(config, self._starter, self.engines, self.report, say)
        if config.nodes is not None:
            config.nodes.on_restart = self._restart_part
        self._page = AuxiliaryProcess(self._start_page, say)
        self._page_follows: bool | None = None  # whether the relay of the page was started for another leader's show
        self._tell_at = self._confirm_at = 0.0
        self._last_channel: LineChannel | None = None
        self._channel_count = 0  # number of channels that have carried lines of the show
        self._confirmed: tuple[LineChannel, WriteProgress, int] | None = None
        self._writing_engine: Child | None = None
        self._osc_reading_engine: Child | None = None  # an adopted engine that still has its own OSC reader process
        self._osc_reader_due = bool(config.osc_reader)  # once an engine runs: messages wait in the socket until then
        if adoption is not None:
            self._adopt(adoption)
        elif interrupted is not None:
            self.engines.resume(interrupted)
            self._disk.prepare_resume(interrupted.unwritten, interrupted.snapshots_kept)
            self._disk.resume()
        self._starter.on_drain = self._remote.update

    def run(self) -> int:
        """Start everything, keep it running, and return the exit code of the last engine."""
        try:
            now = time.monotonic()
            if self._config.audio and self.audio.child is None:
                self.audio.begin(now)
            if self._config.fallback_window:
                self.fallback_window.begin(now)
            while self.engines.code is None:
                self._turn()
            return self.engines.code
        except (KeyboardInterrupt, SystemExit) as ended:
            number = signal.SIGINT if isinstance(ended, KeyboardInterrupt) else int(str(ended.code)) - 128
            return self.engines.leave(number)
        finally:
            self._close()

    def _turn(self) -> None:
        now = self._starter.poll()
        self.engines.update(now)
        slowdown = self._starter.load.slowdown
        self.audio.update(now, slowdown)
        self.fallback_window.update(now, slowdown)
        self.osc_reader.update(now, slowdown)
        self._reaper.update(now)
        self._remote.update(now)
        if self._config.nodes is not None:
            self._config.nodes.update(self.engines.log, self.report)
        if self._config.page:
            self._update_page(now, slowdown)
        if self._writing_engine is not None and self._writing_engine is not self.engines.engine:
            self._resume_journal()
        if self._osc_reading_engine is not None and self._osc_reading_engine is not self.engines.engine:
            self._osc_reading_engine = None
        if self._osc_reader_due and self._osc_reading_engine is None and self.engines.has_run:
            self._osc_reader_due = False
            self.osc_reader.begin(now)
        if now >= self._confirm_at:
            self._confirm_at = now + CONFIRM_EVERY
            self._confirm()
        if now >= self._tell_at:
            self._tell_at = now + REPORT_INTERVAL
            self._send_report(now)

    def _broadcast(self, line: str, kept: bool) -> None:
        self._remote.broadcast(line)
        if self._config.nodes is not None:
            self._config.nodes.add_line(line)
        if kept:
            wire, count = self.engines.line_position
            if wire is not self._last_channel:
                self._last_channel, self._channel_count = wire, self._channel_count + 1
            self._disk.write(line, self._channel_count << CHANNEL_SHIFT | count)

    def _confirm(self) -> None:
        """Report to the engine which of its lines are on disk: it keeps them until then."""
        engine, done = self.engines.engine, self._disk.written
        if engine is None or done is None or self._confirmed == (engine.channel, *done):
            return
        self._confirmed = (engine.channel, *done)
        written, kept = done
        own = engine.channel is self._last_channel and written.number >> CHANNEL_SHIFT == self._channel_count
        number = written.number & ((1 << CHANNEL_SHIFT) - 1) if own else 0
        engine.channel.send_json(alive="written", line=number, end=written.end, missing=written.missing, snapshots=kept)

    def _handle_request(self, asked: dict[str, Any]) -> None:
        """Handle a request of an engine to other parts."""
        if asked["alive"] == "screen":
            self.engines.screen = asked
            if self.fallback_window.child is not None:
                self.fallback_window.child.channel.send_json(**asked)
        elif asked["alive"] == "takeover":
            self._remote.promote("on command")
        elif asked["alive"] == "cannot":
            self._remote.report_cannot_follow(asked["why"])
        elif asked["alive"] == "clock":
            self.report.origin = asked["origin"]
        elif asked["alive"] == "gateways":
            self.report.gateways = asked["rows"]
        elif asked["alive"] == "journal":
            self._resume_journal()
        elif asked["alive"] == "following":
            self.report.compared, self.report.different = asked["compared"], asked["different"]
            self.report.repaired = asked["repaired"]
            self._remote.set_ready(bool(asked["ready"]))

    def _restart_part(self, kind: str, name: str, process: str) -> None:
        """Start a standby machine, a gateway or the reducer again, on an operator's order."""
        if kind == "standby":
            self._remote.restart_follower(name, process)
        elif self.engines.engine is not None:
            self.engines.engine.channel.send_json(alive="restart", kind=kind, name=name, process=process)

    # -- adoption of a running engine -----------------------------------------------------------------------------

    def _sound_pair(self, there: dict[str, int]) -> tuple[socket.socket, socket.socket]:
        if "sound" in there and "sound_peer" in there:
            return socket.socket(fileno=there["sound"]), socket.socket(fileno=there["sound_peer"])
        return packet_pair()

    def _open_rendezvous(self, adoption: Adoption | None) -> RendezvousListener | None:
        """Return the socket where another supervisor finds the engine; None if there is none, which matters only if
        this process dies."""
        meeting = None
        if adoption is not None:
            meeting = RendezvousListener.inherited(adoption.descriptors["rendezvous"], adoption.name)
        elif self._config.label:
            try:
                meeting = RendezvousListener(self._config.label)
            except OSError as error:
                self._say(f"if this process dies, no other one can adopt the engine: {error.strerror}")
        if meeting is not None:
            self._starter.selector.register(meeting.socket, selectors.EVENT_READ, meeting.refuse)
        return meeting

    def _adopt(self, adoption: Adoption) -> None:
        self.report.restore(adoption.facts)
        self.report.adopted += 1
        self._disk.prepare_resume(adoption.unwritten, adoption.snapshots_kept)
        self.engines.adopt(adoption)
        self._writing_engine = self.engines.engine
        self._osc_reading_engine = self.engines.engine if self._config.osc_reader else None
        if self._sound is not None:
            self.audio.child = adopt_audio(self._starter, self._sound[0])

    def _resume_journal(self) -> None:
        """Resume the journal: the adopted engine has stopped writing it."""
        self._writing_engine = None
        self._disk.resume()

    def _start_audio(self) -> Child:
        assert self._sound is not None
        theirs = self._sound[1].fileno()
        return self._starter.start("audio", [*self._config.audio, str(theirs)], lambda line: None, theirs)

    def _start_fallback_window(self) -> Child:
        child = self._starter.start("guard", self._config.fallback_window, lambda line: None)
        child.channel.send_json(**self.engines.screen)
        return child

    def _start_osc_reader(self) -> Child:
        assert self._osc_pair is not None
        assert self._config.osc is not None
        theirs = (self._osc_pair[1].fileno(), self._config.osc.fileno())
        return self._starter.start("OSC", [*self._config.osc_reader, *map(str, theirs)], lambda line: None, *theirs)

    def _update_page(self, now: float, slowdown: float) -> None:
        """Relay the operator's page: to other machines while this one leads, else from the one that leads."""
        follows = self.engines.role == "standby"
        if follows is not self._page_follows:
            self._page.close()
            self._page_follows = follows
            self._page.begin(now)
        self._page.update(now, slowdown)

    def _start_page(self) -> Child:
        child = self._starter.start("page", self._config.page, self._hear_page)
        plan = self._config.page_plan(self.engines.show, bool(self._page_follows))
        child.channel.send_json(alive="page", show=plan)
        return child

    def _hear_page(self, line: str) -> None:
        told = read_line(line)
        if told.get("alive") == "note":
            self._say(str(told.get("words")))

    def _send_report(self, now: float) -> None:
        """Send the report to the engine, and check its memory."""
        engine, since = self.engines.engine, self.engines.running_since
        children = (engine, self.engines.spare, self.engines.prefork.child, self.audio.child,
                    self.fallback_window.child, self.osc_reader.child)  # fmt: skip
        self.report.memory_mb = {one.role: round(one.memory() / 1e6, 1) for one in children if one is not None}
        self.report.disk = self._disk.facts()
        self.report.slowdown, self.report.reaped = round(self._starter.load.slowdown, 2), self._reaper.count
        self.report.audio_restarts, self.report.guard = self.audio.restarts, self.fallback_window.child is not None
        self.report.osc_restarts, self.report.standbys = self.osc_reader.restarts, self._remote.standbys()
        if engine is None or since is None:
            return
        engine.channel.send_json(alive="facts", facts=self.engines.facts())
        if 0 < self._config.memory_budget < engine.memory() and self.report.spare and now - since > SETTLED:
            self._say("the engine uses more memory than allowed: the spare engine replaces it")
            engine.kill()

    def _close(self) -> None:
        self._remote.close()
        if self._config.nodes is not None:
            self._config.nodes.close()
        self.engines.close()
        self.audio.close()
        self.fallback_window.close()
        self.osc_reader.close()
        self._page.close()
        for one in (*(self._sound or ()), *(self._osc_pair or ())):
            one.close()
        if self._rendezvous is not None:
            self._rendezvous.close()
        if self._config.osc is not None:
            self._config.osc.close()
        self._starter.close()
        for note in self._disk.close():
            self._say(note)
