"""The sound devices of this machine, through PortAudio, which is loaded only when somebody asks for it.

Rounds: a thread that looks after a device, and another one in its place when it hangs in the sound system.
"""

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

ANSWERS_WITHIN: Final = 5.0
"""Seconds after which the sound system, asked by somebody else, counts as hung."""

CLOSES_WITHIN: Final = 2.0
"""Seconds that a stream may take to close before it is left behind."""

_guard = threading.Lock()
_streams = 0


class SoundUnavailable(RuntimeError):
    """PortAudio, the library that reaches sound devices, is missing or broken; the message says how to get it."""


class UnknownDevice(ValueError):
    """No device of that name; the message lists those that there are."""


def device_refuses(error: Exception, option: str, name: str | None) -> PersonError:
    """What a person is told of a device that does not start; `option` is the one that chose it."""
    return PersonError(f"the sound device {name!r} refuses: {error}", f"see `live devices`, or give another {option}")


@dataclass(frozen=True, slots=True)
class SoundDevice:
    """One device: `index` is PortAudio's and changes from run to run, `name` stays."""

    index: int
    name: str
    host: str
    """The sound system it belongs to (ALSA, JACK, Core Audio …)."""
    channels: int
    sample_rate: float
    """The device's own rate [Hz]."""
    default: bool


def sounddevice() -> ModuleType:
    """The sounddevice module; SoundUnavailable if PortAudio cannot be loaded."""
    try:
        import sounddevice as module
    except OSError as error:
        raise SoundUnavailable(
            f"no sound devices: {error}; install PortAudio (Debian, Ubuntu: apt install libportaudio2; "
            "Fedora: dnf install portaudio; macOS: brew install portaudio)"
        ) from None
    return module  # type: ignore[no-any-return]


def list_input_devices() -> list[SoundDevice]:
    """The devices that can be listened to; SoundUnavailable if PortAudio is missing."""
    return _list("input")


def list_output_devices() -> list[SoundDevice]:
    """The devices that can be played to; SoundUnavailable if PortAudio is missing."""
    return _list("output")


@contextlib.contextmanager
def _alone() -> Iterator[None]:
    """One at a time with PortAudio; SoundUnavailable if another thread's call never returns."""
    if not _guard.acquire(timeout=ANSWERS_WITHIN):
        raise SoundUnavailable("the sound system does not answer any more; restart it (PulseAudio: pulseaudio -k)")
    try:
        yield
    finally:
        _guard.release()


def lasting_name(name: str) -> str:
    """A device's name without the number of its card, which changes when it is plugged in again."""
    return re.sub(r"\s*\(hw:\d+,\d+\)\s*$", "", name).casefold()


def find_device(text: str | int | None, kind: str = "input") -> SoundDevice:
    """The device with this index or name, or whose name contains `text` (case does not matter); None: the default.

    An exact name comes first, then the same name on another card (`hw:0,0` and `hw:1,0`), then a part of a name.
    `kind` is "input" or "output". Raises UnknownDevice, which lists what there is.
    """
    devices = _list(kind)
    if text is None:
        chosen = [device for device in devices if device.default] or devices
    elif isinstance(text, int) or text.strip().isdigit():
        chosen = [device for device in devices if device.index == int(text)]
    else:
        wanted = text.strip().casefold()
        chosen = _called(devices, text) or [device for device in devices if wanted and wanted in device.name.casefold()]
    if chosen:
        return chosen[0]
    asked = f"no sound {kind}" if text is None else f"no sound {kind} {text!r}"
    if not devices:
        raise UnknownDevice(f"{asked}: this machine has no sound {kind} at all; plug one in, or play a music file")
    listed = "; ".join(f"{device.index}: {device.name}" for device in devices)
    raise UnknownDevice(f"{asked}; there are: {listed} (a part of the name is enough)")


def find_again(lost: SoundDevice, kind: str = "input") -> SoundDevice:
    """The same device after it was away: its whole name, on whichever card, in its own sound system if several have it.

    Never one whose name merely contains it: that is another device. Raises UnknownDevice while it is not there.
    """
    chosen = _called(_list(kind), lost.name)
    if not chosen:
        raise UnknownDevice(f"{lost.name} is not there")
    return next((device for device in chosen if device.host == lost.host), chosen[0])


def _called(devices: list[SoundDevice], name: str) -> list[SoundDevice]:
    """Those of exactly this name, else those of the same name on another card."""
    wanted = name.strip().casefold()
    return [device for device in devices if device.name.casefold() == wanted] or [
        device for device in devices if lasting_name(device.name) == lasting_name(name) != ""
    ]


def refresh() -> bool:
    """Look for new devices; PortAudio must start anew for that, so it is done only while no stream of ours is open.

    Returns whether it was done. Thread: any.
    """
    module = sounddevice()
    with _alone():
        if _streams:
            return False
        module._terminate()
        module._initialize()
        return True


def open_stream(kind: str, **options: Any) -> Any:
    """Open and start a sounddevice InputStream or OutputStream; PortAudioError if the device refuses. Thread: any."""
    global _streams
    module = sounddevice()
    with _alone():
        stream = (module.InputStream if kind == "input" else module.OutputStream)(**options)
        try:
            stream.start()
        except Exception:
            stream.close(ignore_errors=True)
            raise
        _streams += 1
        return stream


def close_stream(stream: Any) -> None:
    """Stop and close a stream of `open_stream`, dead or alive; one that hangs is left behind. Thread: any."""
    closing = threading.Thread(
        target=lambda: run_once("closing a sound device", lambda: _close(stream)),
        name="closes a sound device",
        daemon=True,
    )
    closing.start()
    closing.join(CLOSES_WITHIN)


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
    with _alone():
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
"""Seconds from round to round."""

HUNG_AFTER: Final = 10.0
"""A thread that has not come round for so many seconds hangs; a restart leaves it behind."""

ENDS_WITHIN: Final = 2.0
"""Seconds that a thread may take to end before it is left to itself."""


class Rounds:
    """Calls `turn` again and again, and `end` at last, in a thread of its own.

    Whoever hung and comes back finds that `mine` is another's now, and ends without a word.
    """

    def __init__(self, name: str, clock: Clock, turn: Callable[[], None], end: Callable[[], None]) -> None:
        """Nothing is begun yet."""
        self._name, self._clock, self._turn, self._end = name, clock, turn, end
        self.mine = threading.Event()
        """Stands for the thread that is in force; set when it is to end. To be kept while the sound system is asked."""
        self.thread: threading.Thread | None = None
        self.round_at = 0.0
        """When it last came round [s]."""

    @property
    def hangs(self) -> bool:
        """Whether the thread has not come round for long."""
        return self.thread is not None and self._clock.now() - self.round_at > HUNG_AFTER

    def begin(self) -> None:
        """A thread begins; one that there is is left behind."""
        self.mine.set()
        self.mine = threading.Event()
        self.round_at = self._clock.now()
        self.thread = threading.Thread(target=self._run, args=(self.mine,), name=self._name, daemon=True)
        self.thread.start()

    def stop(self) -> None:
        """End; a thread that hangs is left to itself."""
        self.mine.set()
        if self.thread is not None:
            self.thread.join(timeout=ENDS_WITHIN)
            self.thread = None

    def _run(self, mine: threading.Event) -> None:
        def rounds() -> None:
            while not mine.wait(POLL):
                self.round_at = self._clock.now()
                self._turn()

        try:
            keep_running(self._name, rounds, mine.wait)
        finally:
            if mine is self.mine:
                self._end()
