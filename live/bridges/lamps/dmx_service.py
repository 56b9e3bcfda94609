"""Service for DMX output of the show by sACN or Art-Net."""

import re
import socket
from dataclasses import astuple
from typing import Any, Final, Literal

from live.base.errors import PersonError
from live.bridges.lamps.dmx_mapping import DEFAULT_CHANNELS
from live.bridges.lamps.dmx_output import ARTNET_PORT, RATE, SACN_PORT, Universe
from live.bridges.lamps.dmx_section import DmxTables
from live.clock.time_source import Clock
from live.control.helper_process import HelperProcess
from live.control.registry.registry import Changes
from live.show.engine import Engine
from live.show.patch.patch import Patch
from live.show.view.telemetry import Telemetry

VALUES_PER_PACKET: Final = 64
"""Maximum number of values in one packet."""


def parse_universe(text: str) -> Universe:
    """Parse sacn:UNIVERSE[@HOST[:PORT]] or artnet:UNIVERSE@HOST[:PORT]; raise PersonError for anything else."""
    match = re.fullmatch(r"\s*(sacn|artnet):(\d{1,5})(?:@([^:@\s]+)(?::(\d{1,5}))?)?\s*", text)
    if match is None or (match[1] == "artnet" and not match[3]) or int(match[4] or 0) > 65535:
        raise PersonError(
            f"--dmx {text!r}: sacn:UNIVERSE, sacn:UNIVERSE@HOST or artnet:UNIVERSE@HOST expected", "--dmx sacn:1"
        )
    protocol: Literal["sacn", "artnet"] = "sacn" if match[1] == "sacn" else "artnet"
    number, (low, high) = int(match[2]), (1, 63999) if protocol == "sacn" else (0, 32767)
    if not low <= number <= high:
        raise PersonError(f"--dmx {text!r}: universes of {protocol} are {low} to {high}", f"--dmx {protocol}:{low}")
    port = int(match[4] or (SACN_PORT if protocol == "sacn" else ARTNET_PORT))
    return Universe(protocol, number, match[3] or "", port)


class DmxService:
    """Feeds the process that sends DMX. Thread: the show's."""

    def __init__(self, engine: Engine, universes: tuple[Universe, ...], clock: Clock) -> None:
        show = engine.show
        self._engine, self._universes = engine, universes
        self._outgoing = Telemetry(show, positions=RATE)
        self._values: dict[str, Any] = {}
        width, depth = show.patch.stage.width, show.patch.stage.depth
        self._plan: dict[str, Any] = {
            "universes": [astuple(each) for each in universes],
            "half": (0.5 * width, 0.5 * depth),
        }
        self.update_patch(show.patch)
        self._helper = HelperProcess("live.bridges.lamps.dmx_output", clock, self._plan, self._on_start)

    def start(self) -> None:
        """Start to send; raise PersonError for an unknown host."""
        for each in self._universes:
            try:
                socket.gethostbyname(each.host or "127.0.0.1")
            except OSError as error:
                where = f"{each.protocol}:{each.number}@{each.host}"
                raise PersonError(f"--dmx {where}: {error.strerror or error}", "use IP addresses") from None
        self._helper.start()

    def stop(self) -> None:
        """Stop sending."""
        self._helper.stop()

    def update_patch(self, patch: Patch) -> None:
        """Use the channels of another patch."""
        rows = patch.read_tables(DmxTables).dmx
        channels = [row.dmx_channel for row in rows] or list(DEFAULT_CHANNELS)
        self._addresses = {channel.sends for channel in channels} | {"/dance/blackout"}
        self._plan["channels"] = [astuple(each) for each in channels]
        self._channels_sent = False
        self._unsent = self._used_values(self._values)

    def publish(self, changes: Changes) -> None:
        """Queue the changed values that a channel uses."""
        self._values.update(changes)
        self._unsent.update(self._used_values(changes))

    def _used_values(self, values: Changes) -> dict[str, Any]:
        return {address: rows for address, rows in values.items() if address in self._addresses}

    def _on_start(self) -> None:
        self._outgoing.reset()
        self._channels_sent = True  # they are in the plan
        self._unsent = self._used_values(self._values)

    def frame(self) -> None:
        """Send changed values and positions, after each frame."""
        self._helper.frame()
        for told in self._outgoing.frame(self._engine.view):
            self._helper.send(told)
        if not self._channels_sent:
            self._channels_sent = self._helper.send(("channels", self._plan["channels"]))
        if self._unsent:
            some = {address: self._unsent[address] for address in list(self._unsent)[:VALUES_PER_PACKET]}
            if self._helper.send(("values", some)):
                for address in some:
                    del self._unsent[address]

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        to = [f"{each.protocol}:{each.number}@{each.host or 'all'}" for each in self._universes]
        return {"to": to, **self._helper.status(), "too_many": self._outgoing.dropped}
