"""MIDI time code as the clock source "mtc", made of the messages of a MIDI input."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from live.app.bridges import Bridge

if TYPE_CHECKING:
    from live.clock.midi.midi_clock import MessageClock
    from live.show.patch.patch import Patch


def midi_clocks(patch: "Patch", beats_per_measure: int) -> "Mapping[str, MessageClock]":
    """The source "mtc", as `[midi] time_code_bpm` and `time_code_offset_s` say."""
    from live.bridges.midi_time_code.time_code import TimeCodeClock

    tempo = patch.midi.time_code_bpm or patch.clock.bpm
    offset = patch.midi.time_code_offset_s
    return {"mtc": TimeCodeClock(tempo=tempo, offset=offset, beats_per_measure=beats_per_measure)}


BRIDGE = Bridge(name="midi_time_code", midi_clocks=midi_clocks)
