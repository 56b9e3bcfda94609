"""Builder of a show's services from command line, venue and patch."""

from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.service_registry import Parts, Telling
from live.app.services.audience_service import make_audience
from live.app.services.capture_services import make_psn, make_vmc
from live.app.services.click_service import make_click, make_link
from live.app.services.dmx_service import make_dmx
from live.app.services.http_services import OscQueryPart, WebPart
from live.app.services.midi_service import MidiFilePart, OnMidi, make_midi
from live.app.services.osc_services import MusiciansPort, make_osc_out
from live.app.services.vmc_output_service import make_vmc_out
from live.base.event_queue import Inbox
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.registry.control import RANKS
from live.show.engine import Engine
from live.show.status import Status
from live.show.venue.venue import Venue


@dataclass
class Beside:
    """Makes services and connects them to the show; `parts` holds those made so far, not started.

    Every method raises PersonError if a service cannot be made.
    """

    options: LaunchOptions
    venue: Venue | None
    inbox: Inbox[ControlEvent]
    clock: Clock
    engine: Engine
    status: Status
    telling: Telling
    goes_on: bool = False
    """Whether the show is resumed after an engine that has ended."""
    parts: Parts = field(default_factory=Parts)

    def music(self) -> None:
        """Add click and Ableton Link."""
        show = self.engine.show
        click = make_click(self.options.click, self.options.click_channels, self.venue, show, self.clock)
        if click is not None:
            self.parts.add(click)
            self.engine.outward.append(click.heard)
            self.status.more["click"] = click.status
            track = click.output.track
            self.telling.know("/dance/click", lambda: track.on)
        link = make_link(self.options.link, show, self.inbox, self.clock, Console(stderr=True, highlight=False))
        if link is not None:
            self.parts.add(link)
            self.engine.outward.append(link.heard)
            self.status.more["link"] = link.status

    def midi(self, patch: Path, begun: int) -> OnMidi:
        """Add MIDI ports and a MIDI file. `patch`: the patch's file; `begun`: the last tick before a resumed show."""
        midi = make_midi(self.options, self.engine.show, self.venue, self.inbox, self.clock, patch)
        self.parts.add(midi)
        if self.options.midi_file is not None:
            file = MidiFilePart(self.options.midi_file, self.engine.show, self.engine, begun=begun)
            self.parts.add(file)
            self.status.more["midi_file"] = file.status
        self.engine.patched.append(midi.take_patch)
        self.engine.outward.append(midi.act)
        self.telling.to.append(midi.tell)
        self.status.more["midi"] = midi.status
        self.status.notes.append(midi.note)
        return midi

    def osc(self) -> None:
        """Add the musicians' port, OSC output, DMX and OSCQuery."""
        options, show, parts = self.options, self.engine.show, self.parts
        if options.osc_musicians is not None:
            port = MusiciansPort(*options.osc_musicians, self.inbox.lane(rank=RANKS["musician"]), self.clock)
            parts.add(port)
            parts.refused.append(port.refused)
            parts.refusals.append(port.refusal)
            self.telling.to.append(port.tell)
            self.status.more["osc_musicians"] = port.status
        out = make_osc_out(options, show, self.venue, self.clock, self.engine)
        if out is not None:
            parts.add(out)
            self.status.more["osc_out"] = out.status
        lamps = make_dmx(options, self.clock, self.engine)
        if lamps is not None:
            parts.add(lamps)
            self.telling.to.append(lamps.tell)
            self.status.more["dmx"] = lamps.status
        if options.oscquery is not None:
            query = OscQueryPart(
                options.oscquery, options.osc, f"Live {show.patch.name}", self.clock, hosts=self._hosts
            )
            query.goes_on = self.goes_on
            parts.add(query)
            self.telling.to.append(query.tell)
            self.status.more["oscquery"] = query.status

    def bodies(self) -> None:
        """Add motion capture of real dancers, trackers, and avatars for other programs."""
        vmc = make_vmc(self.options, self.engine.show, self.venue, self.inbox.lane(), self.clock)
        if vmc is not None:
            self.parts.add(vmc)
            self.parts.refused.append(vmc.refused)
            self.engine.patched.append(vmc.take_patch)
            self.status.more["vmc"] = vmc.status
        trackers = make_psn(self.options, self.venue, self.inbox.lane(), self.clock)
        if trackers is not None:
            self.parts.add(trackers)
            self.parts.refused.append(trackers.refused)
            self.status.more["psn"] = trackers.status
        avatars = make_vmc_out(self.options, self.clock, self.engine)
        if avatars is not None:
            self.parts.add(avatars)
            self.status.more["vmc_out"] = avatars.status

    @property
    def _hosts(self) -> tuple[str, ...]:
        """Host names of this machine besides its addresses."""
        return self.options.web_hosts + (() if self.venue is None else self.venue.web.hosts)

    def pages(self) -> None:
        """Add the operator's web page and the audience's phones."""
        options, show = self.options, self.engine.show
        if options.web is not None:
            page = WebPart(options.web, options.web_key, options.osc, show, self.clock, hosts=self._hosts)
            page.goes_on = self.goes_on
            self.parts.add(page)
            self.telling.to.append(page.tell)
            self.status.more["web"] = page.status
        audience = make_audience(options, show, self.venue, self.inbox.lane(), self.clock)
        if audience is not None:
            audience.goes_on = self.goes_on
            self.parts.add(audience)
            self.parts.audience = audience
            self.parts.early.append(audience.before_frame)
            self.parts.refused.append(audience.refused)
            self.status.more["audience"] = audience.status
