"""The part of a live show that listens for musicians at an OSC port of their own, where only what they may is taken."""

from collections import Counter
from typing import Any

from live.base.errors import PersonError
from live.base.lane import Lane
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.osc.osc_server import CannotListen, OscInput
from live.control.registry.values import Changes


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
