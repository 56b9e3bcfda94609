"""Mapping from show values and events to DMX channels.

Flashes (beat, measure, steps, feet) start at full value and fade linearly. Registry values are scaled to their full
range. The light level is 0 during blackout, so the hall's lights go dark too.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.timeline import Timeline
from live.control.registry.registry import REGISTRY, Changes

CHANNELS: Final = 512
SENDS: Final = ("beat", "measure", "steps", "feet", "tempo", "dancer")
LEVEL: Final = "/dance/light/level"
BLACKOUT: Final = "/dance/blackout"


def channel_count(sends: str) -> int:
    """Return the number of channels of this source when it is not 16-bit; 0 if there is no such source."""
    if sends in SENDS:
        return 4 if sends == "dancer" else 1
    control = REGISTRY.find(sends)
    if (
        control is None
        or control.named
        or any(argument.type in ("name", "text") for argument in control.value_arguments)
    ):
        return 0
    return control.value


@dataclass(frozen=True, slots=True)
class Channel:
    """One row of the channel map, starting at `channel` (from 1). `beats`: how long a flash fades; `fine`: 16-bit
    values."""

    channel: int
    sends: str
    dancer: int = 1
    beats: float = 1.0
    fine: bool = False


DEFAULT_CHANNELS: Final = (
    Channel(1, "beat"), Channel(2, "measure", beats=2.0), Channel(3, "tempo"), Channel(4, "steps"),
    Channel(5, "feet", beats=0.5), Channel(6, LEVEL), Channel(7, "/dance/light/key"),
    Channel(8, "/dance/light/key/colour"), Channel(11, "/dance/light/rim"), Channel(12, "/dance/light/rim/colour"),
    Channel(15, "/dance/light/ambient"), Channel(16, "/dance/light/side"),
    *(Channel(17 + 4 * n, "dancer", dancer=n + 1) for n in range(16)),
)  # fmt: skip
"""The channel map of a patch without one."""


class DmxMapping:
    """Current values of all channels.

    `half` [m]: half the stage; at its edges a dancer's channels are 0 and full.
    """

    def __init__(self, channels: Sequence[Channel], half: tuple[float, float]) -> None:
        self._half = half
        self.channels = tuple(channels)
        """The channel map, which may be replaced."""
        self._values: dict[str, tuple[float, ...]] = {}
        self._positions: Mapping[int, tuple[float, float]] = {}
        self._flash: dict[str, tuple[float, float]] = {}
        self._row = np.zeros(CHANNELS, np.uint8)

    def update_values(self, changes: Changes) -> None:
        """Store new registry values. Of a value that differs between groups, the first counts."""
        for address, rows in changes.items():
            if rows and not any(isinstance(value, str) for value in rows[0][1]):
                self._values[address] = tuple(float(value) for value in rows[0][1])

    def update_positions(self, rows: npt.NDArray[np.float32]) -> None:
        """Store the positions of all dancers on stage: rows (number from 1, x, z, heading)."""
        self._positions = {int(row[0]): (row[1], row[2]) for row in rows.tolist()}

    def flash(self, what: str, beat: float, strength: float = 1.0) -> None:
        """Start a flash at this beat with this strength (0 to 1)."""
        self._flash[what] = (beat, min(max(strength, 0.0), 1.0))

    def row(self, timeline: Timeline, now: float) -> npt.NDArray[np.uint8]:
        """Return all channels (512,) at `now` [s]; every call returns the same array."""
        beat = timeline.beat_at(now)
        self._row[:] = 0
        for channel in self.channels:
            shares = self._levels(channel, timeline, beat)
            at = channel.channel - 1
            if channel.fine or channel.sends == "dancer":
                for share in shares:
                    number = round(65535 * share)
                    self._row[at], self._row[at + 1] = number >> 8, number & 255
                    at += 2
            else:
                self._row[at : at + len(shares)] = [round(255 * share) for share in shares]
        return self._row

    def _levels(self, channel: Channel, timeline: Timeline, beat: float) -> list[float]:
        """Return the values of one source, 0 to 1."""
        match channel.sends:
            case "beat":
                return [_fade_level(beat % 1.0, channel.beats)]
            case "measure":
                return [_fade_level((beat - timeline.measure_origin) % timeline.beats_per_measure, channel.beats)]
            case "tempo":
                return [min(timeline.tempo / 255.0, 1.0)]
            case "steps" | "feet":
                begun, strength = self._flash.get(channel.sends, (-np.inf, 0.0))
                return [strength * _fade_level(beat - begun, channel.beats)]
            case "dancer":
                x, z = self._positions.get(channel.dancer, (0.0, 0.0))
                places = zip((x, z), self._half, strict=True)
                return [min(max(0.5 + 0.5 * place / half, 0.0), 1.0) for place, half in places]
            case address:
                return self._value_levels(address)

    def _value_levels(self, address: str) -> list[float]:
        control = REGISTRY[address]
        values = self._values.get(address, (0.0,) * control.value)
        light = 0.0 if address == LEVEL and self._values.get(BLACKOUT, (0.0,))[0] else 1.0
        shares = []
        for argument, value in zip(control.arguments, values, strict=False):
            low, high = (0.0, 1.0) if argument.type == "bool" else (argument.minimum, argument.maximum)
            shares.append(light * min(max((value - low) / (high - low), 0.0), 1.0) if high > low else 0.0)
        return shares


def _fade_level(since: float, beats: float) -> float:
    return max(1.0 - since / beats, 0.0) if since >= 0.0 else 0.0
