"""Audio devices of this machine through PortAudio, which is loaded only on use, and a watchdog for their threads."""

import contextlib
import re
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Any, Final

from live.base.errors import PersonError
from live.base.fault_isolation import keep_running, run_once
from live.clock.time_source import Clock

CALL_TIMEOUT: Final = 5.0
"""Seconds after which the sound system, called by another thread, counts as hung."""

CLOSE_TIMEOUT: Final = 2.0
"""Maximum seconds to close a stream before it is abandoned."""

_guard = threading.Lock()
_streams = 0


class SoundUnavailable(RuntimeError):
    """PortAudio, the library for audio devices, is missing or broken; the message states the remedy."""


class UnknownDevice(ValueError):
    """No device has that name; the message lists the devices."""


def device_error(error: Exception, option: str, name: str | None) -> PersonError:
    """Return the error for a device that does not start; `option` is the command line option that chose it."""
    return PersonError(f"the sound device {name!r} refuses: {error}", f"see `live devices`, or give another {option}")


@dataclass(frozen=True, slots=True)
class SoundDevice:
    """One device. `index` is PortAudio's and changes between runs; `name` is stable."""

    index: int
    name: str
    host: str
    """Its sound system (ALSA, JACK, Core Audio …)."""
    channels: int
    sample_rate: float
    """Native rate [Hz]."""
    default: bool


def sounddevice() -> ModuleType:
    """Return the sounddevice module; SoundUnavailable if PortAudio cannot be loaded."""
    try:
        import sounddevice as module
    except OSError as error:
        raise SoundUnavailable(
            f"no sound devices: {error}; install PortAudio (Debian, Ubuntu: apt install libportaudio2; "
            "Fedora: dnf install portaudio; macOS: brew install portaudio)"
        ) from None
    return module  # type: ignore[no-any-return]


def list_input_devices() -> list[SoundDevice]:
    """Return the input devices; SoundUnavailable if PortAudio is missing."""
    return _list("input")


def list_output_devices() -> list[SoundDevice]:
    """Return the output devices; SoundUnavailable if PortAudio is missing."""
    return _list("output")


@contextlib.contextmanager
def _locked() -> Iterator[None]:
    """Hold the lock on PortAudio; SoundUnavailable if another thread's call never returns."""
    if not _guard.acquire(timeout=CALL_TIMEOUT):
        raise SoundUnavailable("the sound system does not answer any more; restart it (PulseAudio: pulseaudio -k)")
    try:
        yield
    finally:
        _guard.release()


def lasting_name(name: str) -> str:
    """Return a device's name without the card number, which changes when it is plugged in again."""
    return re.sub(r"\s*\(hw:\d+,\d+\)\s*$", "", name).casefold()


def find_device(text: str | int | None, kind: str = "input") -> SoundDevice:
    """Return the device with this index or name, or whose name contains `text` (ignoring case); None: the default.

    An exact name comes first, then the same name on another card (`hw:0,0` and `hw:1,0`), then a part of a name. `kind`
    is "input" or "output". Raises UnknownDevice with a list of the devices.
    """
    devices = _list(kind)
    if text is None:
        chosen = [device for device in devices if device.default] or devices
    elif isinstance(text, int) or text.strip().isdigit():
        chosen = [device for device in devices if device.index == int(text)]
    else:
        wanted = text.strip().casefold()
        chosen = _with_name(devices, text) or [
            device for device in devices if wanted and wanted in device.name.casefold()
        ]
    if chosen:
        return chosen[0]
    asked = f"no sound {kind}" if text is None else f"no sound {kind} {text!r}"
    if not devices:
        raise UnknownDevice(f"{asked}: this machine has no sound {kind} at all; plug one in, or play a music file")
    listed = "; ".join(f"{device.index}: {device.name}" for device in devices)
    raise UnknownDevice(f"{asked}; there are: {listed} (a part of the name is enough)")


def find_again(lost: SoundDevice, kind: str = "input") -> SoundDevice:
    """Find a device again by its whole name, on any card, preferably in the same sound system.

    A device whose name only contains it is another device. Raises UnknownDevice while it is absent.
    """
    chosen = _with_name(_list(kind), lost.name)
    if not chosen:
        raise UnknownDevice(f"{lost.name} is not there")
    return next((device for device in chosen if device.host == lost.host), chosen[0])


def _with_name(devices: list[SoundDevice], name: str) -> list[SoundDevice]:
    """Return the devices with exactly this name, or else those with the same name on another card."""
    wanted = name.strip().casefold()
    return [device for device in devices if device.name.casefold() == wanted] or [
        device for device in devices if lasting_name(device.name) == lasting_name(name) != ""
    ]


def refresh() -> bool:
    """Look for new devices; return whether this was possible.

    PortAudio must be restarted for it, so no stream may be open. Thread: any.
    """
    module = sounddevice()
    with _locked():
        if _streams:
            return False
        module._terminate()
        module._initialize()
        return True


def open_stream(kind: str, **options: Any) -> Any:
    """Open and start a sounddevice InputStream or OutputStream; PortAudioError if the device refuses. Thread: any."""
    global _streams
    module = sounddevice()
    with _locked():
        stream = (module.InputStream if kind == "input" else module.OutputStream)(**options)
        try:
            stream.start()
        except Exception:
            stream.close(ignore_errors=True)
            raise
        _streams += 1
        return stream


def close_stream(stream: Any) -> None:
    """Stop and close a stream of `open_stream`, even a dead one; a hung one is abandoned. Thread: any."""
    closing = threading.Thread(
        target=lambda: run_once("closing a sound device", lambda: _close(stream)),
        name="closes a sound device",
        daemon=True,
    )
    closing.start()
    closing.join(CLOSE_TIMEOUT)


def _close(stream: Any) -> None:
    global _streams
    try:
        stream.abort(ignore_errors=True)
        stream.close(ignore_errors=True)
    finally:
        with _guard:
            _streams -= 1


def _list(kind: str) -> list[SoundDevice]:
    module = sounddevice()
    with _locked():
        try:
            hosts, found = module.query_hostapis(), module.query_devices()
            default = module.default.device[0 if kind == "input" else 1]
        except module.PortAudioError as error:
            raise SoundUnavailable(f"the sound devices cannot be listed: {error}") from None
    return [
        SoundDevice(
            index=int(entry["index"]),
            name=str(entry["name"]),
            host=str(hosts[entry["hostapi"]]["name"]),
            channels=int(entry[f"max_{kind}_channels"]),
            sample_rate=float(entry["default_samplerate"]),
            default=entry["index"] == default,
        )
        for entry in found
        if entry[f"max_{kind}_channels"] > 0
    ]


POLL: Final = 0.010
"""Seconds between calls."""

HUNG_AFTER: Final = 10.0
"""A thread without a new call for this many seconds counts as hung; a restart abandons it."""

STOP_TIMEOUT: Final = 2.0
"""Maximum seconds for a thread to end before it is abandoned."""


class DeviceWatchdog:
    """Calls `poll` repeatedly, then `end`, in a thread that can be replaced when it hangs.

    A hung thread that resumes finds that `mine` has been replaced, and ends.
    """

    def __init__(self, name: str, clock: Clock, poll: Callable[[], None], end: Callable[[], None]) -> None:
        """Configure the thread; it is not started yet."""
        self._name, self._clock, self._poll, self._end = name, clock, poll, end
        self.stop_event = threading.Event()
        """Identifies the current thread; set to stop it. Keep a reference while calling the sound system."""
        self.thread: threading.Thread | None = None
        self.called_at = 0.0
        """Time of the last call [s]."""

    @property
    def is_hung(self) -> bool:
        """Whether the thread is hung."""
        return self.thread is not None and self._clock.now() - self.called_at > HUNG_AFTER

    def start(self) -> None:
        """Start a thread; an existing one is abandoned."""
        self.stop_event.set()
        self.stop_event = threading.Event()
        self.called_at = self._clock.now()
        self.thread = threading.Thread(target=self._run, args=(self.stop_event,), name=self._name, daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """Stop; a hung thread is abandoned."""
        self.stop_event.set()
        if self.thread is not None:
            self.thread.join(timeout=STOP_TIMEOUT)
            self.thread = None

    def _run(self, mine: threading.Event) -> None:
        def rounds() -> None:
            while not mine.wait(POLL):
                self.called_at = self._clock.now()
                self._poll()

        try:
            keep_running(self._name, rounds, mine.wait)
        finally:
            if mine is self.stop_event:
                self._end()
