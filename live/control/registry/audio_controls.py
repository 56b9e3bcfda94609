"""Controls of sound devices and the latencies of a venue."""

from collections.abc import Callable
from typing import Final

from live.control.events import events
from live.control.events.events import ControlEvent
from live.control.registry.control import Argument, Control


def _latency(what: str) -> Callable[..., ControlEvent]:
    def make(*, time: float, source: str, milliseconds: float) -> ControlEvent:
        return events.SetLatency(time=time, source=source, what=what, seconds=milliseconds / 1000.0)

    return make


_LATENCIES: Final = (
    ("input", -500.0, "Latency of sound from the loudspeakers to the input."),
    ("output", -500.0, "Latency of sound from the output to the listeners."),
    ("display", 0.0, "Latency of the picture to the display."),
    ("projector", 0.0, "Additional latency of the projector."),
)

AUDIO_CONTROLS: Final = (
    Control(
        "/dance/audio/restart", events.RestartAudio, (),
        "Closes the sound device and opens it again; the dance continues.", "operator",
    ),
    Control(
        "/dance/audio/device", events.ChooseAudio,
        (
            Argument("device", "text", "the device's name or a part of it, see `live devices`"),
            Argument("channels", "name", "which of its channels: 3, or 5,6, or all", default="1,2"),
        ),
        "Selects another sound input.", "operator",
    ),
    Control(
        "/dance/audio/channels", events.ChooseAudio,
        (Argument("channels", "name", "which channels of the device: 3, or 5,6, or all"),),
        "Selects other channels of the sound input.", "operator",
    ),
    Control(
        "/dance/click", events.SetClick,
        (Argument("on", "bool", "1: every beat, 0: only during a count-in", default=True),),
        "The players' click (`live play --click`).", "musician", "continuous", 1, (True,),
    ),
    *(
        Control(
            f"/dance/latency/{what}", _latency(what),
            (Argument("milliseconds", "float", "latency", "ms", low, 500.0),), words, "operator", "continuous", 1,
        )
        for what, low, words in _LATENCIES
    ),
)  # fmt: skip
