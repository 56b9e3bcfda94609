"""Builder of a show's services from command line, venue and patch."""

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console

from live.app.bridges import ServiceContext, installed_bridges
from live.app.launch_options import LaunchOptions
from live.app.services.audience_service import make_audience
from live.app.services.click_service import make_click, make_link
from live.app.services.document_service import DocumentService, edit_date
from live.app.services.gesture_service import GestureService
from live.app.services.grid_service import GridService
from live.app.services.midi_service import OFF, MidiFileService, MidiService, make_midi
from live.app.services.osc_services import MusicianOscPort, make_osc_out
from live.app.services.score_stream import ScoreStream
from live.app.services.service import Service
from live.app.services.service_registry import ServiceRegistry, ValuePublisher
from live.app.services.stage_stream import StageStream
from live.app.services.web_service import WebService, preview_files
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.time_source import Clock
from live.control.camera.phone_landmarks import PhoneCameras
from live.control.events.events import ControlEvent
from live.control.registry.control import ROLE_RANKS
from live.document.document_store import DocumentStore
from live.show.engine import Engine
from live.show.loader import LoadedShow
from live.show.patch.hot_reload import PatchWatch
from live.show.venue.venue import Venue
from live.show.view.next_formations import NextFormations
from live.show.view.status import Status

if TYPE_CHECKING:
    from live.app.services.phone_camera import PhoneCameraPort


@dataclass
class ServiceBuilder:
    """Makes services and connects them to the show; `services` holds those made so far, not started.

    Every method raises PersonError if a service cannot be made.
    """

    options: LaunchOptions
    venue: Venue | None
    inbox: EventQueue[ControlEvent]
    clock: Clock
    engine: Engine
    status: Status
    publisher: ValuePublisher
    resumes: bool = False
    """Whether the show is resumed after an engine that has ended."""
    services: ServiceRegistry = field(default_factory=ServiceRegistry)

    def add(self, name: str, service: Service) -> None:
        """Add a service by its name in the status, and connect all that it offers."""
        self.services.add(service)
        self.status.extra_figures[name] = service.status
        offers: dict[str, list[Any]] = {
            "before_frame": self.services.before_frame_calls,
            "publish": self.publisher.subscribers,
            "handle": self.engine.event_listeners,
            "update_patch": self.engine.patch_listeners,
            "refused": self.services.refused_counts,
            "refusal": self.services.refusals,
        }
        for method, listeners in offers.items():
            if hasattr(service, method):
                listeners.append(getattr(service, method))

    def add_click_and_link(self) -> None:
        """Add click and Ableton Link."""
        show = self.engine.show
        click = make_click(self.options.click, self.options.click_channels, self.venue, show, self.clock)
        if click is not None:
            self.add("click", click)
            track = click.output.track
            self.publisher.add_value("/dance/click", lambda: track.on)
        link = make_link(self.options.link, show, self.inbox, self.clock, Console(stderr=True, highlight=False))
        if link is not None:
            self.add("link", link)

    def add_midi(self, patch: Path, resume_tick: int) -> MidiService:
        """Add MIDI ports and a MIDI file. `patch`: the patch's file; `resume_tick`: last tick before a resumed show."""
        midi = make_midi(self.options, self.engine.show, self.venue, self.inbox, self.clock, patch)
        self.add("midi", midi)
        self.status.notices.append(midi.prompt)
        if self.options.midi_file is not None:
            self.add(
                "midi_file",
                MidiFileService(self.options.midi_file, self.engine.show, self.engine, resume_tick=resume_tick),
            )
        return midi

    def add_gestures(self, patch: Path) -> None:
        """Add the writer of learned gestures. `patch`: the patch's file."""
        gestures = GestureService(self.engine.show, patch)
        self.add("gestures", gestures)
        self.status.notices.append(gestures.notice)

    def add_grid(self) -> None:
        """Add a grid controller, named on the command line, by the venue or by the patch."""
        show, of_venue = self.engine.show, None if self.venue is None else self.venue.midi.grid
        name = self.options.grid or of_venue or show.patch.midi.grid
        if name is not None and name != OFF:
            grid = GridService(show, self.inbox.add_queue(rank=ROLE_RANKS["musician"]), self.clock, name)
            self.add("grid", grid)
            self.status.notices.append(grid.problem)

    def add_next_formations(self) -> NextFormations:
        """Add the suggestions of what could follow an element that has ended."""
        suggestions = NextFormations(self.engine.show)
        self.add("next", suggestions)
        self.publisher.add_value("/dance/status/next", suggestions.text)
        return suggestions

    def add_document(self, watch: PatchWatch, loaded: LoadedShow) -> DocumentService:
        """Add the editing of the show's files."""

        def open_store() -> DocumentStore:
            return DocumentStore(loaded.path, tables=loaded.tables, date=edit_date)

        document = DocumentService(watch, self.engine.show, loaded.path, open_store)
        self.add("document", document)
        self.publisher.add_value("/dance/status/document", lambda: document.revision)
        self.publisher.add_value("/dance/status/document_answers", lambda: document.published or None)
        self.publisher.add_value("/dance/status/document_log", lambda: document.log)
        return document

    def add_osc(self) -> None:
        """Add the musicians' port and OSC output."""
        options, show = self.options, self.engine.show
        if options.osc_musicians is not None:
            lane = self.inbox.add_queue(rank=ROLE_RANKS["musician"])
            self.add("osc_musicians", MusicianOscPort(*options.osc_musicians, lane, self.clock))
        out = make_osc_out(options, show, self.venue, self.clock, self.engine)
        if out is not None:
            self.add("osc_out", out)

    def add_bridges(self) -> None:
        """Add the services of all bridges, in the order of the bridges' names."""
        installed = installed_bridges()
        for bridge in installed.bridges:
            context = ServiceContext(
                options=self.options.of_bridge(bridge),
                engine=self.engine,
                venue=self.venue,
                clock=self.clock,
                add_queue=self.inbox.add_queue,
                osc=self.options.osc,
                host_names=self._host_names,
                resumes=self.resumes,
                phones=self._phones,
                notices=self.status.notices,
            )
            for name, service in bridge.services(context).items():
                self.add(name, service)
        self.status.extra_figures["bridges"] = installed.status

    @cached_property
    def _phones(self) -> PhoneCameras | None:
        """The phones that are cameras, if there is a page for them."""
        return None if self.options.phone_camera is None else PhoneCameras()

    @property
    def _host_names(self) -> tuple[str, ...]:
        """Host names of this machine besides its addresses."""
        return self.options.web_hosts + (() if self.venue is None else self.venue.web.hosts)

    def _phone_camera(self) -> "PhoneCameraPort | None":
        """Make the port for phones that are cameras; a show that is resumed goes on without one that cannot be."""
        if self.options.phone_camera is None:
            return None
        from live.app.services.phone_camera import PhoneCameraPort

        of_venue = None if self.venue is None else self.venue.audience
        try:
            return PhoneCameraPort(self.options, of_venue, self.options.web_key)
        except PersonError as error:
            if not self.resumes:
                raise
            note = Console(stderr=True, highlight=False)
            note.print(f"{error}: no phone can be a camera", style="bold red", markup=False)
            return None

    def add_web(self, loaded: LoadedShow, document: DocumentService, what_next: NextFormations) -> None:
        """Add the operator's web page, with a preview of these files and suggestions, and the audience's phones."""
        options, show = self.options, self.engine.show
        audience = make_audience(options, show, self.venue, self.inbox.add_queue(), self.clock)
        if options.phone_camera is not None and options.web is None:
            raise PersonError("--phone-camera: there is no camera page without --web", "--web 8010")
        if options.web is not None:
            score = ScoreStream(show, document)
            stage = StageStream(show, lambda: self.engine.view, score, lambda: self.status.late_frames, what_next.facts)
            page = WebService(
                options.web, options.web_key, options.osc, show, self.clock, hosts=self._host_names, stage=stage,
                files=preview_files(loaded, options.seed), inbox=self.inbox.add_queue(rank=ROLE_RANKS["operator"]),
                camera=self._phone_camera(), phones=self._phones,
            )  # fmt: skip
            page.resumes = self.resumes
            if audience is not None:
                page.join_link = lambda: audience.invitation_link
            document.answer_listeners.append(page.answer)
            self.add("web", page)
            self.services.web = page
        if audience is not None:
            audience.resumes = self.resumes
            self.add("audience", audience)
            self.services.audience = audience
