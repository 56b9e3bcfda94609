"""MIDI over the network by RTP-MIDI, as port names `rtp:HOST:PORT`."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from live.app.bridges import Bridge

if TYPE_CHECKING:
    from live.control.midi.midi_streams import Opener


def midi_schemes() -> "Mapping[str, Opener]":
    """`rtp:HOST:PORT`."""
    from live.bridges.rtp_midi.rtp_midi import RtpPort

    return {"rtp": RtpPort}


BRIDGE = Bridge(name="rtp_midi", midi_schemes=midi_schemes)
