"""Audio of a show: choice of source, construction, starting tempo, and the running source.

The source is an input device or a music file. It runs in this process, or in a separate one under a supervisor.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from live.app.launch_options import LaunchOptions
from live.app.practice import FASTEST, SLOWEST, practice_tempo
from live.app.processes.audio_client import AudioClient
from live.app.processes.resume_state import ResumeState
from live.base.errors import PersonError, error_context
from live.base.event_queue import EventQueue
from live.clock.bar_pointer.state_space import BarPointerModel
from live.clock.follower.manual_control import TrackerHint
from live.clock.map_clock import MapClock
from live.clock.time_source import Clock, SystemClock
from live.control.audio.devices import device_error
from live.control.audio.music_file import Music, MusicFileError, read_music, tempo_in_name
from live.control.events.events import ControlEvent, RestartAudio, SetLatency
from live.control.midi.midi_file import read_song
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.patch_search_path import is_file
from live.show.show import Show
from live.show.venue.venue import Latencies, Venue
from live.supervisor.supervisor_link import SupervisorLink

if TYPE_CHECKING:
    from live.app.launch_options import LaunchOptions
    from live.control.audio.analysis import MakeAnalysis
    from live.control.audio.channel_mixer import Channels


class AudioSource(Protocol):
    """Audio input or player."""

    def start(self) -> None:
        """Start to listen or to play."""
        ...

    def stop(self) -> None:
        """Stop and free the device."""
        ...

    def status(self) -> dict[str, Any]:
        """Return the values for the status line."""
        ...


@dataclass(frozen=True, slots=True)
class AudioChoice:
    """Choice of audio source: a music file, an input device by name, or nothing (the internal clock)."""

    file: "MusicFile | None" = None
    device: str | None = None
    from_patch: bool = False
    """True for the patch's own music, whose tempo and first downbeat are in the patch."""
    channels: str = "1,2"
    """Channels of the device."""
    output: str | None = None
    """Output device for music; None: the default."""

    @property
    def path(self) -> Path | None:
        """The music's file; None without music."""
        return None if self.file is None else self.file.path

    @property
    def music(self) -> Music | None:
        """The music, decoded when it is first asked for; None without music. PersonError if it cannot be."""
        return None if self.file is None else self.file.music


class MusicFile:
    """A music file that is there; another process may be the one that decodes it."""

    def __init__(self, path: Path) -> None:
        """PersonError if there is no such file."""
        self.path = path
        if not is_file(path):
            self.music  # noqa: B018 - says why

    @cached_property
    def music(self) -> Music:
        """The decoded music; PersonError if it cannot be decoded."""
        try:
            return read_music(self.path)
        except MusicFileError as error:
            raise PersonError(str(error)) from None


def choose_audio(
    options: "LaunchOptions", loaded: LoadedShow, venue: Venue | None = None, *, elsewhere: bool = False
) -> AudioChoice:
    """Choose the source of `--audio` and `--bpm`, else the venue's device, else the patch's music.

    `elsewhere`: another process plays the music, decodes it, and says if it cannot. Raise PersonError, which lists the
    devices, if the source does not exist.
    """
    chosen = _choose_audio(options, loaded, venue)
    if not elsewhere:
        chosen.music  # noqa: B018 - decodes it
    return chosen


def _choose_audio(options: "LaunchOptions", loaded: LoadedShow, venue: Venue | None) -> AudioChoice:
    audio = None if venue is None else venue.audio
    output = None if audio is None else audio.output
    own = "1,2" if audio is None or audio.channels is None else ",".join(map(str, audio.channels))
    channels = own if options.audio_channel is None else options.audio_channel
    with error_context("--audio-channel"):
        _channels(channels)
    if options.audio is not None:
        if options.tempo_share is not None:
            words = "--tempo-share is for the internal clock: audio has its own tempo"
            raise PersonError(words, "leave out --audio or --tempo-share")
        path = Path(options.audio)
        if is_file(path):
            return AudioChoice(file=MusicFile(path), output=output)
        what = "there is no such file, and " if path.suffix or "/" in options.audio else ""
        return AudioChoice(device=_device(options.audio, f"--audio {options.audio!r}", what), channels=channels)
    if options.bpm is not None or options.is_practice:
        return AudioChoice()
    if audio is not None and audio.device is not None:
        return AudioChoice(
            device=_device(audio.device, f"the venue's audio.device {audio.device!r}"), channels=channels
        )
    music = loaded.music_path
    return AudioChoice() if music is None else AudioChoice(file=MusicFile(music), from_patch=True, output=output)


def _channels(words: str) -> "Channels":
    from live.control.audio.channel_mixer import Channels

    return Channels.parse(words)


def _device(name: str, option: str, hint: str = "") -> str:
    """Return the full name of a device."""
    from live.control.audio.devices import SoundUnavailable, UnknownDevice, find_device

    try:
        return find_device(name).name
    except UnknownDevice as error:
        raise PersonError(f"{option}: {hint}{error}") from None
    except SoundUnavailable as error:
        raise PersonError(f"{option}: {hint}{error}") from None


def make_map_clock(sound: AudioChoice, patch: Patch) -> MapClock | None:
    """Return the clock of the measures of a patch's music; None for other sound."""
    if not sound.from_patch or sound.music is None:
        return None
    return MapClock(patch.music.measures, sound.music.duration)


def likely_tempo(of_patch: float | None, music: Path | None) -> float | None:
    """Return the tempo that the beat of the music is likely to have [bpm]: that of the patch, else the one in the name
    of the music's file; None if there is none."""
    return tempo_in_name(music.stem) if of_patch is None and music is not None else of_patch


def make_show_analysis(
    sound: AudioChoice, loaded: LoadedShow, show: Show, measures: MapClock | None = None
) -> "MakeAnalysis":
    """Return a factory of analyses with the patch's tracker, this show's manual settings of the beat, and the known
    measures of its music.

    Each analysis replaces the one before (a device that came back, another sample rate, a failed analysis) and keeps
    the manual settings.
    """
    from live.control.audio.analysis import make_analysis_factory

    seeds: deque[TrackerHint] = deque(maxlen=64)
    show.seed_tracker(seeds.append)
    clock = loaded.patch.clock
    model = BarPointerModel.expecting(clock.metres, likely_tempo(clock.likely_bpm, sound.path))
    return make_analysis_factory(clock.tracker, seeds, measures, model)


def audio_plan(sound: AudioChoice, loaded: LoadedShow) -> dict[str, Any]:
    """Return the settings with which another process listens or plays, as plain values."""
    return {
        "music": None if sound.path is None else str(sound.path.resolve()),
        "device": sound.device,
        "channels": sound.channels,
        "output": sound.output,
        "one_at": loaded.patch.music.first_downbeat if sound.from_patch else None,
        "tracker": loaded.patch.clock.tracker,
        "metres": list(loaded.patch.clock.metres),
        "likely_bpm": likely_tempo(loaded.patch.clock.likely_bpm, sound.path),
    }


def make_audio(
    sound: AudioChoice,
    loaded: LoadedShow,
    show: Show,
    latencies: Latencies,
    inbox: EventQueue[ControlEvent],
    clock: Clock,
    measures: MapClock | None = None,
    *,
    begun: float | None = None,
) -> tuple[AudioSource | None, Callable[[ControlEvent], None]]:
    """Return the source of a show, and the handler for events that concern it; `measures`: the known ones of its
    music; `begun`: when music that goes on began [s of the show]."""
    if sound.music is not None:
        from live.control.audio.music_player import MusicPlayer

        one_at = loaded.patch.music.first_downbeat if sound.from_patch and begun is None else None
        output: bool | str = sound.output or True
        try:
            player = MusicPlayer(
                sound.music,
                inbox,
                clock,
                output=output,
                latency=latencies.output,
                one_at=one_at,
                begun=begun,
                analysis=make_show_analysis(sound, loaded, show, measures),
            )
        except ValueError as error:  # the named output does not exist
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
        analysis=make_show_analysis(sound, loaded, show, measures),
    )

    def to_listener(event: ControlEvent) -> None:
        listener.latency = latencies.input
        listener.handle(event)
        if isinstance(event, RestartAudio) and show.follower.on_hint is not None:
            # a restart by hand discards manual settings; only those of the patch are sent again
            show.follower.on_hint(TrackerHint("forget", event.time))
            show.seed_tracker(show.follower.on_hint)

    return listener, to_listener


class SessionAudio:
    """Audio source of a running show, if there is one. Thread: the show's."""

    def __init__(
        self, sound: AudioChoice, loaded: LoadedShow, show: Show, latencies: Latencies, inbox: EventQueue[ControlEvent],
        clock: SystemClock, *, lifeline: SupervisorLink | None, resumed: ResumeState | None,
    ) -> None:  # fmt: skip
        """Make the source without starting it; raise PersonError if that fails."""
        self._sound = sound
        self._measures: MapClock | None = None
        self._remote: AudioClient | None = None
        self.source: AudioSource | None
        """The source; None for a show without audio."""
        self.handle: Callable[[ControlEvent], None]
        """Handler for events that concern the audio."""
        self._supervised = lifeline is not None
        there = None if lifeline is None else lifeline.sound
        if there is None or (sound.file is None and sound.device is None):
            self._measures = make_map_clock(sound, show.patch)
            begun = None if resumed is None else resumed.audio_start
            self.source, self.handle = make_audio(
                sound, loaded, show, latencies, inbox, clock, self._measures, begun=begun
            )
            return
        plan = audio_plan(sound, loaded)
        self._remote = AudioClient(there, plan, show, latencies, inbox, clock, resumed=resumed)
        self.source, self.handle = self._remote, self._remote.handle
        self.update_patch(show.patch)

    @property
    def input_source(self) -> AudioSource | None:
        """The source if it is an input device, else None."""
        return self.source if self._sound.device is not None else None

    @property
    def level(self) -> float | None:
        """RMS level of the input device; None without one."""
        return getattr(self.source, "level", None)

    @property
    def start_time(self) -> float | None:
        """When the music of a supervised show began [s of the show]; None for other audio."""
        if self._remote is not None:
            return self._remote.start_time
        return getattr(self.source, "began", None) if self._supervised else None

    def start(self) -> None:
        """Start to listen or to play; raise PersonError if that fails."""
        if self.source is None:
            return
        try:
            self.source.start()
        except PersonError:
            raise
        except Exception as error:  # PortAudioError; its class exists only with PortAudio installed
            raise device_error(error, "--audio", self._sound.device) from None

    def update_patch(self, patch: Patch) -> None:
        """Follow the measure lines of an edited patch, if its music plays."""
        if not self._sound.from_patch:
            return
        if self._measures is not None:
            self._measures.replace(patch.music.measures)
        if self._remote is not None:
            self._remote.set_measures(patch.music.measures)

    def frame(self) -> None:
        """Receive the audio process' messages, before each frame."""
        if self._remote is not None:
            self._remote.frame()

    def silence(self) -> None:
        """Stop the audio process, because another machine leads."""
        if self._remote is not None:
            self._remote.silence()

    def stop(self) -> None:
        """Stop and free the device."""
        if self.source is not None:
            self.source.stop()


def start_tempo(options: LaunchOptions, loaded: LoadedShow, sound: AudioChoice) -> float | None:
    """Return the starting tempo [bpm]; None if the patch's music is options, which has its own tempo and downbeat."""
    if options.is_practice:
        return practice_tempo(options, loaded)
    if options.bpm is not None:
        return options.bpm
    if options.midi_file is not None:
        return min(max(read_song(options.midi_file).tempo, SLOWEST), FASTEST)
    return None if sound.from_patch else loaded.patch.clock.bpm
