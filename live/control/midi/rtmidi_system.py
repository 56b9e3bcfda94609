"""MIDI ports of macOS (Core MIDI) and Windows, through python-rtmidi, which is loaded on demand.

It is ready-made up to Python 3.12. On Linux it is not used: see `alsa_system.py` and `jack_system.py`.
"""

from typing import Any

from live.control.midi.midi_streams import Direction, Receive
from live.control.midi.midi_system import CLIENT_NAME, MidiUnavailable, foreign


def _open_client(direction: Direction) -> Any:
    """Return a new client of the system's own MIDI; MidiUnavailable if that fails."""
    try:
        import rtmidi
    except ModuleNotFoundError as error:
        raise MidiUnavailable(f"{error}: on macOS and Windows MIDI needs Python 3.11 or 3.12") from None
    except ImportError as error:
        raise MidiUnavailable(f"rtmidi: {error}") from None
    try:
        return (rtmidi.MidiIn if direction == "input" else rtmidi.MidiOut)(name=CLIENT_NAME)
    except Exception as error:  # rtmidi.SystemError, not the built-in one
        raise MidiUnavailable(f"rtmidi: {' '.join(str(error).split())}") from None


class RtMidiPort:
    """One connection. Create, use and close it in one thread; messages arrive on rtmidi's thread."""

    system_runs = True

    def __init__(self, direction: Direction, name: str) -> None:
        """Connect to the port; MidiUnavailable, or OSError if it is gone or another program's."""
        self.name = name
        self._reads = direction == "input"
        self._client = _open_client(direction)
        try:
            names = self._client.get_ports()
            if name not in names:
                raise OSError("the port is gone")
            self._client.open_port(names.index(name), "in" if self._reads else "out")
        except Exception as error:  # also rtmidi's own
            self.close()
            raise OSError(" ".join(str(error).split())) from None

    def listen(self, receive: Receive) -> None:
        """Pass every message, including clock, active sensing and system exclusive, to `receive` as it arrives."""
        self._client.ignore_types(sysex=False, timing=False, active_sense=False)
        self._client.set_callback(lambda event, _data=None: receive(event[0]))

    def send(self, message: bytes) -> None:
        """Send one message; OSError if the port is closed, else rtmidi's own errors."""
        if self._client is None:
            raise OSError("the MIDI port is closed")
        self._client.send_message(message)

    @property
    def exists(self) -> bool:
        """Whether the other side still exists. A port that has returned under another number must be opened again."""
        return self._client is not None and self.name in self._client.get_ports()

    def close(self) -> None:
        """Close the port; errors of the system are ignored."""
        client, self._client = self._client, None
        if client is None:
            return
        try:
            if self._reads:
                client.cancel_callback()
            client.close_port()
            client.delete()
        except Exception:  # the system is gone
            return


class RtMidiSystem:
    """The MIDI system of macOS or Windows. Thread: any."""

    name = "rtmidi"

    def port_names(self, direction: Direction) -> list[str]:
        """Return the ports of others; MidiUnavailable without python-rtmidi, or if its system fails."""
        client = _open_client(direction)
        try:
            return foreign(client.get_ports())
        except Exception as error:  # rtmidi's own
            raise MidiUnavailable(f"rtmidi: {' '.join(str(error).split())}") from None
        finally:
            client.delete()

    def open_port(self, direction: Direction, name: str) -> RtMidiPort:
        """Connect to a port; MidiUnavailable or OSError if that fails."""
        return RtMidiPort(direction, name)
