"""AudioInput: a sound device that is listened to, and goes on being listened to whatever happens to it.

AudioChoice: which sound device is listened to, and which of its channels.
"""

import threading
from collections import deque
from dataclasses import dataclass
from typing import Any, Final

from live.base.errors import PersonError
from live.base.event_queue import Inbox
from live.clock.time_source import Clock
from live.control.audio.analysis import AudioAnalysis, MakeAnalysis
from live.control.audio.channel_mixer import Channels
from live.control.audio.device_stream import Listening, open_device
from live.control.audio.devices import Rounds, SoundDevice, find_again, find_device, refresh
from live.control.events.events import ChooseAudio, ControlEvent, RestartAudio, SourceChanged


@dataclass(frozen=True, slots=True)
class AudioChoice:
    """A device as it was found, and the channels that are wished of it."""

    device: SoundDevice
    channels: Channels

    @classmethod
    def of(cls, device: str | int | None, channels: Channels) -> "AudioChoice":
        """`device` as for `find_device`; SoundUnavailable, UnknownDevice, PersonError if it lacks the channels."""
        return cls(find_device(device), channels)._checked()

    def other(self, device: str, channels: str) -> "AudioChoice":
        """Another device, other channels, or both; empty: as they are. Raises as `of` does."""
        return AudioChoice(
            find_device(device) if device else self.device, Channels.of(channels) if channels else self.channels
        )._checked()

    def again(self) -> "AudioChoice":
        """The same device as it is there now, with whichever channels it has; UnknownDevice if it is not there."""
        return AudioChoice(find_again(self.device), self.channels)

    def _checked(self) -> "AudioChoice":
        missing = self.channels.missing(self.device.channels)
        if missing:
            raise PersonError(f"{self.device.name}: {missing}", "choose others, see `live devices`")
        return self


LOST_AFTER: Final = 0.5
"""Seconds without a callback after which the device counts as lost."""

FIRST_SOUND: Final = 3.0
"""Seconds that a device just opened may take until its first callback (sound servers take one or two)."""

RETRY: Final = 2.0
"""Seconds between attempts to open a lost device again."""

CRASHES_APART: Final = 5.0
"""When the analysis fails twice within so many seconds the device is closed and opened again."""

ASKED_MOST: Final = 16
"""Changes of the device that may wait for the thread."""

METER_FALL: Final = 0.95
"""Share of the level that is left with the next block: it falls by 20 dB in half a second."""


class AudioInput:
    """Listens to a device and puts what the analysis finds, and SourceChanged, into an inbox.

    When no sound arrives for half a second the source is "lost", and the device is opened again, by name, every
    two seconds until it is "found"; it may come back with another rate or other channels. An analysis that fails is
    begun anew and counted. Samples that are NaN become silence. `act` takes the events that ask something of it.
    """

    def __init__(
        self,
        device: str | int | None,
        inbox: Inbox[ControlEvent],
        clock: Clock,
        *,
        channels: Channels = Channels(),  # noqa: B008 - frozen
        latency: float = 0.0,
        source: str = "audio",
        analysis: MakeAnalysis | None = None,
    ) -> None:
        """`device` as for `find_device`; `latency` [s] is how long sound takes from the loudspeakers until it is here.

        `analysis` makes what listens, for a sample rate. Raises SoundUnavailable or UnknownDevice, and PersonError if
        the device lacks the channels.
        """
        self._choice = AudioChoice.of(device, channels)
        self.latency = latency
        self.reopened = 0
        """How often the device was opened again."""
        self.crashes = 0
        """How often the analysis failed and was begun anew."""
        self.problem = ""
        """What is wrong with the sound now, in words; empty if nothing is."""
        self.failure = ""
        """How the analysis failed last, in words."""
        self._inbox = inbox
        self._clock = clock
        self._source = source
        self._analysis: MakeAnalysis = analysis or (lambda rate: AudioAnalysis(rate, source))
        self._listening: Listening | None = None
        self._asked: deque[RestartAudio | ChooseAudio] = deque(maxlen=ASKED_MOST)
        self._level = 0.0
        self._bad_before = 0
        self._lost = False
        self._alive_at = self._patience = 0.0
        self._crashed_at = -CRASHES_APART
        self._rounds = Rounds("audio analysis", clock, self.turn, self._close)

    # -- any thread ----------------------------------------------------------------------------------------------

    @property
    def device(self) -> SoundDevice:
        """The device that is listened to, or waited for. Thread: any."""
        return self._choice.device

    @property
    def channels(self) -> Channels:
        """Those that are wished of it. Thread: any."""
        return self._choice.channels

    @property
    def level(self) -> float:
        """RMS of the loudest heard just now, full scale = 1 (for a meter). Thread: any."""
        return self._level

    @property
    def bad_samples(self) -> int:
        """Samples that were no sound (NaN, infinite, absurd) since the start. Thread: any."""
        listening = self._listening
        now = 0 if listening is None else listening.analysis.tracker.bad_samples + listening.mixer.bad_samples
        return self._bad_before + now

    def facts(self) -> dict[str, Any]:
        """What the operator is told of the device, for the status. Thread: any."""
        listening = self._listening
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

    def act(self, event: ControlEvent) -> None:
        """Take up RestartAudio and ChooseAudio; other events concern others. Thread: any."""
        if not isinstance(event, RestartAudio | ChooseAudio):
            return
        self._asked.append(event)
        if self._rounds.hangs:
            self._listening = None  # its stream belongs to the thread that hangs, and is left behind with it
            self._rounds.begin()

    def start(self) -> None:
        """Open the device and begin to listen; raises sounddevice.PortAudioError if it refuses now."""
        self._open(self._rounds.mine)
        self._rounds.begin()

    def stop(self) -> None:
        """End; a device that hangs is left to its thread after two seconds."""
        self._rounds.stop()

    # -- the thread that listens ---------------------------------------------------------------------------------

    def turn(self) -> None:
        """One round: what was asked, what was heard, what is lost. Never raises. Thread: the one that listens."""
        now = self._clock.now()
        try:
            self._work(now)
        except Exception as error:  # whatever fails in here, the listening goes on
            self._begin_anew(error, now)

    def _begin_anew(self, error: Exception, now: float) -> None:
        """The analysis failed: another one, or if that soon fails as well, the device from the beginning."""
        self.crashes += 1
        self.failure = self.problem = f"the analysis failed: {type(error).__name__}: {error}"
        again, self._crashed_at = now - self._crashed_at < CRASHES_APART, now
        if self._listening is not None and not again:
            try:
                self._listening.begin_analysis(self._listening.ring.read_frames)
                return
            except Exception as refusal:  # there is no other
                self.failure = self.problem = f"the analysis cannot be begun: {type(refusal).__name__}: {refusal}"
        self._lose(now, self.problem)

    def _work(self, now: float) -> None:
        if self._asked:
            self._change(now)
        listening = self._listening
        if listening is None:
            if now - self._alive_at >= RETRY:
                self._try_again(now)
            return
        last = listening.observe()
        if last is not None:
            self._alive_at = max(self._alive_at, last)
            self._patience = LOST_AFTER
            if self._lost:
                self._lost = False
                self._put("found", now, self.device.name)
            for event in listening.events(self.latency, now):
                self._inbox.put(event)
            self._level = max(listening.analysis.tracker.level, self._level * METER_FALL)
            if self.problem and self.problem == self.failure and now - self._crashed_at > CRASHES_APART:
                self.problem = listening.problem  # it has gone well since
        if now - self._alive_at > self._patience:
            self._lose(now, self.device.name)

    def _lose(self, now: float, why: str) -> None:
        if not self._lost:
            self._lost = True
            self._put("lost", now, why)
        self._level = 0.0
        self._close()
        self._alive_at = now

    def _open(self, mine: threading.Event) -> None:
        """`mine` of the rounds, as it was before the sound system was asked anything."""
        listening = open_device(self.device, self.channels, self._clock, self._analysis)
        if mine is not self._rounds.mine:  # this thread hung for so long that another one listens now
            listening.close()
            return
        self._listening = listening
        self.problem = listening.problem
        self._alive_at = self._clock.now()
        self._patience = FIRST_SOUND

    def _close(self) -> None:
        if self._listening is not None:
            listening, self._bad_before, self._listening = self._listening, self.bad_samples, None
            listening.close()

    def _try_again(self, now: float) -> None:
        """Look for the device by its name and open it; whatever goes wrong, there is another time."""
        self._alive_at, mine = now, self._rounds.mine
        try:
            refresh()
            again = self._choice.again()
            if mine is not self._rounds.mine:
                return
            self._choice = again
            self._open(mine)
        except Exception as error:  # the sound system is coming and going: no error of its may end the listening
            self.problem = str(error)
            return
        self.reopened += 1

    def _change(self, now: float) -> None:
        """Close the device and open it again, or what was chosen; if that cannot be, what there was."""
        self._lose(now, "opened anew by hand")
        device = channels = refusal = ""
        while self._asked:
            asked = self._asked.popleft()
            if isinstance(asked, ChooseAudio):  # device and channels may come one by one
                device, channels = asked.device or device, asked.channels or channels
        if device or channels:
            try:
                refresh()
                self._choice = self._choice.other(device, channels)
            except Exception as error:
                refusal = str(error)
        self._try_again(now)
        self.problem = refusal or self.problem

    def _put(self, state: str, time: float, detail: str) -> None:
        self._inbox.put(SourceChanged(time=time, source=self._source, state=state, detail=detail))
