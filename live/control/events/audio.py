"""Events about sound: what the music is like, and what is asked of the devices that hear and play it."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class MusicHeard(ControlEvent):
    """What one beat of the music was like; told once for each beat that is heard."""

    beat_time: float
    """When the beat began [s of the show]."""
    loudness: float
    """0 to 1 in the range that this room has shown so far."""
    density: float
    """Onsets per beat."""
    brightness: float
    """0 to 1: where the spectrum's centre lies in the range shown so far."""
    low: float
    """0 to 1: the bass, likewise."""
    build: float
    """0 to 1: how far a build-up has come."""
    drop: bool = False
    """Whether the bass came back with this beat, after a build-up or a break."""
    loudness_db: float = -120.0
    """The same loudness [dB under full scale], K-weighted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestartAudio(ControlEvent):
    """The sound device is closed and opened again, by hand."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseAudio(ControlEvent):
    """Another sound device is listened to, or other channels of it."""

    device: str = ""
    """Its name or a part of it; empty: the one there is."""
    channels: str = ""
    """As for `--audio-channel`: "3", "5,6" or "all"; empty: as they are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetClick(ControlEvent):
    """The players' click goes on; or off, and is heard only while somebody counts in."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SetLatency(ControlEvent):
    """A delay of the venue is set by hand."""

    what: str
    """"input", "output", "display" or "projector"."""
    seconds: float
