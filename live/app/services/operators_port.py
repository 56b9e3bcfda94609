"""The part of a live show that listens for its operators by OSC, in this process or in one of its own."""

from collections import Counter
from functools import partial
from typing import Any

from live.app.wish import Wish
from live.base.errors import PersonError
from live.base.inbox import Inbox
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.osc.osc_process import OscRemote
from live.control.osc.osc_server import CannotListen, OscInput
from live.control.registry.control import RANKS
from live.control.registry.values import Changes
from live.supervisor.lifeline import Lifeline


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
