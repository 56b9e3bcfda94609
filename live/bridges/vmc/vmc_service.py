"""Service for whole bodies of real dancers by VMC."""

from collections import Counter
from typing import Annotated, Any

from pydantic import Field

from live.base.errors import PersonError
from live.base.event_queue import PriorityQueue
from live.bridges.vmc.vmc_input import Seat, VmcInput
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import CannotListen
from live.show.patch.patch import Patch
from live.show.patch.section_base import Section
from live.show.show import Show

Endpoint = Annotated[str, Field(pattern=r"^((\[[0-9A-Fa-f:.]+\]|[^:\s]+):)?\d{1,5}$", max_length=200)]
Endpoints = Annotated[tuple[Endpoint, ...], Field(max_length=8)]


class VenueVmc(Section):
    """`[vmc]`: default ports for motion capture over VMC, if the command line names none."""

    at: Endpoints = ()
    """Ports like `39539`, or with the local address as in `0.0.0.0:39539`."""


class VmcTables(Section):
    """The table of a venue that this bridge reads."""

    vmc: VenueVmc = VenueVmc()


class VmcService:
    """Receives bodies of real dancers by VMC. Thread: the show's."""

    def __init__(
        self, endpoints: tuple[tuple[str, int], ...], show: Show, lane: PriorityQueue[ControlEvent], clock: Clock
    ) -> None:
        self._show = show
        self._input = VmcInput(endpoints, seats_of(show.patch), lane, clock)
        self._endpoints = [f"{host}:{port}" for host, port in endpoints]

    def start(self) -> None:
        """Start to listen; raise PersonError if that fails."""
        try:
            self._input.start()
        except CannotListen as error:
            raise PersonError(str(error).replace("OSC cannot", "VMC cannot")) from None

    def stop(self) -> None:
        """Free the ports."""
        self._input.stop()

    def frame(self) -> None:
        """Do nothing after each frame."""

    def update_patch(self, patch: Patch) -> None:
        """Use the performers of another patch."""
        self._input.set_seats(seats_of(patch))

    def refused(self) -> Counter[str]:
        """Return the number of refused packets by reason."""
        return Counter(self._input.rejected.as_dict())

    def status(self) -> dict[str, Any]:
        """Return the values for the status line: the input, and its state on the stage."""
        stage = self._show.mocap.facts(self._show.time)
        return {"at": self._endpoints, **self._input.status(), "stage": stage}


def seats_of(patch: Patch) -> tuple[Seat, ...]:
    """Return the performers of a patch."""
    return tuple(Seat(each.name, each.port, each.sender, each.floor) for each in patch.mocap)
