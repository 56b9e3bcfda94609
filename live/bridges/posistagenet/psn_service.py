"""Service for tracker positions by PosiStageNet."""

import ipaddress
import re
from collections import Counter
from typing import Annotated, Any

from pydantic import Field

from live.app.option_values import add_default_port, parse_endpoint
from live.base.errors import PersonError
from live.base.event_queue import PriorityQueue
from live.bridges.posistagenet.posistagenet import GROUP, PORT, PsnInput
from live.clock.time_source import Clock
from live.control.events.events import ControlEvent
from live.control.osc.osc_socket import CannotListen
from live.show.patch.section_base import Section


class VenuePsn(Section):
    """`[psn]`: default address for PosiStageNet trackers, if the command line names none."""

    at: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    """Such as `236.10.10.10:56565`, or with the network card's address, `236.10.10.10:56565@192.168.1.5`."""


class PsnTables(Section):
    """The table of a venue that this bridge reads."""

    psn: VenuePsn = VenuePsn()


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
