"""The MIDI ports of this machine by name, through python-rtmidi, which is loaded only when somebody asks for it.

ALSA, JACK, Core MIDI and Windows are asked in the order in which rtmidi names them; a system that is not running has
no ports. Names stay, numbers change: a port is always looked up by its name.
"""

import ctypes
import glob
import os
import re
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any, Final

from live.control.midi.midi_streams import RTP, Direction, Port, StreamPort, is_stream
from live.control.midi.rtp_port import RtpPort

OURS: Final = "ChoreoGraphics"
"""What our side of a connection is called in the system's patch bays."""


class MidiUnavailable(RuntimeError):
    """python-rtmidi is missing or no MIDI system runs; the message says what to do."""


class UnknownPort(ValueError):
    """No port of that name; the message lists those that there are."""


def rtmidi() -> ModuleType:
    """The rtmidi module; MidiUnavailable if it cannot be loaded."""
    try:
        import rtmidi as module
    except ModuleNotFoundError as error:
        raise MidiUnavailable(f"{error}: python-rtmidi is ready-made for Python 3.11 and 3.12 only") from None
    except ImportError as error:
        raise MidiUnavailable(f"rtmidi: {error}") from None
    return module  # type: ignore[no-any-return]


class OpenPort:
    """One open connection. Thread: made, used and closed by one; what arrives is handed over on rtmidi's own."""

    def __init__(self, direction: Direction, api: int, wanted: str) -> None:
        """Connect to the port that `wanted` names; UnknownPort, OSError (of rtmidi) if that fails."""
        self.direction = direction
        self._client = _client(direction, api)
        self._jack = api == rtmidi().API_UNIX_JACK
        try:
            names: list[str] = self._client.get_ports()
            self.name = match_port(wanted, names)
            self._client.open_port(names.index(self.name), "in" if direction == "input" else "out")
        except BaseException:
            self.close()
            raise

    def listen(self, receive: Callable[[list[int]], None]) -> None:
        """Every message, clock, sensing and exclusive ones too, is handed to `receive` as it arrives."""
        self._client.ignore_types(sysex=False, timing=False, active_sense=False)
        self._client.set_callback(lambda event, _data=None: receive(event[0]))

    def send(self, message: bytes) -> None:
        """Send one message."""
        self._client.send_message(message)

    @property
    def there(self) -> bool:
        """Whether the other side still exists: one that has come back under another number has to be opened anew."""
        return self.name in self._client.get_ports()

    @property
    def system_runs(self) -> bool:
        """Whether the MIDI system itself still answers; JACK's lists what was there, also when its server has died.

        Asking costs some milliseconds: for when nothing comes any more.
        """
        if not self._jack:
            return True
        try:
            _client(self.direction, rtmidi().API_UNIX_JACK).delete()
        except Exception:
            return False
        return True

    def close(self) -> None:
        """Free it; whatever the system says to that."""
        client, self._client = self._client, _Closed()
        if self._jack and not client.get_ports():
            abandon(client)
            return
        try:
            if self.direction == "input":
                client.cancel_callback()
            client.close_port()
            client.delete()
        except Exception:  # a system that has gone cannot say goodbye
            return


def abandon(client: Any) -> None:
    """Leave a client as it is for ever: closing one of a JACK server that has died would end this process.

    That is what no port at all looks like; where the server lives after all, an unconnected client of ours stays.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(client))


class _Closed:
    """In place of a client that was closed."""

    def get_ports(self) -> list[str]:
        return []

    def send_message(self, message: bytes) -> None:
        raise OSError("the MIDI port is closed")

    def cancel_callback(self) -> None: ...

    def close_port(self) -> None: ...

    def delete(self) -> None: ...


def _client(direction: Direction, api: int) -> Any:
    module = rtmidi()
    make = module.MidiIn if direction == "input" else module.MidiOut
    return make(api, name=OURS)


def port_names(direction: Direction) -> dict[int, list[str]]:
    """The ports of each MIDI system that runs, by rtmidi's number of it; MidiUnavailable if none does."""
    found: dict[int, list[str]] = {}
    reasons: list[str] = []
    for api in rtmidi().get_compiled_api():
        if absent := _absent(api):
            reasons.append(absent)
            continue
        try:
            client = _client(direction, api)
        except Exception as error:  # rtmidi.SystemError, which is no built-in SystemError
            reasons.append(f"rtmidi: {' '.join(str(error).split())}")
            continue
        try:
            names = client.get_ports()
        finally:
            client.delete()
        found[api] = [name for name in names if not name.startswith(OURS)]
    if not found:
        raise MidiUnavailable(f"no MIDI system runs here: {', '.join(reasons) or 'rtmidi knows none'}")
    return found


def _absent(api: int) -> str:
    """Why a system cannot run on this Linux; empty where it may. Asking in vain would write on the terminal."""
    if sys.platform != "linux":
        return ""
    module = rtmidi()
    if api == getattr(module, "API_LINUX_ALSA", None) and not os.path.exists("/dev/snd/seq"):
        return "the kernel has no ALSA sequencer"
    if api == getattr(module, "API_UNIX_JACK", None):
        server = glob.escape(os.environ.get("JACK_DEFAULT_SERVER", "default"))
        if not any(glob.glob(f"{folder}/jack_{server}_*_0") for folder in ("/dev/shm", "/tmp")):
            return "no JACK server runs"
    return ""


def lasting_name(name: str) -> str:
    """A port's name without the numbers that change when it is plugged in again.

    Those are ALSA's of client and port (`Pad 24:0`), those of its bridge to JACK (`a2j:Pad [24] (capture): Pad`), and
    what JACK adds to a client's name that is taken (`pad-01:out`).
    """
    return re.sub(r"\s+\d+:\d+$|\s+\[\d+\](?=[\s:]|$)|-\d\d(?=:)", "", name).casefold()


def match_port(wanted: str, names: list[str]) -> str:
    """The port that `wanted` names: an exact name first, then without ALSA's numbers, then a part of one name.

    UnknownPort if there is none, or several of which it is a part.
    """
    if wanted in names:
        return wanted
    same = [name for name in names if lasting_name(name) == lasting_name(wanted)]
    parts = [name for name in names if lasting_name(wanted) in lasting_name(name)]
    for found in (same, parts):
        if len({lasting_name(name) for name in found}) == 1:
            return found[0]
    listed = ", ".join(parts or names) or "none"
    what = "several MIDI ports are called so" if parts else "there is no such MIDI port"
    raise UnknownPort(f"{what}; there are: {listed}")


def find_port(direction: Direction, wanted: str) -> str:
    """The whole name of a port; MidiUnavailable, or UnknownPort with a list of those that there are."""
    if is_stream(wanted):
        return wanted
    systems = port_names(direction)
    for names in systems.values():
        try:
            return match_port(wanted, names)
        except UnknownPort as error:
            problem = error
    if len(systems) > 1:
        return match_port(wanted, [name for names in systems.values() for name in names])
    raise problem


def open_port(direction: Direction, wanted: str) -> Port:
    """Connect to a port by its name, whichever system has it; MidiUnavailable, UnknownPort or OSError."""
    if is_stream(wanted):
        return (RtpPort if wanted.startswith(RTP) else StreamPort)(direction, wanted)
    for api, names in port_names(direction).items():
        try:
            match_port(wanted, names)
        except UnknownPort as error:
            problem = error
            continue
        return OpenPort(direction, api, wanted)
    raise problem


def open_output(wanted: str) -> Port:
    """Connect to a port to send to, by its name; as `open_port`."""
    return open_port("output", wanted)
