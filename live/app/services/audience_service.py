"""Service for the audience's phones: connects the show to the gateway process."""

import importlib.util
import math
import socket
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

from rich.console import Console

from live.app.services.audience_tls import TlsIdentity, read_identity, venue_tls_files
from live.app.services.gateway_shards import GatewayShards
from live.app.services.http_services import own_address
from live.app.services.listening_socket import listening_socket
from live.base.errors import PersonError
from live.base.event_queue import PriorityQueue
from live.base.picture_parameters import COLOURS_START, STYLES_START
from live.base.system.channel import hand_over
from live.clock.time_source import Clock
from live.control.audience.admission import BEHIND_NAT, OWN_WIFI
from live.control.audience.phone_registry import invitation_key
from live.control.audience.session_state import BeatClock, Rules
from live.control.audience.stage_lights import STAGE_EVERY, ElementLight, StageLights, colour_texts
from live.control.events.events import AudienceHeard, ControlEvent
from live.control.helper_process import HelperProcess
from live.show.patch.section_io import AudienceSection
from live.show.show import Show
from live.show.venue.venue import Venue
from live.show.venue.venue_audience import VenueAudience

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions

BEAT_INTERVAL: Final = 1.0
"""Longest interval [s] between beats sent to the gateway; a beat that slips is sent at once."""
BACKLOG: Final = 1024
"""Queue of connections that the gateway has not accepted yet."""
NUMBERS_PER_SECOND: Final = 500
"""A new gateway numbers phones from this factor times the show's time [s]. That is above all numbers that an earlier
gateway, of this engine or the one it resumes, can have given (`ALL_JOINS`)."""


class AudienceService:
    """Connects the show to the gateway process for phones. Thread: the show's."""

    def __init__(
        self,
        options: "LaunchOptions",
        show: Show,
        lane: PriorityQueue[ControlEvent],
        clock: Clock,
        venue: Venue | None = None,
    ) -> None:
        assert options.audience is not None
        self._options, self._venue = options, VenueAudience() if venue is None else venue.audience
        self._identity: TlsIdentity | None = None
        self._expires = math.inf
        self._crowd_reported = False
        self._bind_address, self._given_link, self._secret = (
            options.audience,
            options.audience_link,
            options.audience_secret,
        )
        self._port = self._bind_address[1]
        self._show, self._lane, self._clock = show, lane, clock
        self._socket: socket.socket | None = None
        self._helper: HelperProcess | None = None
        self._shards: GatewayShards | None = None
        self._plan: dict[str, Any] = {}
        self._rules: Rules | None = None
        self._beat: BeatClock | None = None
        self._beat_at = 0.0
        self._refused: Counter[str] = Counter()
        self._refused_before: Counter[str] = Counter()
        self.resumes = False
        """Whether the show is resumed after an engine whose gateway may still hold the port."""
        self.link = ""
        """The present link with its key; empty until the gateway reports it."""
        self.code: list[str] = []
        """The link's QR code, rows of 0 and 1."""
        self._stage, self._stage_due = StageLights(), 0.0
        self._invitation = 0
        """The invitation that was printed."""
        self.events_received = 0
        """Number of events received from the gateway."""

    # -- start and stop ------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Listen and start the gateway; raise PersonError if that fails."""
        if importlib.util.find_spec("aiohttp") is None:
            raise PersonError("--audience needs the package aiohttp", "make play installs it")
        try:
            self._load_identity()
        except PersonError as error:
            if not self.resumes:
                raise
            self._print_note(f"audience: {error}: the show runs without its audience", "bold red")
            return
        section, venue = self._show.patch.audience, self._venue
        if self._options.gateways != 1 or self._options.gateways_listen is not None:
            self._shards = GatewayShards(self._options, section.phones, self._clock, resumes=self.resumes)
            self._port, self._socket = self._shards.port, self._shards.reducer_socket
        else:
            try:
                self._socket = listening_socket(self._bind_address, BACKLOG, resumes=self.resumes)
            except (OSError, OverflowError) as error:
                where = f"{self._bind_address[0]}:{self._bind_address[1]}"
                raise PersonError(f"--audience {where}: {error}", "choose another port") from None
            self._port = int(self._socket.getsockname()[1])
        http, inherit = hand_over(self._socket)
        self._plan = {
            "http": http, "secret": self._secret, "first": self._first_number(), "link": self.address,
            "most": section.phones, "per_address": section.phones_per_address, "visible": section.visible,
            "network": self.network, "proxies": list(venue.proxies), "by_card": venue.by_card, "code_s": venue.code_s,
            "grace_s": venue.grace_s, "joins_per_code": venue.joins_per_code, "bans": [],
            "certificate": None if self._identity is None else (self._identity.certificate, self._identity.key),
        }  # fmt: skip
        if self._shards is not None:
            self._plan |= self._shards.keys
        self._helper = HelperProcess(
            "live.control.audience.gateway" if self._shards is None else "live.control.shards.reducer",
            self._clock,
            self._plan,
            self._on_gateway_start,
            *inherit,
            on_packet=self._on_packet,
        )
        self._helper.start()
        if self._shards is not None:
            self._shards.start(self._plan["certificate"])
            if self._options.gateways_listen is not None:
                self._print_note("audience: gateways of paired machines join at {}:{} (live gateway)".format(
                    *self._options.gateways_listen), "")  # fmt: skip
        if self.is_public:
            self._print_note(
                f"audience: open to the network at {self.address}; Q shows the code to join by", "bold red"
            )
        self._invitation = self._show.audience.invitation
        if not self.resumes:
            self._print_invitation()

    @property
    def invitation_link(self) -> str:
        """The operator's invitation, a link that works as long as the show runs; empty before the start."""
        if self._helper is None:
            return ""
        return f"{self.address}/#{invitation_key(self._secret, self._show.audience.invitation)}"

    def _print_invitation(self) -> None:
        if self.is_public:
            self._print_note(f"audience: for you and your team, as long as this show runs: {self.invitation_link}", "")
        else:
            self._print_note(f"note: audience: {self.invitation_link}, on this machine only", "yellow")

    def _load_identity(self) -> None:
        """Read the certificate, if there is one, and print its warnings; raise PersonError if it is invalid."""
        files = tls_files(self._options, self._venue)
        if files is None:
            return
        self._identity = identity = read_identity(*files)
        now = datetime.now(UTC)
        for words in identity.warnings(now, self._host):
            self._print_note(f"audience: {words}", "bold red")
        if now < identity.valid_until:
            self._expires = self._clock.now() + (identity.valid_until - now).total_seconds()

    @property
    def network(self) -> str:
        """The kind of the hall's network, as in the venue, or as guessed."""
        return self._venue.network or network_of(self._show.patch.audience, public=self.is_public)

    @staticmethod
    def _print_note(words: str, style: str) -> None:
        Console(stderr=True, highlight=False, soft_wrap=True).print(words, style=style, markup=False)

    @property
    def port(self) -> int:
        """The port it listens at."""
        return self._port

    @property
    def is_public(self) -> bool:
        """Whether other machines can reach it."""
        return not (self._bind_address[0].startswith("127.") or self._bind_address[0] in ("localhost", "::1"))

    @property
    def address(self) -> str:
        """The address that phones open, without the key."""
        if self._given_link:
            return self._given_link.rstrip("/")
        host = self._host
        scheme = "http" if self._identity is None else "https"
        return f"{scheme}://{f'[{host}]' if ':' in host else host}:{self.port}"

    @property
    def _host(self) -> str:
        """The host name in the phones' address."""
        if self._given_link:
            return urlsplit(self._given_link).hostname or ""
        host = own_address() if self._bind_address[0] in ("0.0.0.0", "::", "") else self._bind_address[0]
        if self._identity is None or host in self._identity.names:
            return host
        return self._identity.host or host

    @property
    def pid(self) -> int | None:
        """The process id of the gateway, or of the reducer of several; None while it does not run."""
        return None if self._helper is None else self._helper.pid

    @property
    def gateway_pids(self) -> list[int | None]:
        """The process ids of the gateways on this machine, where there are several."""
        return [] if self._shards is None else self._shards.pids

    @property
    def has_reducer(self) -> bool:
        """Whether there may be several gateways."""
        return self._shards is not None

    @property
    def phones(self) -> int:
        """Number of phones."""
        return self._show.audience.phones

    def machine_name(self, fingerprint: str) -> str:
        """Return the name of a gateway's machine; empty for this one. `fingerprint`: the begin of its certificate's."""
        return fingerprint if self._shards is None else self._shards.machine_name(fingerprint)

    def send_order(self, packet: tuple[Any, ...]) -> None:
        """Send an order to the gateway, or the reducer."""
        if self._helper is not None:
            self._helper.send(packet)

    def restart_process(self) -> None:
        """Let the gateway's process, or the reducer's, start again."""
        if self._helper is not None:
            self._helper.restart()

    def stop(self) -> None:
        """Stop the gateway and close the port."""
        if self._helper is not None:
            self._helper.stop()
        if self._shards is not None:
            self._shards.stop()
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _on_gateway_start(self) -> None:
        """Handle a restart of the gateway: everything is sent again, and phones get new numbers."""
        self._rules = self._beat = None
        self._refused_before += self._refused
        self._refused = Counter()

    def _first_number(self) -> int:
        now = self._clock.now()
        first = 1 if now < 1.0 else 1 + round(NUMBERS_PER_SECOND * (now + 1.0))
        if self._shards is None or self._helper is None:
            return first
        return max(first, int(self._helper.status().get("next", 0)) + self._shards.spare_numbers)

    # -- each frame ----------------------------------------------------------------------------------------------

    def before_frame(self) -> None:
        """Receive the phones' input, so that it acts in this frame."""
        if self._helper is not None:
            self._helper.frame()
        if self._shards is not None:
            self._shards.frame()

    def _on_packet(self, packet: tuple[Any, ...]) -> None:
        if packet[0] == "code":
            _, self.link, self.code = packet
            return
        _, at, phones, order, share, places, lights, votes, shaken = packet
        self.events_received += 1
        self._lane.put(
            AudienceHeard(time=at, source="audience", phones=phones, order=order, share=share, places=places,
                          lights=lights, votes=votes, shaken=shaken)
        )  # fmt: skip

    def frame(self) -> None:
        """Send changed rules and the beat to the gateway, after each frame."""
        if self._helper is None:
            return
        facts = self._helper.status()
        peers = None if self._shards is None else self._shards.changed_peers()
        if peers is not None and self._helper.send(("peers", peers)):
            self._plan["peers"] = peers
        self._plan["first"] = self._first_number()
        self._plan["bans"] = facts.get("bans", self._plan["bans"])
        self._print_problems(facts)
        self._refused = Counter(facts.get("refused", {}))
        rules = rules_of(self._show)
        if rules != self._rules and self._helper.send(rules):
            self._rules = rules
        if self._invitation != self._show.audience.invitation:
            self._invitation = self._show.audience.invitation
            self._print_invitation()
        beat, now = beat_of(self._show), self._clock.now()
        if now >= self._stage_due and self._show.audience.phones and self._show.audience.open:
            self._stage_due = now + STAGE_EVERY
            self._helper.send(stage_packet(self._show, self._stage))  # one that finds no room is left out
        slipped = self._beat is None or self._beat.differs(beat, now)
        if (slipped or now - self._beat_at > BEAT_INTERVAL) and self._helper.send(beat):
            self._beat, self._beat_at = beat, now

    def _print_problems(self, facts: dict[str, Any]) -> None:
        """Print a note, once each, for problems that the operator can solve."""
        if self._clock.now() >= self._expires:
            self._expires = math.inf
            self._print_note(
                "audience: the certificate has expired: joined phones still work; phones that join show a warning",
                "bold red",
            )
        if facts.get("crowded") and not self._crowd_reported:
            self._crowd_reported = True
            self._print_note(
                "audience: many phones share one address or network card, and their input is ignored. If all phones "
                'share an address here, set [audience] network = "behind nat" in the venue; by_card = false if a '
                "repeater hides their cards", "yellow",
            )  # fmt: skip

    # -- status --------------------------------------------------------------------------------------------------

    def refused(self) -> Counter[str]:
        """Return the number of refused inputs by reason."""
        return self._refused_before + self._refused

    def facts(self) -> dict[str, Any]:
        """Return what the gateway, or the reducer of several, tells of itself; empty before that."""
        return {} if self._helper is None else self._helper.status()

    def status(self) -> dict[str, Any]:
        """Return the values for the status line, without personal data or keys."""
        facts = self.facts()
        told = (
            "messages",
            "late_ms",
            "ways_ms",
            "left_out",
            "missed_frames",
            "restarts",
            "voices",
            "crowded",
            "held",
            "gateways",
        )
        kept = {name: facts.get(name) for name in told}
        until = None if self._identity is None else f"{self._identity.valid_until:%Y-%m-%dT%H:%M:%SZ}"
        return {"at": self.address, "public": self.is_public, "network": self.network, "certificate_until": until,
                **kept, **self._show.audience.facts()}  # fmt: skip


def rules_of(show: Show) -> Rules:
    """Return the rules of the show that the gateway applies."""
    audience, span = show.audience, show.span
    size = show.timeline.beats_per_measure

    def line(measure: int) -> float:
        """Return the beat at which a measure begins."""
        return round(span.end + (measure - span.number - 1) * size, 3)

    turn, vote = audience.turn, audience.vote
    return Rules(
        order=audience.command_count,
        open=audience.open,
        muted=audience.muted,
        shake=audience.shaking,
        half=(float(show.motion.stage_area.border[0]), float(show.motion.stage_area.border[1])),
        regions=audience.regions,
        weights=tuple(audience.region_weights(span.number)),
        banned=tuple(audience.banned),
        turn=None if turn is None else (turn.region, line(turn.begins), line(turn.ends)),
        vote=None if vote is None else (vote.number, vote.kind, vote.choices, line(vote.closes)),
        won=audience.result,
        invitation=audience.invitation,
    )


def stage_packet(show: Show, lights: StageLights) -> tuple[str, bytes, tuple[str, ...]]:
    """Return the packet with the dancers, the elements, and the colours of the groups, for phones."""
    motion, elements = show.motion, show.motion.elements
    shown = (
        ElementLight(one.kind, one.flow_kind, one.points, one.radius, level)
        for one, level in zip(elements.in_force, elements.levels.tolist(), strict=True)
    )
    half = (float(motion.stage_area.border[0]), float(motion.stage_area.border[1]))
    frame = lights.frame(show.dancers.drawn_hips, motion.group_states(), shown, half)
    colours = show.desk.parameters.picture[COLOURS_START:STYLES_START].reshape(-1, 3)
    return "stage", frame, colour_texts(colours[: len(show.patch.group)])


def beat_of(show: Show) -> BeatClock:
    """Return the show's present beat and tempo."""
    timeline = show.timeline
    line = round(show.span.end % timeline.beats_per_measure, 3)
    return BeatClock(timeline.time_origin, timeline.beat_origin, timeline.tempo, timeline.beats_per_measure, line)


def network_of(section: AudienceSection, *, public: bool) -> str:
    """Guess the kind of network if the venue does not state it.

    It is "behind nat" if the patch allows all phones from one address, or if only this machine can reach the server,
    as in a test. Otherwise each phone has its own address.
    """
    return BEHIND_NAT if section.phones_per_address >= section.phones or not public else OWN_WIFI


def tls_files(options: "LaunchOptions", venue: VenueAudience) -> tuple[Path, Path] | None:
    """Return certificate and key from the command line or the venue (relative to its file); None for http."""
    return venue_tls_files(venue, options.venue) if options.audience_tls is None else options.audience_tls


def make_audience(
    options: "LaunchOptions", show: Show, venue: Venue | None, lane: PriorityQueue[ControlEvent], clock: Clock
) -> AudienceService | None:
    """Return the service for `--audience`, not started; None if there is to be none."""
    if options.audience is None and (options.gateways != 1 or options.gateways_listen is not None):
        raise PersonError("--gateways and --gateways-listen need --audience", "--audience 0.0.0.0:8020")
    return None if options.audience is None else AudienceService(options, show, lane, clock, venue)
