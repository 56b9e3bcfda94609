"""MIDI ports of this machine, looked up by name through python-rtmidi, which is loaded on demand.

ALSA, JACK, Core MIDI and Windows are queried in rtmidi's order; a system that is not running has no ports. Ports are
always looked up by name, because their numbers change. `PortThread` keeps a port open in the background.
"""

import ctypes
import glob
import os
import re
import sys
from collections.abc import Callable, Mapping
from functools import partial
from types import ModuleType
from typing import Any, Final

from live.control.midi.midi_streams import SCHEMES, Direction, Opener, Port
from live.control.worker_thread import WorkerThread

CLIENT_NAME: Final = "ChoreoGraphics"
"""Name of our end of a connection in the system's patch bays."""
JACK_POLL_INTERVAL: Final = 0.001
"""Seconds between two looks at JACK's messages; a cycle of JACK takes 3 to 20 ms."""


class MidiUnavailable(RuntimeError):
    """python-rtmidi is missing or no MIDI system runs; the message gives the remedy."""


class UnknownPort(ValueError):
    """No port has that name; the message lists the available ones."""


def rtmidi() -> ModuleType:
    """Return the rtmidi module; MidiUnavailable if it cannot be loaded."""
    try:
        import rtmidi as module
    except ModuleNotFoundError as error:
        raise MidiUnavailable(f"{error}: python-rtmidi is ready-made for Python 3.11 and 3.12 only") from None
    except ImportError as error:
        raise MidiUnavailable(f"rtmidi: {error}") from None
    return module  # type: ignore[no-any-return]


class OpenPort:
    """One open connection. Create, use and close it in one thread; messages arrive on rtmidi's thread."""

    def __init__(self, direction: Direction, api: int, wanted: str) -> None:
        """Connect to the port named `wanted`; UnknownPort or OSError (of rtmidi) if that fails."""
        self.direction = direction
        self._client = _client(direction, api)
        self._jack = api == rtmidi().API_UNIX_JACK
        self._poll: WorkerThread | None = None
        try:
            names: list[str] = self._client.get_ports()
            self.name = match_port(wanted, names)
            self._client.open_port(names.index(self.name), "in" if direction == "input" else "out")
        except BaseException:
            self.close()
            raise

    def listen(self, receive: Callable[[list[int]], None]) -> None:
        """Pass every message, including clock, active sensing and system exclusive, to `receive` as it arrives."""
        self._client.ignore_types(sysex=False, timing=False, active_sense=False)
        if self._jack:
            self._poll = WorkerThread("midi in", partial(self._pass_on, receive), every=JACK_POLL_INTERVAL)
            self._poll.start()
        else:
            self._client.set_callback(lambda event, _data=None: receive(event[0]))

    def _pass_on(self, receive: Callable[[list[int]], None]) -> None:
        """Take JACK's messages from rtmidi's own queue.

        A callback would wait for the interpreter within JACK's cycle. If it waits too long, the next cycle empties the
        buffer, and rtmidi passes on the last message again instead of each that follows.
        """
        while (event := self._client.get_message()) is not None:
            receive(event[0])

    def send(self, message: bytes) -> None:
        """Send one message."""
        self._client.send_message(message)

    @property
    def exists(self) -> bool:
        """Whether the other side still exists. A port that has returned under another number must be opened again."""
        return self.name in self._client.get_ports()

    @property
    def system_runs(self) -> bool:
        """Whether the MIDI system itself still answers; JACK keeps listing its ports when its server has died.

        The check takes some milliseconds, so call it only when no messages arrive.
        """
        if not self._jack:
            return True
        try:
            _client(self.direction, rtmidi().API_UNIX_JACK).delete()
        except Exception:
            return False
        return True

    def close(self) -> None:
        """Close the port; errors of the system are ignored."""
        if self._poll is not None:
            self._poll.stop()
        client, self._client = self._client, _ClosedClient()
        if self._jack and not client.get_ports():
            leak_client(client)
            return
        try:
            if self.direction == "input":
                client.cancel_callback()
            client.close_port()
            client.delete()
        except Exception:  # the system is gone
            return


def leak_client(client: Any) -> None:
    """Leak a client on purpose: closing a client of a dead JACK server would end this process.

    An empty list of ports is taken for a dead server; if the server is alive, an unconnected client stays behind.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(client))


class _ClosedClient:
    """Replacement for a closed client."""

    def get_ports(self) -> list[str]:
        return []

    def send_message(self, message: bytes) -> None:
        raise OSError("the MIDI port is closed")

    def cancel_callback(self) -> None: ...

    def get_message(self) -> None: ...

    def close_port(self) -> None: ...

    def delete(self) -> None: ...


def _client(direction: Direction, api: int) -> Any:
    module = rtmidi()
    make = module.MidiIn if direction == "input" else module.MidiOut
    return make(api, name=CLIENT_NAME)


def port_names(direction: Direction) -> dict[int, list[str]]:
    """Return the ports of each running MIDI system by rtmidi's API number; MidiUnavailable if none runs."""
    found: dict[int, list[str]] = {}
    reasons: list[str] = []
    for api in rtmidi().get_compiled_api():
        if absent := _unavailable_reason(api):
            reasons.append(absent)
            continue
        try:
            client = _client(direction, api)
        except Exception as error:  # rtmidi.SystemError, not the built-in one
            reasons.append(f"rtmidi: {' '.join(str(error).split())}")
            continue
        try:
            names = client.get_ports()
        finally:
            client.delete()
        found[api] = [name for name in names if not name.startswith(CLIENT_NAME)]
    if not found:
        raise MidiUnavailable(f"no MIDI system runs here: {', '.join(reasons) or 'rtmidi knows none'}")
    return found


def _unavailable_reason(api: int) -> str:
    """Return why a system cannot run on this Linux, else ""; a failing query would print to the terminal."""
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


def stable_name(name: str) -> str:
    """Return a port's name without the numbers that change when it is plugged in again.

    These are ALSA's client and port numbers (`Pad 24:0`), those of its bridge to JACK (`a2j:Pad [24] (capture): Pad`),
    and the suffix that JACK adds to a client's name that is in use (`pad-01:out`).
    """
    return re.sub(r"\s+\d+:\d+$|\s+\[\d+\](?=[\s:]|$)|-\d\d(?=:)", "", name).casefold()


def match_port(wanted: str, names: list[str]) -> str:
    """Return the port named `wanted`: an exact match first, then without changing numbers, then as part of one name.

    UnknownPort if none matches, or if it is part of several names.
    """
    if wanted in names:
        return wanted
    same = [name for name in names if stable_name(name) == stable_name(wanted)]
    parts = [name for name in names if stable_name(wanted) in stable_name(name)]
    for found in (same, parts):
        if len({stable_name(name) for name in found}) == 1:
            return found[0]
    listed = ", ".join(parts or names) or "none"
    what = "several MIDI ports match this name" if parts else "there is no such MIDI port"
    raise UnknownPort(f"{what}; there are: {listed}")


def find_port(direction: Direction, wanted: str, schemes: Mapping[str, Opener] = SCHEMES) -> str:
    """Return the full name of a port; MidiUnavailable, or UnknownPort with a list of the available ones."""
    if _opener(wanted, schemes) is not None:
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


def _opener(name: str, schemes: Mapping[str, Opener]) -> Opener | None:
    scheme, colon, _ = name.partition(":")
    return schemes.get(scheme) if colon else None


def open_port(direction: Direction, wanted: str, schemes: Mapping[str, Opener] = SCHEMES) -> Port:
    """Connect to a port by its scheme, or its name in any MIDI system; MidiUnavailable, UnknownPort or OSError."""
    opener = _opener(wanted, schemes)
    if opener is not None:
        return opener(direction, wanted)
    for api, names in port_names(direction).items():
        try:
            match_port(wanted, names)
        except UnknownPort as error:
            problem = error
            continue
        return OpenPort(direction, api, wanted)
    raise problem


def open_output(wanted: str) -> Port:
    """Connect to an output port by its name; as `open_port`."""
    return open_port("output", wanted)


RETRY_INTERVAL: Final = 2.0
"""Seconds between attempts to open a missing port, and between checks whether an open one still exists."""

Open = Callable[[str], Port]


class PortThread:
    """A MIDI port by name with its own thread, so that no frame waits for a device; opened whenever it exists.

    Subclasses implement the thread in `_run` and call `_maintain` there regularly. Call `start` and `stop` from the
    creating thread; only the port's own thread touches the port.
    """

    def __init__(self, name: str, role: str, open_by_name: Open) -> None:
        """Open nothing yet. `role`: the thread's name; `open_by_name` may raise anything if the port is missing."""
        self.name = name
        self.connected = ""
        """The full name of the open port; empty if none is open."""
        self.problem = ""
        """Why no port is open."""
        self.opened = 0
        """How often the port was opened; a device that was connected again has received nothing sent before."""
        self._open_by_name = open_by_name
        self._worker = WorkerThread(f"{role} {name}", self._run)
        self._stop = self._worker.stopping
        self._port: Port | None = None

    def start(self) -> None:
        """Start the thread; a missing port is opened as soon as it appears."""
        self._worker.start()

    def stop(self) -> None:
        """Stop the thread; after two seconds a port that hangs is left to it."""
        self._worker.stop()

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        return {"port": self.connected or self.name, "problem": self.problem}

    def _run(self) -> None:
        """Work until `_stop` is set, and `_close` in any case."""
        raise NotImplementedError

    def _maintain(self) -> None:
        """Open the port or check that it still exists; errors are kept for the status and the next call tries again."""
        try:
            if self._port is not None and not self._is_alive(self._port):
                self._disconnect("the port is gone")
            if self._port is None:
                self._open()
        except Exception as error:  # MIDI systems come and go; their errors must not end the show
            self._disconnect(error_text(error))

    def _is_alive(self, port: Port) -> bool:
        """Whether the open port still exists."""
        return port.exists

    def _open(self) -> None:
        """Open the port; raises any error of the system."""
        self._port = self._open_by_name(self.name)
        self._on_open(self._port)
        self.connected, self.problem = self._port.name, ""
        self.opened += 1

    def _on_open(self, port: Port) -> None:
        """Prepare a port that was just opened."""

    def _disconnect(self, problem: str) -> None:
        """Close the port, if one is open, and keep the reason."""
        self.problem = problem
        self._close()

    def _close(self) -> None:
        port, self._port, self.connected = self._port, None, ""
        if port is not None:
            port.close()


def error_text(error: Exception) -> str:
    """Return an error's message on one line."""
    return " ".join(str(error).split())
