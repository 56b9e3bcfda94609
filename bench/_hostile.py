"""Frames of 50 dancers in scenes that nobody would rehearse: wild tempo, floods, who leaves, a stage that shrinks.

CPU time of each frame without drawing. Within a frame the clock goes on as the processor works, as live: a flood of
events waits, it does not stall the frame.
"""

import gc
import time
from collections import Counter
from collections.abc import Callable
from typing import Final

import numpy as np
import numpy.typing as npt

from bench._show import crowd
from live.base.event_queue import EventQueue
from live.cli.bench import Row
from live.clock.time_source import ManualClock
from live.control.events import events
from live.control.events.events import ControlEvent
from live.show.engine import Engine
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.view.status import Status

FPS: Final = 60
DANCERS: Final = 50
WARM_S: Final = 3.0
"""So long [s] nothing happens, and nothing counts: the frames that load."""
LATE_MS: Final = 1e3 / FPS

Scene = Callable[[int, float, Show], list[ControlEvent]]
"""The events of the frame of this number at this time [s], counted from WARM_S on."""


class WorkingClock(ManualClock):
    """Moves from frame to frame as it is told, and within a frame with the thread's CPU time."""

    begun: int | None = None

    def now(self) -> float:
        """Seconds, with the work of this frame."""
        spent = 0 if self.begun is None else time.thread_time_ns() - self.begun
        return super().now() + spent * 1e-9


def _tempo(frame: int, now: float, show: Show) -> list[ControlEvent]:
    """From 60 to 180 bpm within one beat, halved, doubled, stopped, "this is the one"; every two seconds."""
    told: dict[int, ControlEvent] = {
        0: events.SetTempo(time=now, source="bench", tempo=60.0),
        30: events.SetTempo(time=now, source="bench", tempo=180.0),
        60: events.ScaleTempo(time=now, source="bench", factor=0.5),
        75: events.ScaleTempo(time=now, source="bench", factor=2.0),
        90: events.SourceChanged(time=now, source="midi", state="stopped"),
        100: events.One(time=now, source="bench"),
    }
    thrown = [
        events.PlaceElement(
            time=now, source="bench", kind="attract", points=((3.0 * (-1) ** (frame // 180), 0.5),), measures=2.0
        )
    ]
    return [*([told[frame % 120]] if frame % 120 in told else []), *thrown * (frame % 180 == 0)]


def _flood(frame: int, now: float, show: Show) -> list[ControlEvent]:
    """500 attractors are dragged elsewhere in every frame."""
    places = np.random.default_rng(frame).uniform(-20.0, 20.0, (500, 2)).tolist()
    return [
        events.PlaceElement(
            time=now, source=f"phone {phone}", kind="attract", points=((x, z),), measures=1.0, drag=True, strength=5.0
        )
        for phone, (x, z) in enumerate(places)
    ]


def _voices(frame: int, now: float, show: Show) -> list[ControlEvent]:
    """The same by 500 of an audience."""
    places = np.random.default_rng(frame).uniform(-20.0, 20.0, (500, 2)).tolist()
    return [
        events.PlaceElement(
            time=now, source=f"phone {phone}", kind="attract", points=((x, z),), measures=2.0, fair=True, drag=True
        )
        for phone, (x, z) in enumerate(places)
    ]


def _leave(frame: int, now: float, show: Show) -> list[ControlEvent]:
    """Dancers leave in mid-step, one after another, and others come."""
    gone = [events.Leave(time=now, source="bench", dancers=str(1 + frame // 45 % 40))] * (frame % 45 == 0)
    return [*gone, *[events.Enter(time=now, source="bench", count=2.0)] * (frame % 150 == 20)]


def _shrink(frame: int, now: float, show: Show) -> list[ControlEvent]:
    """The stage shrinks to three fifths by seven tenths, and grows again."""
    width, depth = show.patch.stage.width, show.patch.stage.depth
    small = frame // 240 % 2 == 0
    size = (0.6 * width, 0.7 * depth) if small else (width, depth)
    return [events.SetStage(time=now, source="bench", width=size[0], depth=size[1])] * (frame % 240 == 0)


def _shrink_formation(frame: int, now: float, show: Show) -> list[ControlEvent]:
    """The same while all dance in a circle."""
    circle = [events.Evolve(time=now, source="bench", formation="circle", measures=2.0)] * (frame == 0)
    return [*circle, *_shrink(frame - 120, now, show)]


SCENES: Final[dict[str, Scene]] = {
    "nothing": lambda frame, now, show: [],
    "tempo from 60 to 180, halved, doubled, stopped": _tempo,
    "500 attractors changed in every frame": _flood,
    "500 voices raised in every frame": _voices,
    "dancers removed in mid-step": _leave,
    "the stage shrinks and grows": _shrink,
    "the stage shrinks and grows under a formation": _shrink_formation,
}


def rows(loaded: LoadedShow, seconds: float) -> list[Row]:
    """The longest frame of each scene, and how many are late."""
    found = []
    for name, scene in SCENES.items():
        spent = _measured(loaded, scene, WARM_S + seconds)
        peers = {"median [ms]": float(np.median(spent)), "late": float((spent > LATE_MS).sum())}
        found.append(Row(f"50 dancers, {name}: longest frame", float(spent.max()), "ms", LATE_MS, peers=peers))
    return found


def _measured(loaded: LoadedShow, scene: Scene, seconds: float) -> npt.NDArray[np.float64]:
    """CPU time of the frames [ms] but for the first WARM_S."""
    show = crowd(DANCERS, loaded)
    clock, inbox = WorkingClock(), EventQueue[ControlEvent]()
    engine = Engine(show, clock=clock, inbox=inbox, status=Status(show, rejected=Counter, memory=lambda: 0.0))
    first, count = int(WARM_S * FPS), int(seconds * FPS)
    spent = np.zeros(count)
    gc.collect()
    gc.freeze()
    gc.disable()
    try:
        for frame in range(count):
            clock.set(frame / FPS)
            for event in scene(frame - first, frame / FPS, show) if frame >= first else ():
                inbox.put(event)
            clock.begun = begin = time.thread_time_ns()
            engine.frame(lambda view: None)
            gc.collect(0)
            spent[frame] = (time.thread_time_ns() - begin) * 1e-6
            clock.begun = None
    finally:
        gc.enable()
        gc.unfreeze()
    return spent[first:]
