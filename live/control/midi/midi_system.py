"""What a MIDI system of this machine (ALSA, JACK, Core MIDI, Windows) has to offer; each has a file of its own."""

from typing import Final, Protocol

from live.control.midi.midi_streams import Direction, Port

CLIENT_NAME: Final = "ChoreoGraphics"
"""Name of our end of a connection in the system's patch bays."""


class MidiUnavailable(RuntimeError):
    """A MIDI system, or every one, is missing or does not run; the message says why."""


class MidiSystem(Protocol):
    """One MIDI system. Thread: any."""

    name: str

    def port_names(self, direction: Direction) -> list[str]:
        """Return the ports of other programs and devices that can be opened; MidiUnavailable if it does not run."""
        ...

    def open_port(self, direction: Direction, name: str) -> Port:
        """Connect to the port of exactly this name; MidiUnavailable or OSError if that fails."""
        ...


def foreign(names: list[str]) -> list[str]:
    """Return the names without those of our own ports."""
    return [name for name in names if not name.startswith(CLIENT_NAME)]
