"""The part of a live show that listens for its operators by OSC, in this process or in one of its own.

The part of a live show that listens for musicians at an OSC port of their own, where only what they may is taken.

The part of a live show that tells musicians and other programs over OSC what happens in it.
"""

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any

from live.app.launch_options import Wish
from live.app.option_values import parse_endpoint
from live.base.errors import PersonError
from live.base.event_queue import Inbox, Lane
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.helper_process import Helper
from live.control.osc.osc_output import Targets
from live.control.osc.osc_process import OscRemote
from live.control.osc.osc_server import CannotListen, OscInput
from live.control.registry.control import RANKS
from live.control.registry.registry import Changes
from live.show.engine import Engine
from live.show.show import Show
from live.show.telemetry import Outgoing
from live.show.venue.venue import Venue
from live.supervisor.supervisor_link import Lifeline

if TYPE_CHECKING:
    from live.app.launch_options import Wish


class OperatorsPort:
    """The OSC input that everything is taken at. Thread: the one that runs the show."""

    def __init__(self, wish: Wish, inbox: Inbox[ControlEvent], clock: Clock, lifeline: Lifeline | None) -> None:
        """Nothing is bound yet; a socket that a supervisor holds is taken over."""
        operators = partial(inbox.lane, rank=RANKS["operator"])
        lane, inherited = operators(), None if lifeline is None else lifeline.osc
        reader = None if lifeline is None else lifeline.osc_reader
        self._osc: OscInput | OscRemote = (
            OscRemote(*wish.osc, lane, clock, inherited=inherited, reader=reader)
            if wish.osc_process
            else OscInput(*wish.osc, lane, clock, inherited=inherited, more=operators)
        )

    def start(self) -> None:
        """Bind; PersonError if that cannot be."""
        try:
            self._osc.start()
        except CannotListen as error:
            raise PersonError(str(error)) from None

    def stop(self) -> None:
        """Free the port."""
        self._osc.stop()

    def frame(self) -> None:
        """Before each frame: what the other process heard since the last one."""
        if isinstance(self._osc, OscRemote):
            self._osc.frame()

    @property
    def port(self) -> int:
        """The port it really receives on."""
        return self._osc.port

    def tell(self, changes: Changes) -> None:
        """These have new values in the show."""
        self._osc.tell(changes)

    def rejected(self) -> Counter[str]:
        """How much was refused, by reason, and what was lost before anybody read it."""
        return osc_rejected(self._osc)

    def refusal(self) -> str:
        """The last refusal in words."""
        return self._osc.refusal()

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        return self._osc.facts()


def osc_rejected(osc: OscInput | OscRemote) -> Counter[str]:
    """How much was refused, by reason, and what was lost before anybody read it."""
    counts = Counter(osc.refused())
    if osc.lost:
        counts["lost before it was read"] = osc.lost
    return counts


class MusiciansPort:
    """A second OSC input. Thread: the one that runs the show."""

    def __init__(self, host: str, port: int, lane: Lane[ControlEvent], clock: Clock) -> None:
        self._osc = OscInput(host, port, lane, clock, role="musician", option="--osc-musicians")

    def start(self) -> None:
        """Bind; PersonError if that cannot be."""
        try:
            self._osc.start()
        except CannotListen as error:
            raise PersonError(str(error)) from None

    def stop(self) -> None:
        """Free the port."""
        self._osc.stop()

    def frame(self) -> None:
        """After each frame; nothing is to be done."""

    def tell(self, changes: Changes) -> None:
        """These have new values in the show."""
        self._osc.tell(changes)

    def refused(self) -> Counter[str]:
        """What was refused, by reason."""
        return Counter(self._osc.refused())

    def refusal(self) -> str:
        """The last refusal in words."""
        told = self._osc.refusal()
        return f"musicians: {told}" if told else ""

    def status(self) -> dict[str, Any]:
        """For the status line."""
        return self._osc.facts()


class OscOutPart:
    """Between the show and the process that sends. Thread: the one that runs the show."""

    def __init__(self, engine: Engine, outgoing: Outgoing, targets: tuple[tuple[str, int], ...], clock: Clock) -> None:
        self._engine, self._outgoing, self._targets = engine, outgoing, targets
        self._helper = Helper("live.control.osc.osc_output", clock, {"targets": targets}, outgoing.anew)

    def start(self) -> None:
        """Begin to send; PersonError for a host that nobody knows."""
        try:
            Targets(self._targets).close()
        except OSError as error:
            shown = ", ".join(f"{host}:{port}" for host, port in self._targets)
            raise PersonError(f"--osc-out {shown}: {error.strerror or error}", "name hosts by their numbers") from None
        self._helper.start()

    def stop(self) -> None:
        """Send nothing any more."""
        self._helper.stop()

    def frame(self) -> None:
        """After each frame: what there is to tell."""
        self._helper.frame()
        for told in self._outgoing.frame(self._engine.view):
            self._helper.send(told)

    def status(self) -> dict[str, Any]:
        """For the status line."""
        to = [f"{host}:{port}" for host, port in self._targets]
        return {"to": to, **self._helper.facts(), "too_many": self._outgoing.left_out}


def make_osc_out(wish: "Wish", show: Show, venue: Venue | None, clock: Clock, engine: Engine) -> OscOutPart | None:
    """What `--osc-out`, the venue or the patch asks for, to be started; None if nobody is to be told."""
    section = show.patch.osc
    named = section.out if venue is None or not venue.osc.out else venue.osc.out
    targets = wish.osc_out or tuple(parse_endpoint(each, "[osc] out") for each in named)
    if not targets:
        return None
    outgoing = Outgoing(show, positions=section.positions_per_second, feet=section.feet)
    return OscOutPart(engine, outgoing, targets, clock)
