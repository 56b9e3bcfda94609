"""Services for OSC: the operators' port, the musicians' port with restricted commands, and the output."""

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any

from live.app.launch_options import LaunchOptions
from live.app.option_values import parse_endpoint
from live.base.errors import PersonError
from live.base.event_queue import EventQueue, PriorityQueue
from live.base.system.features import LINUX
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.helper_process import HelperProcess
from live.control.osc.osc_output import Targets
from live.control.osc.osc_process import OscRemote
from live.control.osc.osc_server import OscInput
from live.control.osc.osc_socket import CannotListen
from live.control.registry.control import ROLE_RANKS
from live.control.registry.registry import Changes
from live.show.engine import Engine
from live.show.show import Show
from live.show.venue.venue import Venue
from live.show.view.telemetry import Telemetry
from live.supervisor.supervisor_link import SupervisorLink

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions


class OperatorOscPort:
    """OSC input for all commands, in this process or in a separate one. Thread: the show's."""

    def __init__(
        self, options: LaunchOptions, inbox: EventQueue[ControlEvent], clock: Clock, lifeline: SupervisorLink | None
    ) -> None:
        """Bind nothing yet; a socket held by the supervisor is inherited."""
        operators = partial(inbox.add_queue, rank=ROLE_RANKS["operator"])
        lane, inherited = operators(), None if lifeline is None else lifeline.osc
        reader = None if lifeline is None else lifeline.osc_reader
        self._osc: OscInput | OscRemote = (
            OscRemote(*options.osc, lane, clock, inherited=inherited, reader=reader)
            if options.osc_process and LINUX  # elsewhere no process inherits the socket
            else OscInput(*options.osc, lane, clock, inherited=inherited, make_lane=operators)
        )

    def start(self) -> None:
        """Bind the port; raise PersonError if that fails."""
        try:
            self._osc.start()
        except CannotListen as error:
            raise PersonError(str(error)) from None

    def stop(self) -> None:
        """Free the port."""
        self._osc.stop()

    def frame(self) -> None:
        """Receive messages from the reader process, before each frame."""
        if isinstance(self._osc, OscRemote):
            self._osc.frame()

    @property
    def port(self) -> int:
        """The port that is bound."""
        return self._osc.port

    def publish(self, changes: Changes) -> None:
        """Pass on changed values."""
        self._osc.publish(changes)

    def rejected(self) -> Counter[str]:
        """Return the number of refused messages by reason, with those lost before they were read."""
        return rejected_counts(self._osc)

    def refusal(self) -> str:
        """Return the last refusal in words."""
        return self._osc.refusal()

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return self._osc.status()


def rejected_counts(osc: OscInput | OscRemote) -> Counter[str]:
    """Return the number of refused messages by reason, with those lost before they were read."""
    counts = Counter(osc.refused())
    if osc.lost:
        counts["lost before it was read"] = osc.lost
    return counts


class MusicianOscPort:
    """Second OSC input, for commands that musicians may use. Thread: the show's."""

    def __init__(self, host: str, port: int, lane: PriorityQueue[ControlEvent], clock: Clock) -> None:
        self._osc = OscInput(host, port, lane, clock, role="musician", option="--osc-musicians")

    def start(self) -> None:
        """Bind the port; raise PersonError if that fails."""
        try:
            self._osc.start()
        except CannotListen as error:
            raise PersonError(str(error)) from None

    def stop(self) -> None:
        """Free the port."""
        self._osc.stop()

    def frame(self) -> None:
        """Do nothing after each frame."""

    def publish(self, changes: Changes) -> None:
        """Pass on changed values."""
        self._osc.publish(changes)

    def refused(self) -> Counter[str]:
        """Return the number of refused messages by reason."""
        return Counter(self._osc.refused())

    def refusal(self) -> str:
        """Return the last refusal in words."""
        told = self._osc.refusal()
        return f"musicians: {told}" if told else ""

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return self._osc.status()


class OscOutputService:
    """Feeds the process that sends OSC. Thread: the show's."""

    def __init__(self, engine: Engine, outgoing: Telemetry, targets: tuple[tuple[str, int], ...], clock: Clock) -> None:
        self._engine, self._outgoing, self._targets = engine, outgoing, targets
        self._helper = HelperProcess("live.control.osc.osc_output", clock, {"targets": targets}, outgoing.reset)

    def start(self) -> None:
        """Start to send; raise PersonError for an unknown host."""
        try:
            Targets(self._targets).close()
        except OSError as error:
            shown = ", ".join(f"{host}:{port}" for host, port in self._targets)
            raise PersonError(f"--osc-out {shown}: {error.strerror or error}", "use IP addresses") from None
        self._helper.start()

    def stop(self) -> None:
        """Stop sending."""
        self._helper.stop()

    def frame(self) -> None:
        """Send the show's output, after each frame."""
        self._helper.frame()
        for told in self._outgoing.frame(self._engine.view):
            self._helper.send(told)

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        to = [f"{host}:{port}" for host, port in self._targets]
        return {"to": to, **self._helper.status(), "too_many": self._outgoing.dropped}


def make_osc_out(
    options: "LaunchOptions", show: Show, venue: Venue | None, clock: Clock, engine: Engine
) -> OscOutputService | None:
    """Return the service for `--osc-out`, the venue or the patch, not started; None if there is to be none."""
    section = show.patch.osc
    named = section.out if venue is None or not venue.osc.out else venue.osc.out
    targets = options.osc_out or tuple(parse_endpoint(each, "[osc] out") for each in named)
    if not targets:
        return None
    outgoing = Telemetry(show, positions=section.positions_per_second, feet=section.feet)
    return OscOutputService(engine, outgoing, targets, clock)
