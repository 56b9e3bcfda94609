"""SessionAudio: the sound of a running show, in this process, or in one of its own where a supervisor has one."""

from collections.abc import Callable

from live.app.processes.audio_client import RemoteAudio
from live.app.processes.resume_state import Resumed
from live.app.session_sound import AudioSource, Sound, make_audio, sound_plan
from live.base.errors import PersonError
from live.base.inbox import Inbox
from live.clock.time_source import SystemClock
from live.control.audio.sound_devices import device_refuses
from live.control.events.events import ControlEvent
from live.show.core import Show
from live.show.load import LoadedShow
from live.show.venue.venue_latency import Latencies
from live.supervisor.lifeline import Lifeline


class SessionAudio:
    """What is listened to or played, if anything is. Thread: the one that runs the show."""

    def __init__(
        self, sound: Sound, loaded: LoadedShow, show: Show, latencies: Latencies, inbox: Inbox[ControlEvent],
        clock: SystemClock, *, lifeline: Lifeline | None, resumed: Resumed | None,
    ) -> None:  # fmt: skip
        """It is made, not started; PersonError for what cannot be."""
        self._sound = sound
        self._remote: RemoteAudio | None = None
        self.source: AudioSource | None
        """The source; None for a show that listens to nothing and plays nothing."""
        self.tell: Callable[[ControlEvent], None]
        """Is to be told the events that concern the sound."""
        there = None if lifeline is None else lifeline.sound
        if there is None or (sound.music is None and sound.device is None):
            self.source, self.tell = make_audio(sound, loaded, show, latencies, inbox, clock)
            return
        plan = sound_plan(sound, loaded)
        self._remote = RemoteAudio(there, plan, show, latencies, inbox, clock, resumed=resumed)
        self.source, self.tell = self._remote, self._remote.act

    @property
    def listens(self) -> AudioSource | None:
        """The source, where it is a device that is listened to."""
        return self.source if self._sound.device is not None else None

    @property
    def level(self) -> float | None:
        """RMS of what an input device hears; None where nothing is heard."""
        return getattr(self.source, "level", None)

    @property
    def begun(self) -> float | None:
        """When the sound of another process began [s of the show]; None for sound of this one."""
        return None if self._remote is None else self._remote.begun

    def start(self) -> None:
        """Begin to listen or to play; PersonError if that is refused."""
        if self.source is None:
            return
        try:
            self.source.start()
        except PersonError:
            raise
        except Exception as error:  # PortAudioError, whose class is known only where PortAudio is
            raise device_refuses(error, "--audio", self._sound.device) from None

    def frame(self) -> None:
        """Before each frame: what another process heard since the last one."""
        if self._remote is not None:
            self._remote.frame()

    def silence(self) -> None:
        """Another process shall play and listen no more: another machine leads."""
        if self._remote is not None:
            self._remote.silence()

    def stop(self) -> None:
        """End, and free the device."""
        if self.source is not None:
            self.source.stop()
