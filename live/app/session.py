"""Session of a live show: engine, audio, services, records and notices; driven by a window or headless loop."""

import contextlib
import gc
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.machine.kernel_loader import KernelLoader
from live.app.practice import practice_events
from live.app.processes.resume_state import ResumeState
from live.app.service_builder import ServiceBuilder
from live.app.services.audience_service import AudienceService
from live.app.services.gateway_status import GatewayStatus
from live.app.services.osc_services import OperatorOscPort
from live.app.services.service_registry import ValuePublisher, make_file_watches
from live.app.services.web_service import WebService
from live.app.session_audio import AudioChoice, SessionAudio, start_tempo
from live.app.session_records import SessionRecords, resident_megabytes
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.base.fault_isolation import FAULTS, Bulkhead, callback_name, run_once
from live.clock.ticks import STALL
from live.clock.time_source import Clock, ProcessorClock, SystemClock
from live.control.events.events import ControlEvent, SetLatency
from live.control.worker_thread import WorkerThread
from live.show.background_work import import_late_modules
from live.show.engine import Engine
from live.show.loader import LoadedShow
from live.show.partner.example_updates import ExamplesWatch
from live.show.patch.hot_reload import PatchWatch
from live.show.selection.library_watch import LibraryWatch
from live.show.show import Show
from live.show.stages.row_threads import row_threads
from live.show.venue.venue import Latencies, Venue
from live.show.view.status import Pressure, Status
from live.supervisor.heartbeat import Phase
from live.supervisor.supervisor_link import SupervisorLink

if TYPE_CHECKING:
    from live.app.services.midi_service import MidiService
    from live.app.session_audio import AudioSource


CHECK_INTERVAL: Final = 1.0
"""Interval [s] between checks, which limits the notices on the terminal if the inputs are flooded."""
NoticeText = Callable[[], str]


class Notifier:
    """Prints notices when they change, in its own thread, so that a blocked terminal does not delay the show.

    Thread: once it runs, only its own thread calls `check`; `refused` may be read from any thread.
    """

    def __init__(
        self, refusals: Sequence[NoticeText], notices: Sequence[NoticeText], output: Callable[[str], None]
    ) -> None:
        """Each of `refusals` returns the last refusal of one service, each of `notices` a notice; empty if none."""
        self._refusals, self._others, self._print = refusals, notices, output
        self._previous = [""] * (len(refusals) + len(notices))
        self.refused = ""
        """The last refusal of all services: the one that changed last."""
        self._calls = Bulkhead()
        self._worker = WorkerThread("news", self.check, part="notices on the terminal", every=CHECK_INTERVAL)

    def start(self) -> None:
        """Start the thread."""
        self._worker.start()

    def stop(self) -> None:
        """Stop the thread, and print the latest changes."""
        if self._worker.stop():
            self.check()

    def check(self) -> None:
        """Check once, and print changes."""
        for index, words in enumerate([*self._refusals, *self._others]):
            now, before = self._calls.call(f"notices of {callback_name(words)}", words) or "", self._previous[index]
            if now == before:
                continue
            self._previous[index] = now
            refusal = index < len(self._refusals)
            if refusal and (now or self.refused == before):
                self.refused = now
            if now:
                self._print(f"refused: {now}" if refusal else now)


def make_notifier(
    show: Show,
    osc: OperatorOscPort,
    input_source: "AudioSource | None",
    midi: "MidiService | None",
    watch: PatchWatch,
    library: LibraryWatch | None,
    examples: ExamplesWatch | None,
    *,
    journal: Callable[[], str] = lambda: "",
    extra_refusals: Sequence[Callable[[], str]] = (),
) -> Notifier:
    """Return the terminal's notices of refusals, problems and new steps; with `--headless` there is no overlay.

    `input_source`: the input device, if there is one; `extra_refusals`: last refusals of further services.
    """
    console = Console(stderr=True, highlight=False)
    refusals: list[Callable[[], str]] = [osc.refusal, lambda: show.refusals.last_reason, *extra_refusals]
    before = FAULTS.last_notice()  # left from another show in this process

    def faults() -> str:
        news = FAULTS.last_notice()
        return news if news != before else ""

    others: list[Callable[[], str]] = [journal, faults]
    if input_source is not None:
        others.append(lambda: _audio_problem(input_source))
    if midi is not None:
        others += [midi.problem, midi.prompt, midi.last_change]
    refusals.append(lambda: watch.problem)
    others += [lambda: watch.message, lambda: watch.learnt]
    if library is not None:
        refusals.append(lambda: library.problem)
        others.append(lambda: library.last_change)
    if examples is not None:
        refusals.append(lambda: examples.problem)
        others.append(lambda: examples.last_change)

    def say(line: str) -> None:
        console.print(line, style="yellow", soft_wrap=True, markup=False)

    return Notifier(refusals, others, say)


def _audio_problem(listens: "AudioSource") -> str:
    problem = str(listens.status()["problem"])
    return f"sound: {problem}" if problem else ""


def nodes_notice(nodes: Mapping[str, Mapping[str, Any]]) -> str:
    """Return what the operator has to know of the render nodes; empty if all follow. `nodes`: state of each by name."""
    return "   ".join(
        f"node {name}: {told['state']}" + (f" ({told['why']})" if told["why"] else "")
        for name, told in nodes.items()
        if told["state"] != "follows"
    )


class Session:
    """A running show: engine, inputs, journal, status."""

    def __init__(
        self, options: LaunchOptions, loaded: LoadedShow, sound: AudioChoice, venue: Venue | None = None, *,
        lifeline: SupervisorLink | None = None, resumed: ResumeState | None = None,
    ) -> None:  # fmt: skip
        """Make everything without starting it; raise PersonError if something fails.

        `lifeline`: link to the supervisor, if there is one; `resumed`: the show to resume.
        """
        self.latencies = Latencies.of(venue, nodes=options.nodes is not None)
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
        self.cpu_clock: Clock = ProcessorClock()
        """CPU time of this thread."""
        self._frame_cpu_start = 0.0
        self.inbox: EventQueue[ControlEvent] = EventQueue()
        for event in practice_events(options, show) if resumed is None else ():
            self.inbox.put(event)
        self.osc = OperatorOscPort(options, self.inbox, self.clock, lifeline)
        self._audio = SessionAudio(
            sound, loaded, show, self.latencies, self.inbox, self.clock, lifeline=lifeline, resumed=resumed
        )
        self._records = SessionRecords(options, loaded, sound, lifeline=lifeline, resumed=resumed)
        self.status = Status(
            show,
            rejected=lambda: sum((tell() for tell in self._services.refused_counts), self.osc.rejected()),
            memory=resident_megabytes(),
            level=lambda: self._audio.level,
            refusal=lambda: self.notifier.refused,
        )
        self._tempo = tempo
        self._late_imports: threading.Thread | None = None
        stall = max(STALL, 3.0 / options.film_fps)  # a low frame rate is not a stall
        self.engine = Engine(
            show, clock=self.clock, inbox=self.inbox, status=self.status, lead=self.latencies.lead, stall=stall
        )
        self.engine.refuse_failing = True
        if lifeline is not None:
            self.engine.progress = lifeline.heartbeat
            self.engine.raise_when_undrawn = True
            show.breakers.publish(lifeline.heartbeat.stage)
        self.engine.bulkhead = self._calls = Bulkhead()
        self.status.extra_figures["parts"] = FAULTS.facts
        self.status.notices.append(FAULTS.problem)
        self.engine.event_listeners.append(self._handle_device_event)
        self.engine.patch_listeners.append(self._audio.update_patch)
        self.pressure = Pressure()
        """Load measure, for code that can draw less."""
        self.status.extra_figures["pressure"] = lambda: round(self.pressure.value, 3)
        self.status.extra_figures["out_of_service"] = lambda: dict(show.breakers.reasons)
        self.status.notices.append(lambda: "   ".join(show.breakers.status_lines()))
        self.status.extra_figures["failed_events"] = lambda: self.engine.failed_events
        self.status.extra_figures["latency"] = self.latencies.facts
        self.status.extra_figures["music"] = show.reactions.facts
        self.status.extra_figures["osc"] = self.osc.status
        self._publisher = ValuePublisher(show, self.status, self.latencies)
        self._publisher.subscribers.append(self.osc.publish)
        if self._audio.source is not None:
            self.status.extra_figures["audio"] = self._audio.source.status
        if lifeline is not None:
            self.status.extra_figures["alive"] = lifeline.status
            self.status.notices.append(lambda: nodes_notice(lifeline.facts.get("nodes", {})))
        beside = ServiceBuilder(options, venue, self.inbox, self.clock, self.engine, self.status, self._publisher)
        beside.resumes = resumed is not None
        beside.add_click_and_link()
        self.midi = midi = beside.add_midi(loaded.path, 0 if resumed is None else resumed.tick)
        if not options.no_record:
            beside.add_gestures(loaded.path)
        beside.add_grid()
        beside.add_osc()
        beside.add_bridges()
        self._kernels = KernelLoader()
        if self._kernels.compiles:
            self.engine.holding = lambda: self._kernels.compiles
            self.status.notices.append(lambda: self._kernels.notice)
        self._watch, library, examples = make_file_watches(loaded, show, post=self.inbox.put, now=self.clock.now)
        self._watch.keeps_learnt = not options.no_record
        self.status.extra_figures["patch"] = self._watch.status
        if examples is not None:
            self.status.extra_figures["examples"] = examples.facts
        self.document = beside.add_document(self._watch, loaded)
        beside.add_web(loaded, self.document, beside.add_next_formations())
        self._services = beside.services
        audience = beside.services.audience
        self._gateways = None if audience is None or lifeline is None else GatewayStatus(audience, lifeline)
        self.status.notices.append(lambda: self._watch.problem)
        self.status.notices.append(self._records.problem)
        self.notifier = make_notifier(
            show, self.osc, self._audio.input_source, midi, self._watch, library, examples,
            journal=self._records.problem, extra_refusals=self._services.refusals,
        )  # fmt: skip

    @property
    def web(self) -> WebService | None:
        """The service of the web pages; None if there is none."""
        return self._services.web

    @property
    def audience(self) -> AudienceService | None:
        """The service for the audience's phones; None if there is none."""
        return self._services.audience

    @contextlib.contextmanager
    def running(self) -> Iterator["Session"]:
        """Start everything, and stop it at the end. Automatic garbage collection is off meanwhile.

        Under a supervisor an unrequested end is a crash: nothing is closed, because another engine resumes the show at
        once. The process may end at any moment.
        """
        with row_threads(), self._all_running():
            yield self

    @contextlib.contextmanager
    def _all_running(self) -> Iterator[None]:
        wished = False
        try:
            if self._resumed is None:
                self.clock.origin = SystemClock().origin  # the show's time begins now
            self.osc.start()
            self._records.open_status(self.status)
            self._audio.start()
            self._services.start(tolerant=self._resumed is not None)
            self._records.open_journal(
                self.engine,
                self.status,
                tempo=self._tempo,
                origin=self.clock.origin,
                audio_start=self._audio.start_time,
            )
            if self.lifeline is not None:
                self.lifeline.channel.send_json(alive="clock", origin=self.clock.origin)
            self._watch.start()
            self.notifier.start()
            gc.freeze()  # without a search before: it takes 0.2 s, and a show that is built leaves next to nothing
            gc.disable()
            if self._resumed is not None:
                self._catch_up(self._resumed)
            yield
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

    def _catch_up(self, resumed: ResumeState) -> None:
        """Run the ticks missed since the engine before ended, so that the show continues at its present time."""
        for what, seconds in resumed.latencies.items():
            self.latencies.set(what, seconds)
        self.engine.lead = self.latencies.lead
        self.engine.ticks.index = resumed.tick
        self.engine.run_to(self.clock.now() + self.engine.lead)

    def _handle_device_event(self, event: ControlEvent) -> None:
        """Handle events that concern the audio device and the venue's delays."""
        if isinstance(event, SetLatency):
            self.latencies.set(event.what, event.seconds)
            self.engine.lead = self.latencies.lead
        self._audio.handle(event)

    def before_frame(self) -> None:
        """Receive input from other processes, before each frame, and start measuring its CPU time."""
        self._frame_cpu_start = self.cpu_clock.now()
        self._calls.call("loading kernels", self._kernels.frame)
        self._calls.call("the sound", self._audio.frame)
        self._calls.call("the OSC port", self.osc.frame)
        self._services.before_frame()

    def _stop(self, *, ended: bool) -> None:
        run_once("the end of compiling", self._kernels.close)
        for part in (self._audio, self._services, self.osc, self._watch, self.notifier):
            run_once(f"the end of {callback_name(part.stop)}", part.stop)
        self._records.close(self.engine.ticks.index, self.clock.now(), ended=ended)
        self._records.print_warnings()

    def after_frame(self, started: float, previous: float) -> None:
        """Update statistics, services and records after a frame, and collect the youngest garbage generation."""
        if self._late_imports is None:
            task = "importing what later frames need", import_late_modules
            self._late_imports = threading.Thread(target=run_once, args=task, daemon=True)
            self._late_imports.start()
        self.status.work_times.add(self.clock.now() - started)
        self.status.processor_times.add(self.cpu_clock.now() - self._frame_cpu_start)
        self.status.frame_times.add(started - previous)
        self.pressure.frame(self.status.late_frames, started - previous, self.overload)
        self._calls.call("learning steps", self._watch.frame)
        self._services.frame()
        self._calls.call("publishing values", self._publisher.frame, started)
        self._calls.call("the records", self._records.frame, started)
        if self._gateways is not None:
            self._calls.call("the gateways' status", self._gateways.frame, started)
        if self.lifeline is not None:
            self.lifeline.end_frame(self.engine.ticks.index)
            if self.lifeline.fenced and not self.engine.blanked:
                self._go_dark()
        gc.collect(0)

    def _go_dark(self) -> None:
        """Stop picture, services and audio, because another machine leads."""
        self.engine.blanked = True
        self._services.stop()
        self._audio.silence()

    @property
    def overload(self) -> float:
        """Overload of the machine, 0 to 1, as measured by the supervisor; 0 without one."""
        return 0.0 if self.lifeline is None else float(self.lifeline.facts.get("overload", 0.0))

    def finished(self, time: float) -> bool:
        """Whether the time limit of `--seconds` is reached; raises SystemExit if the supervisor asks for the end."""
        if self.lifeline is not None:
            self.lifeline.leave_if_asked()
        return self.options.seconds is not None and time >= self.options.seconds
