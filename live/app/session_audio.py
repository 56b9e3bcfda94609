"""SessionAudio: the sound of a running show, in this process, or in one of its own where a supervisor has one.

What a show listens to or plays: chosen from the command line, the venue and the patch, and made.

Starting tempo: at which a show begins, by what was asked for and what is heard.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from live.app.launch_options import Wish
from live.app.practice import FASTEST, SLOWEST, practice_tempo
from live.app.processes.audio_client import RemoteAudio
from live.app.processes.resume_state import Resumed
from live.base.errors import PersonError, named
from live.base.event_queue import Inbox
from live.clock.follower.manual_control import Seed
from live.clock.time_source import Clock, SystemClock
from live.control.audio.devices import device_refuses
from live.control.audio.music_file import Music, MusicFileError, read_music
from live.control.events.events import ControlEvent, RestartAudio, SetLatency
from live.control.midi.midi_file import read_song
from live.show.loader import LoadedShow
from live.show.patch.patch_search_path import is_file
from live.show.show import Show
from live.show.venue.venue import Latencies, Venue
from live.supervisor.supervisor_link import Lifeline

if TYPE_CHECKING:
    from live.app.launch_options import Wish
    from live.control.audio.analysis import MakeAnalysis, TrackerName
    from live.control.audio.channel_mixer import Channels


class AudioSource(Protocol):
    """An audio source that has been made and waits to be started."""

    def start(self) -> None:
        """Begin to listen or to play."""
        ...

    def stop(self) -> None:
        """End, and free the device."""
        ...

    def facts(self) -> dict[str, Any]:
        """What the operator is told of it."""
        ...


@dataclass(frozen=True, slots=True)
class Sound:
    """What the clock follows: a music file, an input device by name, or nothing (the internal clock)."""

    music: Music | None = None
    device: str | None = None
    known: bool = False
    """True if the patch tells the music's tempo and first downbeat: it is the patch's own music."""
    channels: str = "1,2"
    """Which channels of the device."""
    output: str | None = None
    """The output that music is played to; None: the default."""
    path: Path | None = None
    """The music's file."""


def choose_sound(wish: "Wish", loaded: LoadedShow, venue: Venue | None = None) -> Sound:
    """What `--audio` and `--bpm` ask for, else the venue's device, else the patch's music.

    PersonError that lists what there is.
    """
    audio = None if venue is None else venue.audio
    output = None if audio is None else audio.output
    own = "1,2" if audio is None or audio.channels is None else ",".join(map(str, audio.channels))
    channels = own if wish.audio_channel is None else wish.audio_channel
    with named("--audio-channel"):
        _channels(channels)
    if wish.audio is not None:
        if wish.tempo_share is not None:
            words = "--tempo-share is for the internal clock: what is heard has a tempo of its own"
            raise PersonError(words, "leave out --audio or --tempo-share")
        path = Path(wish.audio)
        if is_file(path):
            return Sound(music=_music(path), output=output, path=path)
        what = "there is no such file, and " if path.suffix or "/" in wish.audio else ""
        return Sound(device=_device(wish.audio, f"--audio {wish.audio!r}", what), channels=channels)
    if wish.bpm is not None or wish.practises:
        return Sound()
    if audio is not None and audio.device is not None:
        return Sound(device=_device(audio.device, f"the venue's audio.device {audio.device!r}"), channels=channels)
    music = loaded.music_path
    return Sound() if music is None else Sound(music=_music(music), known=True, output=output, path=music)


def _channels(words: str) -> "Channels":
    from live.control.audio.channel_mixer import Channels

    return Channels.of(words)


def _device(name: str, asked: str, what: str = "") -> str:
    """The whole name of a device."""
    from live.control.audio.devices import SoundUnavailable, UnknownDevice, find_device

    try:
        return find_device(name).name
    except UnknownDevice as error:
        raise PersonError(f"{asked}: {what}{error}") from None
    except SoundUnavailable as error:
        raise PersonError(f"{asked}: there is no such file, and {error}") from None


def _music(path: Path) -> Music:
    try:
        return read_music(path)
    except MusicFileError as error:
        raise PersonError(str(error)) from None


def analysis_for(loaded: LoadedShow, show: Show) -> "MakeAnalysis":
    """Makes analyses with the patch's tracker, who are told what is set by hand in this show.

    Each takes the place of the one before (a device that came back, another rate, an analysis that failed): what was
    set by hand holds on.
    """
    seeds: deque[Seed] = deque(maxlen=64)
    show.seed_tracker(seeds.append)
    return analyses(loaded.patch.clock.tracker, seeds)


def analyses(tracker: "TrackerName", seeds: deque[Seed]) -> "MakeAnalysis":
    """Makes analyses with that tracker, each in the place of the one before; `seeds`: what it is told by hand."""
    from live.control.audio.analysis import AudioAnalysis

    former: AudioAnalysis | None = None

    def make(rate: float) -> AudioAnalysis:
        nonlocal former
        analysis = AudioAnalysis(rate, tracker=tracker, seeds=seeds, energy=True)
        if former is not None:
            analysis.succeed(former)
        former = analysis
        return analysis

    return make


def sound_plan(sound: Sound, loaded: LoadedShow) -> dict[str, Any]:
    """What another process needs to know to listen or to play, as plain values."""
    return {
        "music": None if sound.path is None else str(sound.path.resolve()),
        "device": sound.device,
        "channels": sound.channels,
        "output": sound.output,
        "one_at": loaded.patch.music.one_at_s if sound.known else None,
        "tracker": loaded.patch.clock.tracker,
    }


def make_audio(
    sound: Sound, loaded: LoadedShow, show: Show, latencies: Latencies, inbox: Inbox[ControlEvent], clock: Clock
) -> tuple[AudioSource | None, Callable[[ControlEvent], None]]:
    """The source of a show, and what is to be told the events that concern it."""
    if sound.music is not None:
        from live.control.audio.music_player import MusicPlayer

        one_at = loaded.patch.music.one_at_s if sound.known else None
        output: bool | str = sound.output or True
        try:
            player = MusicPlayer(
                sound.music,
                inbox,
                clock,
                loop=True,
                output=output,
                latency=latencies.output,
                one_at=one_at,
                analysis=analysis_for(loaded, show),
            )
        except ValueError as error:  # an output that is named and not there
            raise PersonError(f"the venue's audio.output: {error}") from None

        def to_player(event: ControlEvent) -> None:
            if isinstance(event, SetLatency):
                player.latency = latencies.output

        return player, to_player
    if sound.device is None:
        return None, lambda event: None
    from live.control.audio.audio_input import AudioInput

    listener = AudioInput(
        sound.device,
        inbox,
        clock,
        channels=_channels(sound.channels),
        latency=latencies.input,
        analysis=analysis_for(loaded, show),
    )

    def to_listener(event: ControlEvent) -> None:
        listener.latency = latencies.input
        listener.act(event)
        if isinstance(event, RestartAudio) and show.follower.on_seed is not None:
            # by hand is anew: what the tracker was told is void, but for what the patch says
            show.follower.on_seed(Seed("forget", event.time))
            show.seed_tracker(show.follower.on_seed)

    return listener, to_listener


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


def start_tempo(wish: Wish, loaded: LoadedShow, sound: Sound) -> float | None:
    """The tempo [bpm] to begin with; None if the patch's music is played and its own tempo and downbeat hold."""
    if wish.practises:
        return practice_tempo(wish, loaded)
    if wish.bpm is not None:
        return wish.bpm
    if wish.midi_file is not None:
        return min(max(read_song(wish.midi_file).tempo, SLOWEST), FASTEST)
    return None if sound.known else loaded.patch.clock.bpm
