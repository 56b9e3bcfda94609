"""Audio input from a selected device and channels, with recovery from device and analysis failures."""

import threading
from collections import deque
from dataclasses import dataclass
from typing import Any, Final

from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.clock.time_source import Clock
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.audio.channel_mixer import Channels
from live.control.audio.device_stream import DeviceStream, open_device
from live.control.audio.devices import DeviceWatchdog, SoundDevice, find_again, find_device, refresh
from live.control.events.events import ChooseAudio, ControlEvent, RestartAudio, SourceChanged


@dataclass(frozen=True, slots=True)
class AudioChoice:
    """A device as found, and the channels requested from it."""

    device: SoundDevice
    channels: Channels

    @classmethod
    def of(cls, device: str | int | None, channels: Channels) -> "AudioChoice":
        """`device` as for `find_device`. Raises SoundUnavailable, UnknownDevice, and PersonError if channels are
        missing."""
        return cls(find_device(device), channels)._checked()

    def changed(self, device: str, channels: str) -> "AudioChoice":
        """Return a choice with another device, other channels, or both; empty: unchanged. Raises as `of` does."""
        return AudioChoice(
            find_device(device) if device else self.device, Channels.parse(channels) if channels else self.channels
        )._checked()

    def found_again(self) -> "AudioChoice":
        """Return the same device as it is now, with any of its channels; UnknownDevice if it is absent."""
        return AudioChoice(find_again(self.device), self.channels)

    def _checked(self) -> "AudioChoice":
        missing = self.channels.missing(self.device.channels)
        if missing:
            raise PersonError(f"{self.device.name}: {missing}", "choose others, see `live devices`")
        return self


LOST_AFTER: Final = 0.5
"""Seconds without a callback after which the device counts as lost."""

START_TIMEOUT: Final = 3.0
"""Maximum seconds from opening a device to its first callback (sound servers take one or two)."""

RETRY: Final = 2.0
"""Seconds between attempts to reopen a lost device."""

CRASH_WINDOW: Final = 5.0
"""If the analysis fails twice within this many seconds, the device is reopened."""

MAX_REQUESTS: Final = 16
"""Maximum of pending device changes."""

METER_FALL: Final = 0.95
"""Meter decay per block: 20 dB in half a second."""


class AudioInput:
    """Analyses a device's sound and puts the events found, and SourceChanged, into a queue.

    When no sound arrives for half a second, the source is "lost". The device is then reopened by name every two seconds
    until it is "found"; its rate and channels may have changed. A failed analysis is restarted and counted. NaN samples
    become silence. `handle` handles the events that control the input.
    """

    def __init__(
        self,
        device: str | int | None,
        inbox: EventQueue[ControlEvent],
        clock: Clock,
        *,
        channels: Channels = Channels(),  # noqa: B008 - frozen
        latency: float = 0.0,
        source: str = "audio",
        analysis: MakeAnalysis | None = None,
    ) -> None:
        """`device` as for `find_device`; `latency` [s]: delay of the sound from the loudspeakers to this input.

        `analysis` makes the analysis for a sample rate. Raises SoundUnavailable or UnknownDevice, and PersonError if
        the device lacks the channels.
        """
        self._choice = AudioChoice.of(device, channels)
        self.latency = latency
        self.reopened = 0
        """Number of times the device was reopened."""
        self.crashes = 0
        """Number of times the analysis failed and was restarted."""
        self.problem = ""
        """Description of the present problem; empty if there is none."""
        self.failure = ""
        """Description of the latest failure of the analysis."""
        self._inbox = inbox
        self._clock = clock
        self._source = source
        self._analysis: MakeAnalysis = analysis or (lambda rate: AudioAnalysis(rate, source))
        self._open_stream: DeviceStream | None = None
        self._requests: deque[RestartAudio | ChooseAudio] = deque(maxlen=MAX_REQUESTS)
        self._level = 0.0
        self._bad_before = 0
        self._lost = False
        self._alive_at = self._timeout = 0.0
        self._crashed_at = -CRASH_WINDOW
        self._watchdog = DeviceWatchdog("audio analysis", clock, self.poll, self._close)

    # -- any thread ----------------------------------------------------------------------------------------------

    @property
    def device(self) -> SoundDevice:
        """The selected device, open or awaited. Thread: any."""
        return self._choice.device

    @property
    def channels(self) -> Channels:
        """The requested channels. Thread: any."""
        return self._choice.channels

    @property
    def level(self) -> float:
        """RMS of the recent peak, full scale = 1 (for a meter). Thread: any."""
        return self._level

    @property
    def bad_samples(self) -> int:
        """Invalid samples (NaN, infinite, absurd) since the start. Thread: any."""
        listening = self._open_stream
        now = 0 if listening is None else listening.analysis.tracker.bad_samples + listening.mixer.bad_samples
        return self._bad_before + now

    def status(self) -> dict[str, Any]:
        """Return facts on the device for the operator's status. Thread: any."""
        listening = self._open_stream
        return {
            "device": self.device.name,
            "channels": str(self.channels),
            "sample_rate": self.device.sample_rate if listening is None else listening.sample_rate,
            "state": "lost" if self._lost else "open",
            "level": round(self._level, 5),
            "reopened": self.reopened,
            "crashes": self.crashes,
            "failure": self.failure,
            "bad_samples": self.bad_samples,
            "overrun": 0 if listening is None else listening.ring.overrun,
            "problem": self.problem,
        }

    def handle(self, event: ControlEvent) -> None:
        """Handle RestartAudio and ChooseAudio; other events are ignored. Thread: any."""
        if not isinstance(event, RestartAudio | ChooseAudio):
            return
        self._requests.append(event)
        if self._watchdog.is_hung:
            self._open_stream = None  # its stream belongs to the hung thread and is abandoned with it
            self._watchdog.start()

    def start(self) -> None:
        """Open the device and start; raises sounddevice.PortAudioError if it refuses now."""
        self._open(self._watchdog.stop_event)
        self._watchdog.start()

    def stop(self) -> None:
        """Stop; a hung device is abandoned after two seconds."""
        self._watchdog.stop()

    # -- input thread --------------------------------------------------------------------------------------------

    def poll(self) -> None:
        """Handle pending requests, new sound and lost devices once. Never raises. Thread: the input's own."""
        now = self._clock.now()
        try:
            self._poll_device(now)
        except Exception as error:  # the input continues after any failure
            self._recover(error, now)

    def _recover(self, error: Exception, now: float) -> None:
        """Restart the analysis after a failure; after a second failure soon after, reopen the device."""
        self.crashes += 1
        self.failure = self.problem = f"the analysis failed: {type(error).__name__}: {error}"
        again, self._crashed_at = now - self._crashed_at < CRASH_WINDOW, now
        if self._open_stream is not None and not again:
            try:
                self._open_stream.begin_analysis(self._open_stream.ring.read_frames)
                return
            except Exception as refusal:  # no analysis can be made
                self.failure = self.problem = f"the analysis cannot be started: {type(refusal).__name__}: {refusal}"
        self._lose(now, self.problem)

    def _poll_device(self, now: float) -> None:
        if self._requests:
            self._apply_requests(now)
        listening = self._open_stream
        if listening is None:
            if now - self._alive_at >= RETRY:
                self._reopen(now)
            return
        last = listening.update_clock()
        if last is not None:
            self._alive_at = max(self._alive_at, last)
            self._timeout = LOST_AFTER
            if self._lost:
                self._lost = False
                self._put("found", now, self.device.name)
            for event in listening.events(self.latency, now):
                self._inbox.put(event)
            self._level = max(listening.analysis.tracker.level, self._level * METER_FALL)
            if self.problem and self.problem == self.failure and now - self._crashed_at > CRASH_WINDOW:
                self.problem = listening.problem  # no failure since
        if now - self._alive_at > self._timeout:
            self._lose(now, self.device.name)

    def _lose(self, now: float, why: str) -> None:
        if not self._lost:
            self._lost = True
            self._put("lost", now, why)
        self._level = 0.0
        self._close()
        self._alive_at = now

    def _open(self, mine: threading.Event) -> None:
        """Open the device. `mine`: the watchdog's value from before the first call to the sound system."""
        listening = open_device(self.device, self.channels, self._clock, self._analysis)
        if mine is not self._watchdog.stop_event:  # this thread hung so long that another one has replaced it
            listening.close()
            return
        self._open_stream = listening
        self.problem = listening.problem
        self._alive_at = self._clock.now()
        self._timeout = START_TIMEOUT

    def _close(self) -> None:
        if self._open_stream is not None:
            listening, self._bad_before, self._open_stream = self._open_stream, self.bad_samples, None
            listening.close()

    def _reopen(self, now: float) -> None:
        """Look for the device by name and open it; after any failure, try again later."""
        self._alive_at, mine = now, self._watchdog.stop_event
        try:
            refresh()
            again = self._choice.found_again()
            if mine is not self._watchdog.stop_event:
                return
            self._choice = again
            self._open(mine)
        except Exception as error:  # errors of an unstable sound system must not end the input
            self.problem = str(error)
            return
        self.reopened += 1

    def _apply_requests(self, now: float) -> None:
        """Close the device and open the requested one; on failure, the previous one."""
        self._lose(now, "reopened by hand")
        device = channels = refusal = ""
        while self._requests:
            asked = self._requests.popleft()
            if isinstance(asked, ChooseAudio):  # device and channels may come in separate events
                device, channels = asked.device or device, asked.channels or channels
        if device or channels:
            try:
                refresh()
                self._choice = self._choice.changed(device, channels)
            except Exception as error:
                refusal = str(error)
        self._reopen(now)
        self.problem = refusal or self.problem

    def _put(self, state: str, time: float, detail: str) -> None:
        self._inbox.put(SourceChanged(time=time, source=self._source, state=state, detail=detail))
