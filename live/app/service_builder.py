"""Builder of a show's services from command line, venue and patch."""

from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.service_registry import ServiceRegistry, ValuePublisher
from live.app.services.audience_service import make_audience
from live.app.services.capture_services import make_psn, make_vmc
from live.app.services.click_service import make_click, make_link
from live.app.services.dmx_service import make_dmx
from live.app.services.http_services import OscQueryService, WebService
from live.app.services.midi_service import MidiFileService, MidiService, make_midi
from live.app.services.osc_services import MusicianOscPort, make_osc_out
from live.app.services.vmc_output_service import make_vmc_out
from live.base.event_queue import EventQueue
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.registry.control import ROLE_RANKS
from live.show.engine import Engine
from live.show.venue.venue import Venue
from live.show.view.status import Status


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

    def add_click_and_link(self) -> None:
        """Add click and Ableton Link."""
        show = self.engine.show
        click = make_click(self.options.click, self.options.click_channels, self.venue, show, self.clock)
        if click is not None:
            self.services.add(click)
            self.engine.event_listeners.append(click.handle)
            self.status.extra_figures["click"] = click.status
            track = click.output.track
            self.publisher.add_value("/dance/click", lambda: track.on)
        link = make_link(self.options.link, show, self.inbox, self.clock, Console(stderr=True, highlight=False))
        if link is not None:
            self.services.add(link)
            self.engine.event_listeners.append(link.handle)
            self.status.extra_figures["link"] = link.status

    def add_midi(self, patch: Path, resume_tick: int) -> MidiService:
        """Add MIDI ports and a MIDI file. `patch`: the patch's file; `resume_tick`: last tick before a resumed show."""
        midi = make_midi(self.options, self.engine.show, self.venue, self.inbox, self.clock, patch)
        self.services.add(midi)
        if self.options.midi_file is not None:
            file = MidiFileService(self.options.midi_file, self.engine.show, self.engine, resume_tick=resume_tick)
            self.services.add(file)
            self.status.extra_figures["midi_file"] = file.status
        self.engine.patch_listeners.append(midi.update_patch)
        self.engine.event_listeners.append(midi.handle)
        self.publisher.subscribers.append(midi.publish)
        self.status.extra_figures["midi"] = midi.status
        self.status.notices.append(midi.prompt)
        return midi

    def add_osc(self) -> None:
        """Add the musicians' port, OSC output, DMX and OSCQuery."""
        options, show, parts = self.options, self.engine.show, self.services
        if options.osc_musicians is not None:
            port = MusicianOscPort(
                *options.osc_musicians, self.inbox.add_queue(rank=ROLE_RANKS["musician"]), self.clock
            )
            parts.add(port)
            parts.refused_counts.append(port.refused)
            parts.refusals.append(port.refusal)
            self.publisher.subscribers.append(port.publish)
            self.status.extra_figures["osc_musicians"] = port.status
        out = make_osc_out(options, show, self.venue, self.clock, self.engine)
        if out is not None:
            parts.add(out)
            self.status.extra_figures["osc_out"] = out.status
        lamps = make_dmx(options, self.clock, self.engine)
        if lamps is not None:
            parts.add(lamps)
            self.publisher.subscribers.append(lamps.publish)
            self.status.extra_figures["dmx"] = lamps.status
        if options.oscquery is not None:
            query = OscQueryService(
                options.oscquery, options.osc, f"Live {show.patch.name}", self.clock, hosts=self._host_names
            )
            query.resumes = self.resumes
            parts.add(query)
            self.publisher.subscribers.append(query.publish)
            self.status.extra_figures["oscquery"] = query.status

    def add_mocap(self) -> None:
        """Add motion capture of real dancers, trackers, and avatars for other programs."""
        vmc = make_vmc(self.options, self.engine.show, self.venue, self.inbox.add_queue(), self.clock)
        if vmc is not None:
            self.services.add(vmc)
            self.services.refused_counts.append(vmc.refused)
            self.engine.patch_listeners.append(vmc.update_patch)
            self.status.extra_figures["vmc"] = vmc.status
        trackers = make_psn(self.options, self.venue, self.inbox.add_queue(), self.clock)
        if trackers is not None:
            self.services.add(trackers)
            self.services.refused_counts.append(trackers.refused)
            self.status.extra_figures["psn"] = trackers.status
        avatars = make_vmc_out(self.options, self.clock, self.engine)
        if avatars is not None:
            self.services.add(avatars)
            self.status.extra_figures["vmc_out"] = avatars.status

    @property
    def _host_names(self) -> tuple[str, ...]:
        """Host names of this machine besides its addresses."""
        return self.options.web_hosts + (() if self.venue is None else self.venue.web.hosts)

    def add_web(self) -> None:
        """Add the operator's web page and the audience's phones."""
        options, show = self.options, self.engine.show
        if options.web is not None:
            page = WebService(options.web, options.web_key, options.osc, show, self.clock, hosts=self._host_names)
            page.resumes = self.resumes
            self.services.add(page)
            self.publisher.subscribers.append(page.publish)
            self.status.extra_figures["web"] = page.status
        audience = make_audience(options, show, self.venue, self.inbox.add_queue(), self.clock)
        if audience is not None:
            audience.resumes = self.resumes
            self.services.add(audience)
            self.services.audience = audience
            self.services.before_frame_calls.append(audience.before_frame)
            self.services.refused_counts.append(audience.refused)
            self.status.extra_figures["audience"] = audience.status
