"""How soon an attractor is seen: two shows that are alike but for one OSC packet, and when they begin to differ."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
from pythonosc.osc_message_builder import OscMessageBuilder

from bench._locomotion_run import ENGINE, FPS, engine_of, show_for
from bench._locomotion_scenes import BPM, Take, stage
from live.base.stage_snapshot import StageView
from live.control.events.event import ControlEvent
from live.control.osc.osc_codec import decode
from live.control.registry.registry import REGISTRY
from live.motion.editing.foot_correction import ANKLES

Float64 = npt.NDArray[np.float64]

SETTLED_S: Final = 8.0
"""So long [s] everybody dances before the packet comes: around an attractor first, which ends in half that time."""
WATCHED_S: Final = 6.0
COURSE: Final = 0.02
"""An agent has changed its course when its velocity differs by this [m/s]."""
STEP: Final = 0.05
"""A dancer has when a foot is set down so far [m] from where it would have stood."""


@dataclass(frozen=True, slots=True)
class Response:
    """Frames to the agents' change of course, beats to the dancers': of the median and of the last agent."""

    agent_frames: float
    last_agent_frames: float
    step_beats: float
    last_step_beats: float


def packet(x: float, z: float) -> bytes:
    """The OSC message that throws an attractor for two measures."""
    builder = OscMessageBuilder("/dance/attract")
    for value in (x, z, 1.0, 2.0):
        builder.add_arg(value, "f")
    return bytes(builder.build().dgram)


def responses(seed: int, moments: int) -> list[Response]:
    """For packets that come at `moments` places spread over a measure."""
    plain = _danced(seed, None)
    delays = np.arange(moments) / moments * 4.0 * 60.0 / BPM
    return [_compare(plain, _danced(seed, SETTLED_S + delay), SETTLED_S + delay) for delay in delays]


def _danced(seed: int, thrown: float | None) -> tuple[Float64, Float64]:
    """Velocities of the agents (F, A, 2) and standing feet of the dancers (F, A, 2, 2) in every picture; NaN for a foot
    that does not stand."""
    loaded = stage()
    show = show_for(ENGINE, Take("thrown", seed, 0.0), loaded.patch, loaded.graph)
    engine, clock, inbox = engine_of(show)
    courses, feet = [], []

    def picture(view: StageView) -> None:
        courses.append(show.state.velocity.astype(np.float64))
        standing = show.dancers.contact(show.span.fraction(view.beat))
        ankles = view.joint_position[:, ANKLES][..., (0, 2)].astype(np.float64)
        feet.append(np.where(standing[..., None], ankles, np.nan))

    _put(inbox, packet(-3.0, 1.0), 0.0)
    for frame in range(int((SETTLED_S + WATCHED_S + 4.0 * 60.0 / BPM) * FPS)):
        now = frame / FPS
        clock.set(now)
        if thrown is not None and now >= thrown:
            _put(inbox, packet(4.0, -2.0), now)
            thrown = None
        engine.frame(picture)
    return np.stack(courses), np.stack(feet)


def _put(inbox: object, datagram: bytes, now: float) -> None:
    for message in decode(memoryview(datagram)):
        event = REGISTRY.call(message.address, message.arguments, now, "osc")
        assert isinstance(event, ControlEvent)
        inbox.put(event)  # type: ignore[attr-defined]


def _compare(plain: tuple[Float64, Float64], other: tuple[Float64, Float64], thrown: float) -> Response:
    first = int(np.ceil(thrown * FPS - 1e-9))
    frames = []
    for one, two, bar in ((plain[0], other[0], COURSE), (plain[1], other[1], STEP)):
        differs = np.hypot(*np.moveaxis(two[first:] - one[first:], -1, 0)) > bar  # never for a foot in the air
        differs = differs.any(axis=2) if differs.ndim > 2 else differs
        frames.append(np.where(differs.any(axis=0), differs.argmax(axis=0) + 1.0, np.nan))
    agent, step = frames[0], (frames[1] - 1.0) / FPS * BPM / 60.0
    return Response(
        float(np.nanmedian(agent)),
        float(np.nanmax(agent)),
        float(np.nanmedian(step)),
        float(np.nanmax(step)),
    )
