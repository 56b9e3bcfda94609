"""Session of a live show: engine, audio, services, records and notices; driven by a window or headless loop."""

import contextlib
import gc
import threading
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.practice import practice_events
from live.app.processes.resume_state import Resumed
from live.app.service_builder import Beside
from live.app.service_registry import Telling, make_watches
from live.app.services.audience_service import AudiencePart
from live.app.services.osc_services import OperatorsPort
from live.app.session_audio import SessionAudio, Sound, start_tempo
from live.app.session_records import Records, resident_megabytes
from live.base.errors import PersonError
from live.base.event_queue import Inbox
from live.base.fault_isolation import FAULTS, Bulkhead, keep_running, name_of, run_once
from live.clock.ticks import STALL
from live.clock.time_source import Clock, ProcessorClock, SystemClock
from live.control.events.events import ControlEvent, SetLatency
from live.show.engine import Engine
from live.show.loader import LoadedShow
from live.show.patch.hot_reload import PatchWatch
from live.show.selection.graph_update import LibraryWatch
from live.show.show import Show
from live.show.status import Pressure, Status
from live.show.venue.venue import Latencies, Venue
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import Lifeline

if TYPE_CHECKING:
    from live.app.services.midi_service import OnMidi
    from live.app.session_audio import AudioSource


PERIOD_S: Final = 1.0
"""Interval [s] between checks, which limits the notices on the terminal if the inputs are flooded."""
Words = Callable[[], str]


class News:
    """Prints notices when they change, in its own thread, so that a blocked terminal does not delay the show.

    Thread: once it runs, only its own thread calls `look`; `refused` may be read from any thread.
    """

    def __init__(self, refusals: Sequence[Words], others: Sequence[Words], say: Callable[[str], None]) -> None:
        """Each of `refusals` returns the last refusal of one service, each of `others` a notice; empty if none."""
        self._refusals, self._others, self._say = refusals, others, say
        self._before = [""] * (len(refusals) + len(others))
        self.refused = ""
        """The last refusal of all services: the one that changed last."""
        self._calls = Bulkhead()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="news", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def stop(self) -> None:
        """Stop the thread, and print the latest changes."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        if not self._thread.is_alive():
            self.look()

    def look(self) -> None:
        """Check once, and print changes."""
        for index, words in enumerate([*self._refusals, *self._others]):
            now, before = self._calls.call(f"notices of {name_of(words)}", words) or "", self._before[index]
            if now == before:
                continue
            self._before[index] = now
            refusal = index < len(self._refusals)
            if refusal and (now or self.refused == before):
                self.refused = now
            if now:
                self._say(f"refused: {now}" if refusal else now)

    def _run(self) -> None:
        keep_running("notices on the terminal", self._look_on, self._ended.wait)

    def _look_on(self) -> None:
        while not self._ended.wait(PERIOD_S):
            self.look()


def session_news(
    show: Show,
    osc: OperatorsPort,
    listens: "AudioSource | None",
    midi: "OnMidi | None",
    watch: PatchWatch,
    library: LibraryWatch | None,
    *,
    journal: Callable[[], str] = lambda: "",
    more: Sequence[Callable[[], str]] = (),
) -> News:
    """Return the terminal's notices of refusals, problems and new steps; with `--headless` there is no overlay.

    `listens`: the input device, if there is one; `more`: last refusals of further services.
    """
    console = Console(stderr=True, highlight=False)
    refusals: list[Callable[[], str]] = [osc.refusal, lambda: show.refusals.words, *more]
    before = FAULTS.news()  # left from another show in this process

    def faults() -> str:
        news = FAULTS.news()
        return news if news != before else ""

    others: list[Callable[[], str]] = [journal, faults]
    if listens is not None:
        others.append(lambda: _audio_problem(listens))
    if midi is not None:
        refusals.append(midi.refusal)
        others += [midi.problem, midi.note, midi.said]
    refusals.append(lambda: watch.problem)
    others.append(lambda: watch.told)
    if library is not None:
        refusals.append(lambda: library.problem)
        others.append(lambda: library.joined)

    def say(line: str) -> None:
        console.print(line, style="yellow", soft_wrap=True, markup=False)

    return News(refusals, others, say)


def _audio_problem(listens: "AudioSource") -> str:
    problem = str(listens.facts()["problem"])
    return f"sound: {problem}" if problem else ""


class Session:
    """A running show: engine, inputs, journal, status."""

    def __init__(
        self, options: LaunchOptions, loaded: LoadedShow, sound: Sound, venue: Venue | None = None, *,
        lifeline: Lifeline | None = None, resumed: Resumed | None = None,
    ) -> None:  # fmt: skip
        """Make everything without starting it; raise PersonError if something fails.

        `lifeline`: link to the supervisor, if there is one; `resumed`: the show to resume.
        """
        self.latencies = Latencies.of(venue)
        tempo = start_tempo(options, loaded, sound)
        show = loaded.start(seed=options.seed, tempo=tempo) if resumed is None else resumed.show
        self.lifeline = lifeline
        self._resumed = resumed
        self.options = options
        self.venue = venue
        self.loaded = loaded
        self.sound = sound
        self.show: Show = show
        self.clock = SystemClock(None if resumed is None else resumed.origin)
        self.processor: Clock = ProcessorClock()
        """CPU time of this thread."""
        self._processor_at = 0.0
        self.inbox: Inbox[ControlEvent] = Inbox()
        for event in practice_events(options, show) if resumed is None else ():
            self.inbox.put(event)
        self.osc = OperatorsPort(options, self.inbox, self.clock, lifeline)
        self._audio = SessionAudio(
            sound, loaded, show, self.latencies, self.inbox, self.clock, lifeline=lifeline, resumed=resumed
        )
        self._records = Records(options, loaded, sound, lifeline=lifeline, resumed=resumed)
        self.status = Status(
            show,
            rejected=lambda: sum((tell() for tell in self._parts.refused), self.osc.rejected()),
            memory=resident_megabytes(),
            level=lambda: self._audio.level,
            refusal=lambda: self.news.refused,
        )
        self._tempo = tempo
        stall = max(STALL, 3.0 / options.film_fps)  # a low frame rate is not a stall
        self.engine = Engine(
            show, clock=self.clock, inbox=self.inbox, status=self.status, lead=self.latencies.lead, stall=stall
        )
        self.engine.forgiving = True
        if lifeline is not None:
            self.engine.progress = lifeline.heart
            self.engine.gives_up = True
            show.breakers.publish(lifeline.heart.stage)
        self.engine.bulkhead = self._calls = Bulkhead()
        self.status.more["parts"] = FAULTS.facts
        self.status.notes.append(FAULTS.problem)
        self.engine.outward.append(self._tell_devices)
        self.pressure = Pressure()
        """Load measure, for code that can draw less."""
        self.status.more["pressure"] = lambda: round(self.pressure.value, 3)
        self.status.more["out_of_service"] = lambda: dict(show.breakers.why)
        self.status.notes.append(lambda: "   ".join(show.breakers.words()))
        self.status.more["failed_events"] = lambda: self.engine.failed
        self.status.more["latency"] = self.latencies.facts
        self.status.more["music"] = show.reactions.facts
        self.status.more["osc"] = self.osc.facts
        self._telling = Telling(show, self.status, self.latencies)
        self._telling.to.append(self.osc.tell)
        if self._audio.source is not None:
            self.status.more["audio"] = self._audio.source.facts
        if lifeline is not None:
            self.status.more["alive"] = lifeline.status
        beside = Beside(options, venue, self.inbox, self.clock, self.engine, self.status, self._telling)
        beside.goes_on = resumed is not None
        beside.music()
        self.midi = midi = beside.midi(loaded.path, 0 if resumed is None else resumed.tick)
        beside.osc()
        beside.bodies()
        beside.pages()
        self._parts = beside.parts
        self._watch, library = make_watches(loaded, show, post=self.inbox.put, now=self.clock.now)
        self.status.more["patch"] = self._watch.facts
        self.status.notes.append(lambda: self._watch.problem)
        self.status.notes.append(self._records.problem)
        self.news = session_news(
            show, self.osc, self._audio.listens, midi, self._watch, library, journal=self._records.problem,
            more=self._parts.refusals,
        )  # fmt: skip

    @property
    def audience(self) -> AudiencePart | None:
        """The service for the audience's phones; None if there is none."""
        return self._parts.audience

    @contextlib.contextmanager
    def running(self) -> Iterator["Session"]:
        """Start everything, and stop it at the end. Automatic garbage collection is off meanwhile.

        Under a supervisor an unrequested end is a crash: nothing is closed, because another engine resumes the show at
        once. The process may end at any moment.
        """
        wished = False
        try:
            if self._resumed is None:
                self.clock.origin = SystemClock().origin  # the show's time begins now
            self.osc.start()
            self._records.open_status(self.status)
            self._audio.start()
            self._parts.start(forgiving=self._resumed is not None)
            self._records.open_journal(
                self.engine, self.status, tempo=self._tempo, origin=self.clock.origin, begun=self._audio.begun
            )
            self._watch.start()
            self.news.start()
            if self._resumed is None:
                gc.collect()
            gc.freeze()
            gc.disable()
            if self._resumed is not None:
                self._catch_up(self._resumed)
            yield self
            wished = True
        except BaseException as error:
            refused = isinstance(error, PersonError) and not self.status.frames  # wrong options, no crash
            wished = self.lifeline is None or self.lifeline.may_leave
            if self.lifeline is not None and not wished and not refused:
                self.lifeline.crash(error)
            raise
        finally:
            if self.lifeline is not None:
                self.lifeline.beat(self.engine.ticks.index, Phase.LEAVING)
            gc.enable()
            gc.unfreeze()
            self._stop(ended=wished)

    def _catch_up(self, resumed: Resumed) -> None:
        """Run the ticks missed since the engine before ended, so that the show continues at its present time."""
        for what, seconds in resumed.latencies.items():
            self.latencies.set(what, seconds)
        self.engine.lead = self.latencies.lead
        self.engine.ticks.index = resumed.tick
        self.engine.run_to(self.clock.now() + self.engine.lead)

    def _tell_devices(self, event: ControlEvent) -> None:
        """Handle events that concern the audio device and the venue's delays."""
        if isinstance(event, SetLatency):
            self.latencies.set(event.what, event.seconds)
            self.engine.lead = self.latencies.lead
        self._audio.tell(event)

    def before_frame(self) -> None:
        """Receive input from other processes, before each frame, and start measuring its CPU time."""
        self._processor_at = self.processor.now()
        self._calls.call("the sound", self._audio.frame)
        self._calls.call("the OSC port", self.osc.frame)
        self._parts.before_frame()

    def _stop(self, *, ended: bool) -> None:
        for part in (self._audio, self._parts, self.osc, self._watch, self.news):
            run_once(f"the end of {name_of(part.stop)}", part.stop)
        self._records.close(self.engine.ticks.index, self.clock.now(), ended=ended)
        self._records.tell()

    def after_frame(self, started: float, previous: float) -> None:
        """Update statistics, services and records after a frame, and collect the youngest garbage generation."""
        self.status.work_times.add(self.clock.now() - started)
        self.status.processor_times.add(self.processor.now() - self._processor_at)
        self.status.frame_times.add(started - previous)
        self.pressure.frame(self.status.late_frames, started - previous, self.overload)
        self._parts.frame()
        self._calls.call("publishing values", self._telling.frame, started)
        self._calls.call("the records", self._records.frame, started)
        if self.lifeline is not None:
            self.lifeline.frame(self.engine.ticks.index)
            if self.lifeline.fenced and not self.engine.dark:
                self._go_dark()
        gc.collect(0)

    def _go_dark(self) -> None:
        """Stop picture, services and audio, because another machine leads."""
        self.engine.dark = True
        self._parts.stop()
        self._audio.silence()

    @property
    def overload(self) -> float:
        """Overload of the machine, 0 to 1, as measured by the supervisor; 0 without one."""
        return 0.0 if self.lifeline is None else float(self.lifeline.facts.get("overload", 0.0))

    def finished(self, time: float) -> bool:
        """Whether the time limit of `--seconds` is reached."""
        return self.options.seconds is not None and time >= self.options.seconds
