"""Session: a show with everything it listens to and writes; made here, driven by the window or a bare loop."""

import contextlib
import gc
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import psutil
from rich.console import Console

from live.alive.heartbeat import Phase
from live.alive.lifeline import Lifeline
from live.alive.relay import RelaySink
from live.base.errors import PersonError
from live.base.inbox import Inbox
from live.cli.audience_part import AudiencePart
from live.cli.audio_remote import RemoteAudio
from live.cli.beside import Beside
from live.cli.practice import practice_events, practice_tempo
from live.cli.resumed import Resumed
from live.cli.session_news import osc_rejected, session_news
from live.cli.session_sound import AudioSource, Sound, choose_sound, make_audio, sound_plan
from live.cli.telling import Telling
from live.cli.wish import Wish
from live.clock.source import SystemClock
from live.clock.ticks import STALL
from live.control.control import RANKS
from live.control.events import ControlEvent, SetLatency
from live.control.midi_song import read_song
from live.control.osc import CannotListen, OscInput
from live.control.osc_process import OscRemote
from live.control.sound_devices import device_refuses
from live.show.core import Show
from live.show.engine import Engine
from live.show.journal import JournalError, JournalWriter, trouble_of
from live.show.library_watch import LibraryWatch
from live.show.load import LoadedShow
from live.show.patch_watch import PatchWatch
from live.show.pressure import Pressure
from live.show.status import Status, StatusFile
from live.show.venue import Venue
from live.show.venue_latency import Latencies

SLOWEST, FASTEST = 20.0, 400.0
"""Tempos [bpm] that a show can begin with."""


def start_tempo(wish: Wish, loaded: LoadedShow, sound: Sound) -> float | None:
    """The tempo [bpm] to begin with; None if the patch's music is played and its own tempo and downbeat hold."""
    if wish.practises:
        return practice_tempo(wish, loaded)
    if wish.bpm is not None:
        return wish.bpm
    if wish.midi_file is not None:
        return min(max(read_song(wish.midi_file).tempo, SLOWEST), FASTEST)
    return None if sound.known else loaded.patch.clock.bpm


def resident_megabytes() -> Callable[[], float]:
    """A function that tells this process' resident memory [MB]."""
    process = psutil.Process()
    return lambda: float(process.memory_info().rss / 1e6)


class Session:
    """A running show: engine, inputs, journal, status."""

    def __init__(
        self,
        wish: Wish,
        loaded: LoadedShow,
        sound: Sound,
        venue: Venue | None = None,
        *,
        lifeline: Lifeline | None = None,
        resumed: Resumed | None = None,
    ) -> None:
        """Everything is made, nothing is started; PersonError for what cannot be.

        `lifeline`: to the supervisor, if there is one; `resumed`: the show that is gone on with.
        """
        self.latencies = Latencies.of(venue)
        tempo = start_tempo(wish, loaded, sound)
        show = loaded.start(seed=wish.seed, tempo=tempo) if resumed is None else resumed.show
        self.lifeline = lifeline
        practice = practice_events(wish, show) if resumed is None else []
        self._resumed = resumed
        self._remote: RemoteAudio | None = None
        self._relay: RelaySink | None = None
        self.wish = wish
        self.venue = venue
        self.loaded = loaded
        self.sound = sound
        self.show: Show = show
        self.clock = SystemClock(None if resumed is None else resumed.origin)
        self.inbox: Inbox[ControlEvent] = Inbox()
        for event in practice:
            self.inbox.put(event)
        operators = partial(self.inbox.lane, rank=RANKS["operator"])
        lane, inherited = operators(), None if lifeline is None else lifeline.osc
        self.osc: OscInput | OscRemote = (
            OscRemote(*wish.osc, lane, self.clock, inherited=inherited)
            if wish.osc_process
            else OscInput(*wish.osc, lane, self.clock, inherited=inherited, more=operators)
        )
        self._audio, self._tell_audio = self._make_audio()
        self.status = Status(
            show,
            rejected=lambda: sum((tell() for tell in self._parts.refused), osc_rejected(self.osc)),
            memory=resident_megabytes(),
            level=lambda: getattr(self._audio, "level", None),
            refusal=lambda: self.news.refused,
        )
        self._tempo = tempo
        self._journal: JournalWriter | None = None
        stall = max(STALL, 3.0 / wish.film_fps)  # a slow rate is no stall
        self.engine = Engine(
            show, clock=self.clock, inbox=self.inbox, status=self.status, lead=self.latencies.lead, stall=stall
        )
        self.engine.forgiving = True
        self.engine.outward.append(self._tell_devices)
        self.pressure = Pressure()
        """How hard it is to keep up, for whoever can draw less."""
        self.status.more["pressure"] = lambda: round(self.pressure.value, 3)
        self.status.more["failed_events"] = lambda: self.engine.failed
        self.status.more["latency"] = self.latencies.facts
        self.status.more["music"] = show.reactions.facts
        self.status.more["osc"] = self.osc.facts
        self._telling = Telling(show, self.status, self.latencies)
        self._telling.to.append(self.osc.tell)
        if self._audio is not None:
            self.status.more["audio"] = self._audio.facts
        if lifeline is not None:
            self.status.more["alive"] = lifeline.status
        beside = Beside(wish, venue, self.inbox, self.clock, self.engine, self.status, self._telling)
        beside.music()
        self.midi = midi = beside.midi(loaded.path, 0 if resumed is None else resumed.tick)
        beside.osc()
        beside.bodies()
        beside.pages()
        self._parts = beside.parts
        self._library = self._make_library()
        self._watch = PatchWatch(loaded, show, post=self.inbox.put, now=self.clock.now, library=self._library)
        self.status.more["patch"] = self._watch.facts
        self.status.notes.append(lambda: self._watch.problem)
        self.status.notes.append(self._journal_problem)
        listens = self._audio if sound.device is not None else None
        self.news = session_news(
            show,
            self.osc,
            listens,
            midi,
            self._watch,
            self._library,
            journal=self._journal_problem,
            more=self._parts.refusals,
        )
        self._status_file: StatusFile | None = None

    def _open_journal(self) -> None:
        """Begin the journal, last of all: a start that is refused leaves an old one of its name where it is."""
        header = self.loaded.header(self.show, tempo=self._tempo, music=self.sound.path)
        if self.lifeline is not None:
            begun = None if self._remote is None else self._remote.begun
            self._relay = RelaySink(self.lifeline.wire)
            header |= {"origin": self.clock.origin, "begun": begun}
            self._journal = JournalWriter(Path(), None if self._resumed else header, sink=self._relay)
        elif self.wish.journal is not None:
            try:
                self._journal = JournalWriter(self.wish.journal, header)
            except JournalError as error:
                raise PersonError(str(error)) from None
        else:
            return
        self._journal.prepare(self.show)
        self.status.more["journal"] = self._journal.facts
        self.engine.journal = self._journal

    @property
    def audience(self) -> AudiencePart | None:
        """What the audience's phones play through; None if they may not."""
        return self._parts.audience

    @contextlib.contextmanager
    def running(self) -> Iterator["Session"]:
        """Start everything; stop it again whatever happens. Automatic garbage collection rests meanwhile."""
        try:
            if self._resumed is None:
                self.clock.origin = SystemClock().origin  # the show's time begins now
            try:
                self.osc.start()
            except CannotListen as error:
                raise PersonError(str(error)) from None
            self._open_status()
            self._start_audio()
            self._parts.start()
            self._open_journal()
            self._watch.start()
            self.news.start()
            if self._resumed is None:
                gc.collect()
            gc.freeze()
            gc.disable()
            if self._resumed is not None:
                self._catch_up(self._resumed)
            yield self
        finally:
            if self.lifeline is not None:
                self.lifeline.beat(self.engine.ticks.index, Phase.LEAVING)
            gc.enable()
            gc.unfreeze()
            self._stop()

    def _catch_up(self, resumed: Resumed) -> None:
        """Dance what fell into the time in which nobody did: the show comes out where it would have been."""
        for what, seconds in resumed.latencies.items():
            self.latencies.set(what, seconds)
        self.engine.lead = self.latencies.lead
        self.engine.ticks.index = resumed.tick
        self.engine.run_to(self.clock.now() + self.engine.lead)

    def _journal_problem(self) -> str:
        """What is wrong with the journal; under a supervisor its disk is there."""
        if self._journal is None:
            return ""
        return self._journal.problem or trouble_of({} if self.lifeline is None else self.lifeline.facts.get("disk", {}))

    def _open_status(self) -> None:
        if self.wish.status_json is None:
            return
        try:
            self._status_file = StatusFile(self.wish.status_json, self.status, more=self._resumed is not None)
        except OSError as error:
            raise PersonError(f"cannot write --status-json {self.wish.status_json}: {error.strerror}") from None

    def _tell_devices(self, event: ControlEvent) -> None:
        """Events that concern the sound device and the venue's delays, not the dance."""
        if isinstance(event, SetLatency):
            self.latencies.set(event.what, event.seconds)
            self.engine.lead = self.latencies.lead
        self._tell_audio(event)

    def _make_audio(self) -> tuple[AudioSource | None, Callable[[ControlEvent], None]]:
        """The sound: in a process of its own where the supervisor has one."""
        there = None if self.lifeline is None else self.lifeline.sound
        if there is None or (self.sound.music is None and self.sound.device is None):
            return make_audio(self.sound, self.loaded, self.show, self.latencies, self.inbox, self.clock)
        plan = sound_plan(self.sound, self.loaded)
        self._remote = RemoteAudio(
            there, plan, self.show, self.latencies, self.inbox, self.clock, resumed=self._resumed
        )  # fmt: skip
        return self._remote, self._remote.act

    def before_frame(self) -> None:
        """What other processes heard since the last frame."""
        if self._remote is not None:
            self._remote.frame()
        if isinstance(self.osc, OscRemote):
            self.osc.frame()
        self._parts.before_frame()

    def _make_library(self) -> LibraryWatch | None:
        """Watches the show's own folder of steps, so that takes that are recorded meanwhile join the dance."""
        folder = self.loaded.steps_folder
        if folder is None:
            return None
        return LibraryWatch(
            folder, self.show.graph, offer=self.show.offer, post=self.inbox.put, now=self.clock.now,
            read=self.loaded.clips,
        )  # fmt: skip

    def _start_audio(self) -> None:
        if self._audio is None:
            return
        try:
            self._audio.start()
        except PersonError:
            raise
        except Exception as error:  # PortAudioError, whose class is known only where PortAudio is
            raise device_refuses(error, "--audio", self.sound.device) from None

    def warnings(self) -> list[str]:
        """What went wrong and did not stop the show, in words."""
        told = []
        if self._journal is not None and self._journal.kept is not None:
            told.append(f"the journal that was there is now {self._journal.kept}")
        if self._journal is not None and self._journal.dropped:
            told.append(f"{self._journal.dropped} lines of the journal could not be written: a replay leaves a gap")
        if self._status_file is not None and self._status_file.dropped:
            told.append(f"{self._status_file.dropped} status lines could not be written")
        return told

    def _stop(self) -> None:
        if self._audio is not None:
            self._audio.stop()
        self._parts.stop()
        self.osc.stop()
        self._watch.stop()
        self.news.stop()
        if self._journal is not None:
            self._journal.close(self.engine.ticks.index)
        if self._status_file is not None:
            self._status_file.close(self.clock.now())
        console = Console(stderr=True, highlight=False)
        for warning in self.warnings():
            console.print(f"note: {warning}", style="yellow", soft_wrap=True, markup=False)

    def after_frame(self, started: float, previous: float) -> None:
        """Housekeeping after a frame: figures, the status line, and garbage of the youngest generation."""
        self.status.work_times.add(self.clock.now() - started)
        self.status.frame_times.add(started - previous)
        self.pressure.frame(self.status.late_frames, started - previous)
        self._parts.frame()
        self._telling.frame(started)
        if self._status_file is not None:
            self._status_file.frame(started)
        if self.lifeline is not None and self._relay is not None:
            self._relay.flush()
            self.lifeline.frame(self.engine.ticks.index)
            if self.lifeline.fenced and not self.engine.dark:
                self._go_dark()
        gc.collect(0)

    def _go_dark(self) -> None:
        """Another machine leads: nothing is shown, sent or played here any more."""
        self.engine.dark = True
        self._parts.stop()
        if self._remote is not None:
            self._remote.silence()

    @property
    def deserted(self) -> bool:
        """Whether the supervisor, which has the terminal and the journal, has gone."""
        return self.lifeline is not None and self.lifeline.alone

    def finished(self, time: float) -> bool:
        """Whether `--seconds` are over."""
        return self.wish.seconds is not None and time >= self.wish.seconds


__all__ = ["Session", "Sound", "Wish", "choose_sound", "start_tempo"]
