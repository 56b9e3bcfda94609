"""MIDI ports of ALSA's sequencer, through alsa-midi, which is loaded on demand.

Names have the form that python-rtmidi gives them, `Client:Port 24:0`, so that patches keep their meaning. Not used of
alsa-midi: its list of ports, which fails as a whole over one name that is not UTF-8 (the kernel cuts long ones within a
character), and time limits, which version 1.0.4 takes for milliseconds and so wakes a thousand times a second.
"""

import errno
import os
from collections.abc import Callable, Iterator
from typing import Any, Final

from live.control.midi.midi_streams import Direction, MidiTokenizer, Receive
from live.control.midi.midi_system import CLIENT_NAME, MidiUnavailable, foreign
from live.control.worker_thread import WorkerThread

SEQUENCER: Final = "/dev/snd/seq"
MOST: Final = 256
"""Client and port numbers are smaller."""
WAKE: Final = b"\xfe"
"""Sent to our own port when it has to end: active sensing."""


def _library() -> Any:
    """Return the module alsa_midi; MidiUnavailable if it or ALSA's library is missing."""
    try:
        import alsa_midi
    except (ImportError, OSError) as error:
        raise MidiUnavailable(f"ALSA: {error}") from None
    return alsa_midi


def _open_client() -> Any:
    """Return a new client of the sequencer; MidiUnavailable if there is none.

    The device is tried first, because ALSA's library would print to the terminal.
    """
    library = _library()
    try:
        os.close(os.open(SEQUENCER, os.O_RDWR | os.O_NONBLOCK))
        return library.SequencerClient(CLIENT_NAME)
    except FileNotFoundError:
        raise MidiUnavailable("the kernel has no ALSA sequencer") from None
    except OSError as error:
        raise MidiUnavailable(f"ALSA: {SEQUENCER}: {error.strerror}") from None
    except library.Error as error:
        raise MidiUnavailable(f"ALSA: {error}") from None


def _each(query: Callable[[int], Any], number_of: Callable[[Any], int], before: int) -> Iterator[Any]:
    """Yield what `query`, which gives the next one after a number, finds; leave out those whose name is no text."""
    while before < MOST:
        try:
            found = query(before)
        except UnicodeDecodeError:
            before += 1
            continue
        if found is None:
            return
        yield found
        before = number_of(found)


def _addresses(client: Any, direction: Direction) -> dict[str, tuple[int, int]]:
    """Return client and port number of every port that can be connected, by name; as python-rtmidi chooses them."""
    library = _library()
    caps, types = library.PortCaps, library.PortType
    needed = caps.READ | caps.SUBS_READ if direction == "input" else caps.WRITE | caps.SUBS_WRITE
    kinds = types.MIDI_GENERIC | types.SYNTH | types.APPLICATION
    found = {}
    for owner in _each(client.query_next_client, lambda info: int(info.client_id), 0):  # 0: the system's clock
        number = owner.client_id

        def next_port(before: int, number: int = number) -> Any:
            return client.query_next_port(number, before)

        for port in _each(next_port, lambda info: int(info.port_id), -1):
            if port.type & kinds and port.capability & needed == needed:
                found[_full_name(owner, port)] = (number, port.port_id)
    return found


def _full_name(owner: Any, port: Any) -> str:
    return f"{owner.name}:{port.name} {owner.client_id}:{port.port_id}"


class AlsaPort:
    """One connection. Create, use and close it in one thread; messages arrive on its own thread."""

    system_runs = True

    def __init__(self, direction: Direction, name: str) -> None:
        """Connect to the port; MidiUnavailable or OSError if that fails."""
        self.name = name
        self._library = _library()
        self._client = _open_client()
        self._receive: Receive = lambda message: None
        self._worker = WorkerThread("midi in", self._read)
        caps = self._library.PortCaps
        try:
            address = _addresses(self._client, direction).get(name)
            if address is None:
                raise OSError("the port is gone")
            self._address = address
            if direction == "input":
                self._own = self._client.create_port("in", caps.WRITE | caps.SUBS_WRITE)
                self._own.connect_from(address)
            else:
                self._own = self._client.create_port("out", caps.READ | caps.SUBS_READ)
                self._own.connect_to(address)
        except self._library.Error as error:
            self.close()
            raise OSError(f"ALSA: {error}") from None
        except BaseException:
            self.close()
            raise

    def listen(self, receive: Receive) -> None:
        """Pass every message, including clock, active sensing and system exclusive, to `receive` as it arrives."""
        self._receive = receive
        self._worker.start()

    def _read(self) -> None:
        """Read until the port is closed. An exclusive message comes in pieces of 256 bytes."""
        client, tokens = self._client, MidiTokenizer()
        while not self._worker.stopping.is_set():
            try:
                event = client.event_input(prefer_bytes=True)
            except self._library.ALSAError as error:
                if error.errnum != -errno.ENOSPC:
                    raise
                tokens.reset()  # the kernel's queue was full and messages are lost; what is in it still comes
                continue
            if isinstance(event, self._library.MidiBytesEvent) and not self._worker.stopping.is_set():
                for message in tokens.feed(event.midi_bytes):
                    self._receive(message)

    def send(self, message: bytes) -> None:
        """Send one message; OSError if that fails."""
        if self._client is None:
            raise OSError("the MIDI port is closed")
        try:
            self._put(message, None)
        except self._library.Error as error:
            raise OSError(f"ALSA: {error}") from None

    def _put(self, message: bytes, to: Any) -> None:
        """Send a message to all that are connected, or to one port."""
        self._client.event_output(self._library.MidiBytesEvent(message), port=self._own, dest=to)
        self._client.drain_output()

    @property
    def exists(self) -> bool:
        """Whether the other side still exists. A port that has returned under another number must be opened again."""
        if self._client is None:
            return False
        try:  # asked five times a second: nothing else is looked at
            owner = self._client.get_client_info(self._address[0])
            return self.name == _full_name(owner, self._client.get_port_info(self._address))
        except (self._library.Error, UnicodeDecodeError):
            return False

    def close(self) -> None:
        """Close the port; errors of the system are ignored."""
        client = self._client
        if client is None:
            return
        try:
            if self._worker.started:
                self._worker.stopping.set()
                self._put(WAKE, self._own)
        except self._library.Error:
            pass  # the sequencer is gone, and with it the wait for its messages
        self._client = None
        if self._worker.stop():  # else the thread still uses the client
            client.close()


class AlsaSystem:
    """ALSA's sequencer. Thread: any."""

    name = "ALSA"

    def port_names(self, direction: Direction) -> list[str]:
        """Return the ports of others, `Midi Through` among them; MidiUnavailable without a sequencer."""
        client = _open_client()
        try:
            return foreign(list(_addresses(client, direction)))
        except _library().Error as error:
            raise MidiUnavailable(f"ALSA: {error}") from None
        finally:
            client.close()

    def open_port(self, direction: Direction, name: str) -> AlsaPort:
        """Connect to a port; MidiUnavailable or OSError if that fails."""
        return AlsaPort(direction, name)
