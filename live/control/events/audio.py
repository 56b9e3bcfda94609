"""Commands of the sound devices and the venue's latencies, and features of the music."""

from dataclasses import dataclass
from typing import Annotated

from live.control.events.event import ControlEvent
from live.control.registry.command import command
from live.control.registry.control import Argument


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


@command("/dance/audio/restart", "operator")
class RestartAudio(ControlEvent):
    """Closes the sound device and opens it again; the dance continues."""


@command("/dance/audio/device", "operator", required=("device",))
@command(
    "/dance/audio/channels", "operator", "Selects other channels of the sound input.",
    fixed={"device": ""}, required=("channels",),
)  # fmt: skip
class ChooseAudio(ControlEvent):
    """Selects another sound input."""

    device: Annotated[str, Argument.text("the device's name or a part of it, see `live devices`")] = ""
    """Empty: unchanged."""
    channels: Annotated[str, Argument.label("which of its channels: 3, or 5,6, or all", default="1,2")] = ""
    """Empty: unchanged."""


@command("/dance/click", "musician", value=1, start=(True,))
class SetClick(ControlEvent):
    """The players' click (`live play --click`)."""

    on: Annotated[bool, Argument.switch("1: every beat, 0: only during a count-in")] = True


_DELAY = Argument.number("latency", 0, 500, "ms")


@command(
    "/dance/latency/input", "operator", "Latency of sound from the loudspeakers to the input.",
    value=1, fixed={"what": "input"},
)  # fmt: skip
@command(
    "/dance/latency/output", "operator", "Latency of sound from the output to the listeners.",
    value=1, fixed={"what": "output"},
)  # fmt: skip
@command(
    "/dance/latency/display", "operator", "Latency of the picture to the display.",
    value=1, fixed={"what": "display"}, arguments={"milliseconds": _DELAY},
)  # fmt: skip
@command(
    "/dance/latency/projector", "operator", "Additional latency of the projector.",
    value=1, fixed={"what": "projector"}, arguments={"milliseconds": _DELAY},
)  # fmt: skip
class SetLatency(ControlEvent):
    """Sets a latency of the venue."""

    what: str
    """"input", "output", "display" or "projector"."""
    milliseconds: Annotated[float, Argument.number("latency", -500, 500, "ms")]

    @property
    def seconds(self) -> float:
        """The latency [s]."""
        return self.milliseconds / 1000.0
