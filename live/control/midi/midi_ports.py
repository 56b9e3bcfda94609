"""The MIDI ports of this machine by name, through python-rtmidi, which is loaded only when somebody asks for it.

ALSA, JACK, Core MIDI and Windows are asked in the order in which rtmidi names them; a system that is not running has
no ports. Names stay, numbers change: a port is always looked up by its name.

PortThread: a MIDI port by its name, opened whenever it is there, by a thread of its own.
"""

import ctypes
import glob
import os
import re
import sys
import threading
from collections.abc import Callable
from types import ModuleType
from typing import Any, Final

from live.base.fault_isolation import keep_running
from live.control.midi.midi_streams import RTP, Direction, Port, StreamPort, is_stream
from live.control.midi.rtp_midi import RtpPort

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


RETRY: Final = 2.0
"""Seconds between two attempts to open a port that is not there, and between two looks whether it still is."""

Open = Callable[[str], Port]


class PortThread:
    """No frame waits for a cable. Subclasses say in `_run` what the thread does, and `_care` there from time to time.

    Thread: `start` and `stop` belong to the one that made it, all that touches the port to its own.
    """

    def __init__(self, name: str, what: str, open_by_name: Open) -> None:
        """Nothing is opened yet. `what` the thread is called; `open_by_name` raises whatever it likes where there is no
        such port (yet)."""
        self.name = name
        self.connected = ""
        """The whole name of the port that is open; empty while there is none."""
        self.problem = ""
        """Why no port is open."""
        self.opened = 0
        """How often it was opened: who is there now has heard nothing of what was sent before."""
        self._what = what
        self._open_by_name = open_by_name
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._port: Port | None = None

    def start(self) -> None:
        """Begin; a port that is not there is waited for."""
        self._stop.clear()
        self._thread = threading.Thread(target=self._keep_running, name=f"{self._what} {self.name}", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End; a port that hangs is left to its thread after two seconds."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(timeout=2.0)
            self._thread = None

    def facts(self) -> dict[str, Any]:
        """For the status line."""
        return {"port": self.connected or self.name, "problem": self.problem}

    def _keep_running(self) -> None:
        keep_running(f"{self._what} {self.name}", self._run, self._stop.wait)

    def _run(self) -> None:
        """Work until `_stop`, and `_close` in the end whatever happens."""
        raise NotImplementedError

    def _care(self) -> None:
        """See that the port is open; whatever goes wrong, there is another time."""
        try:
            if self._port is not None and not self._lives(self._port):
                self._lose("the port is gone")
            if self._port is None:
                self._open()
        except Exception as error:  # MIDI systems come and go: no error of theirs may end the show
            self._lose(words_of(error))

    def _lives(self, port: Port) -> bool:
        """Whether the port that is open still is there."""
        return port.there

    def _open(self) -> None:
        """Open it; raises whatever the system does."""
        self._port = self._open_by_name(self.name)
        self._begin(self._port)
        self.connected, self.problem = self._port.name, ""
        self.opened += 1

    def _begin(self, port: Port) -> None:
        """What is to be done with a port that was opened just now."""

    def _lose(self, problem: str) -> None:
        """Give the port up, if one is open, for this reason."""
        self.problem = problem
        self._close()

    def _close(self) -> None:
        port, self._port, self.connected = self._port, None, ""
        if port is not None:
            port.close()


def words_of(error: Exception) -> str:
    """What an error says, on one line."""
    return " ".join(str(error).split())
