"""Events of sound: features of the music, and settings of the sound devices."""

from dataclasses import dataclass

from live.control.events.event import ControlEvent


@dataclass(frozen=True, slots=True, kw_only=True)
class MusicHeard(ControlEvent):
    """Features of one beat of the music; one event per tracked beat."""

    beat_time: float
    """Time of the beat [s of the show]."""
    loudness: float
    """0 to 1 within the range observed so far."""
    density: float
    """Onsets per beat."""
    brightness: float
    """Spectral centroid, 0 to 1 within the range observed so far."""
    low: float
    """Bass level, 0 to 1 within the range observed so far."""
    build: float
    """Progress of a build-up, 0 to 1."""
    drop: bool = False
    """Whether the bass returned with this beat, after a build-up or a break."""
    loudness_db: float = -120.0
    """The same loudness [dB under full scale], K-weighted."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestartAudio(ControlEvent):
    """The sound device is closed and opened again, on the operator's command."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChooseAudio(ControlEvent):
    """Selects another sound input, or other channels of it."""

    device: str = ""
    """Its name or a part of it; empty: unchanged."""
    channels: str = ""
    """As for `--audio-channel`: "3", "5,6" or "all"; empty: unchanged."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SetClick(ControlEvent):
    """Switches the players' click on, or off except during a count-in."""

    on: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SetLatency(ControlEvent):
    """Sets a latency of the venue."""

    what: str
    """"input", "output", "display" or "projector"."""
    seconds: float
