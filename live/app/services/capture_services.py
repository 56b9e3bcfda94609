"""Services for motion capture over the network: tracker positions by PosiStageNet, whole bodies by VMC."""

import ipaddress
import re
from collections import Counter
from typing import TYPE_CHECKING, Any

from live.app.option_values import add_default_port, parse_endpoint
from live.base.errors import PersonError
from live.base.event_queue import PriorityQueue
from live.clock.time_source import Clock
from live.control.capture.posistagenet import GROUP, PORT, PsnInput
from live.control.capture.vmc_input import Seat, VmcInput
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import CannotListen
from live.show.patch.patch import Patch
from live.show.show import Show
from live.show.venue.venue import Venue

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions


def parse_psn(text: str, name: str = "--psn") -> tuple[str, int, str]:
    """Parse [GROUP:]PORT or GROUP, with an optional @ADDRESS of a network card; raise PersonError for anything else."""
    match = re.fullmatch(r"\s*([^@\s]+)(?:@(\d{1,3}(?:\.\d{1,3}){3}))?\s*", text)
    if match is None:
        raise PersonError(f"{name} {text!r}: GROUP:PORT or GROUP:PORT@ADDRESS expected", f"{name} {GROUP}:{PORT}")
    try:
        card = str(ipaddress.IPv4Address(match[2])) if match[2] else ""
    except ValueError:
        raise PersonError(f"{name} {text!r}: {match[2]} is not an IPv4 address", f"{name} {GROUP}:{PORT}") from None
    return *parse_endpoint(add_default_port(match[1], PORT), name), card


class PsnService:
    """Receives tracker positions by PosiStageNet. Thread: the show's."""

    def __init__(self, host: str, port: int, card: str, lane: PriorityQueue[ControlEvent], clock: Clock) -> None:
        self._input = PsnInput(host, port, card, lane, clock)
        self._endpoint = f"{host}:{port}" + (f"@{card}" if card else "")

    def start(self) -> None:
        """Start to listen; raise PersonError if that fails."""
        try:
            self._input.start()
        except CannotListen as error:
            raise PersonError(str(error).replace("OSC cannot", "PosiStageNet cannot")) from None

    def stop(self) -> None:
        """Free the port."""
        self._input.stop()

    def frame(self) -> None:
        """Do nothing after each frame."""

    def refused(self) -> Counter[str]:
        """Return the number of refused packets by reason."""
        return Counter(self._input.rejected.as_dict())

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        return {"at": self._endpoint, **self._input.status()}


def make_psn(
    options: "LaunchOptions", venue: Venue | None, lane: PriorityQueue[ControlEvent], clock: Clock
) -> PsnService | None:
    """Return the service for `--psn` or the venue's trackers, not started; None if there is to be none."""
    named = None if venue is None or venue.psn.at is None else parse_psn(venue.psn.at, "[psn] at")
    wanted = named if options.psn is None else parse_psn(options.psn)
    return None if wanted is None else PsnService(*wanted, lane, clock)


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


def make_vmc(
    options: "LaunchOptions", show: Show, venue: Venue | None, lane: PriorityQueue[ControlEvent], clock: Clock
) -> VmcService | None:
    """Return the service for `--vmc` or the venue's ports, not started; None if there is to be none."""
    named = () if venue is None else venue.vmc.at
    endpoints = options.vmc or tuple(parse_endpoint(add_default_port(each, 39539), "[vmc] at") for each in named)
    return VmcService(endpoints, show, lane, clock) if endpoints else None
