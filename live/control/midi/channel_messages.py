"""Decoder for MIDI channel messages: notes, controllers, pitch bend and so on, with their positions.

A controller is reported with its own 7 bits and, below 64, also as a 14-bit pair of controllers n and n + 32 (MIDI
1.0, data entry and controllers 0 to 63); 98, 99, 6 and 38 are also read as non-registered parameters (NRPN).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from live.control.midi.midi_binding import FINE_BELOW, Kind

NOTE_OFF, NOTE_ON, CONTROLLER, PROGRAM, PRESSURE, BEND = 0x8, 0x9, 0xB, 0xC, 0xD, 0xE
MAX_7_BIT: Final = 127
MAX_14_BIT: Final = 16383
MIDDLE: Final = 8192
DATA, DATA_FINE, NRPN_FINE, NRPN, RPN_FINE, RPN = 6, 38, 98, 99, 100, 101
LENGTHS: Final = {NOTE_OFF: 3, NOTE_ON: 3, CONTROLLER: 3, PROGRAM: 2, PRESSURE: 2, BEND: 3}


@dataclass(frozen=True, slots=True)
class MidiAction:
    """One action on a controller: a press, release or movement."""

    kind: Kind
    number: int
    channel: int
    """1 to 16."""
    position: float
    """Position or velocity, 0 to 1."""
    step: float
    """The smallest change of `position`."""
    down: bool
    """Whether it is pressed, or in the upper half."""
    fine: bool = False
    """Whether it is a 14-bit pair of controllers."""


class _Pair:
    """Two controllers that form a number of 14 bits; many devices send only the upper seven, or send them first."""

    def __init__(self) -> None:
        self.high, self.low, self.has_low = 0, 0, False

    def set_high(self, value: int) -> float:
        """Update the upper seven bits; return the position.

        The lower bits become those nearest to the old position until the new ones arrive.
        """
        up, self.high = value >= self.high, value
        if not self.has_low:
            return value / MAX_7_BIT
        self.low = 0 if up or value == 0 else MAX_7_BIT
        return self.position

    def set_low(self, value: int) -> float:
        """Update the lower seven bits; return the position."""
        self.low, self.has_low = value, True
        return self.position

    @property
    def position(self) -> float:
        """The position, 0 to 1."""
        return (self.high * 128 + self.low) / MAX_14_BIT


class ChannelMessageDecoder:
    """Decoder for the messages of one port. Use from one thread at a time."""

    def __init__(self) -> None:
        self._pairs: dict[tuple[int, int], _Pair] = {}
        self._numbers: dict[int, list[int]] = {}  # per channel: upper and lower bits of the NRPN; -1: none
        self._data: dict[int, tuple[int, _Pair]] = {}  # per channel: the current NRPN

    def decode(self, message: Sequence[int]) -> list[MidiAction]:
        """Return the actions in a message; empty for other or malformed messages."""
        if (
            len(message) < 2
            or not 0x80 <= message[0] < 0xF0
            or not 0 <= min(message[1:]) <= max(message[1:]) <= MAX_7_BIT
        ):
            return []
        status, channel, first = message[0] >> 4, (message[0] & 15) + 1, message[1]
        if len(message) != LENGTHS.get(status):
            return []
        if status == CONTROLLER:
            return self._controller(first, message[2], channel)
        if status in (NOTE_ON, NOTE_OFF):
            on = status == NOTE_ON and message[2] > 0
            return [MidiAction("note", first, channel, message[2] / MAX_7_BIT if on else 0.0, 1 / MAX_7_BIT, on)]
        if status == PROGRAM:
            return [MidiAction("program", first, channel, 1.0, 1.0, True)]
        if status == PRESSURE:
            return [_movement("pressure", 0, channel, first / MAX_7_BIT)]
        bend = first + 128 * message[2]
        share = 0.5 * bend / MIDDLE if bend <= MIDDLE else 0.5 + 0.5 * (bend - MIDDLE) / (MAX_14_BIT - MIDDLE)
        return [_movement("bend", 0, channel, share, 1 / MAX_14_BIT)]

    def _controller(self, number: int, value: int, channel: int) -> list[MidiAction]:
        made = [_movement("cc", number, channel, value / MAX_7_BIT)]
        if number < 2 * FINE_BELOW:
            upper = number % FINE_BELOW
            pair = self._pairs.setdefault((channel, upper), _Pair())
            share = pair.set_high(value) if number < FINE_BELOW else pair.set_low(value)
            made.append(
                _movement("cc", upper, channel, share, 1 / (MAX_14_BIT if pair.has_low else MAX_7_BIT), fine=True)
            )
        chosen = self._numbers.setdefault(channel, [-1, -1])
        if number in (NRPN, NRPN_FINE):
            chosen[number == NRPN_FINE] = value
        elif number in (RPN, RPN_FINE):
            chosen[:] = [-1, -1]
        elif number in (DATA, DATA_FINE) and min(chosen) >= 0 and chosen != [MAX_7_BIT, MAX_7_BIT]:
            which = chosen[0] * 128 + chosen[1]
            before, pair = self._data.get(channel, (-1, _Pair()))
            if which != before:
                pair = _Pair()
            self._data[channel] = which, pair
            share = pair.set_high(value) if number == DATA else pair.set_low(value)
            made.append(
                _movement("nrpn", which, channel, share, 1 / (MAX_14_BIT if pair.has_low else MAX_7_BIT), fine=True)
            )
        return made


def _movement(
    kind: Kind, number: int, channel: int, share: float, step: float = 1 / MAX_7_BIT, *, fine: bool = False
) -> MidiAction:
    return MidiAction(kind, number, channel, share, step, share * MAX_7_BIT >= 64 - 1e-9, fine)
