"""MIDI ports of this machine, looked up by name.

A MIDI system that is not running has no ports. Ports are always looked up by name, because their numbers change.
`PortThread` keeps a port open in the background.
"""

import re
import sys
from collections.abc import Callable, Mapping
from typing import Any, Final

from live.control.midi.alsa_system import AlsaSystem
from live.control.midi.jack_system import JackSystem
from live.control.midi.midi_streams import SCHEMES, Direction, Opener, Port
from live.control.midi.midi_system import MidiSystem, MidiUnavailable
from live.control.midi.rtmidi_system import RtMidiSystem
from live.control.worker_thread import WorkerThread

SYSTEMS: Final[tuple[MidiSystem, ...]] = (AlsaSystem(), JackSystem()) if sys.platform == "linux" else (RtMidiSystem(),)
"""The MIDI systems that this machine may have, in the order in which a name is looked up."""


class UnknownPort(ValueError):
    """No port has that name; the message lists the available ones."""


def port_names(direction: Direction) -> dict[str, list[str]]:
    """Return the ports of each running MIDI system by its name; MidiUnavailable if none runs."""
    return {system.name: names for system, names in _running(direction)}


def _running(direction: Direction) -> list[tuple[MidiSystem, list[str]]]:
    """Return the systems that run, with their ports; MidiUnavailable if none does."""
    found: list[tuple[MidiSystem, list[str]]] = []
    reasons: list[str] = []
    for system in SYSTEMS:
        try:
            found.append((system, system.port_names(direction)))
        except MidiUnavailable as error:
            reasons.append(error_text(error))
    if not found:
        raise MidiUnavailable(f"no MIDI system runs here: {', '.join(reasons)}")
    return found


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
    for system, names in _running(direction):
        try:
            name = match_port(wanted, names)
        except UnknownPort as error:
            problem = error
            continue
        return system.open_port(direction, name)
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
