"""Dancing a scene for the bench: as the engine does it, and in the two naive ways that it is held against."""

import math
from collections import Counter, deque
from collections.abc import Callable, Iterable
from typing import Final

import numpy as np

from bench._locomotion_figures import Figures, Watch
from bench._locomotion_scenes import Take, changed, events_of, stage
from live.base.event_queue import EventQueue
from live.base.stage_snapshot import StageView
from live.clock.time_source import ManualClock
from live.control.events.events import BeatHeard, ControlEvent
from live.graph.motion_graph import MotionGraph
from live.show.assembly import assemble
from live.show.engine import Engine
from live.show.patch.patch import Patch
from live.show.show import Show
from live.show.view.status import Status

FPS: Final = 60.0
ENGINE: Final = "engine"
SLIDING: Final = "sliding"
"""The clips are played, and the characters pulled along where steering goes."""
UNCORRECTED: Final = "uncorrected"
"""The best steps, without anything that brings them where they should end."""

DRIFT: Final = 0.08
DRIFT_S: Final = 30.0
"""The tempo goes up and down by this share, once in so many seconds."""


def patch_for(way: str, patch: Patch) -> Patch:
    """The patch with which a way is danced."""
    if way == SLIDING:
        return changed(patch, motion={"foot_lock": False}, locomotion={"correction_m": 0.0, "obedience": 0.0})
    if way == UNCORRECTED:
        return changed(patch, locomotion={"correction_m": 0.0, "turn_deg": 0.0, "obedience": 0.0})
    return patch


def show_for(way: str, take: Take, patch: Patch, graph: MotionGraph) -> Show:
    """A fresh show for a take."""
    show = assemble(patch_for(way, patch), graph, seed=take.seed)
    if way == SLIDING:
        _free_agents(show)
    return show


def dance(
    take: Take,
    way: str = ENGINE,
    *,
    patch: Patch | None = None,
    graph: MotionGraph | None = None,
    heard: Iterable[ControlEvent] = (),
    watch: Callable[[Show, StageView], None] | None = None,
) -> Figures:
    """Dance one take in one way; `heard`: events besides the scene's, in order; `watch` sees every picture, too."""
    loaded = stage()
    show = show_for(way, take, patch or loaded.patch, graph or loaded.graph)
    figures = Watch(show)

    def picture(view: StageView) -> None:
        if way == SLIDING:
            _slide(show, view, engine.ticks.time)
        figures.picture(view)
        if watch is not None:
            watch(show, view)

    engine, clock, inbox = engine_of(show)
    waiting = deque(sorted([*events_of(take), *heard], key=lambda event: event.time))
    for frame in range(int(take.seconds * FPS)):
        now = frame / FPS
        clock.set(now)
        while waiting and waiting[0].time <= now:
            inbox.put(waiting.popleft())
        engine.frame(picture)
    return figures.figures()


def engine_of(show: Show) -> tuple[Engine, ManualClock, EventQueue[ControlEvent]]:
    """The engine's own frame loop on a clock that is set by hand."""
    clock, inbox = ManualClock(), EventQueue[ControlEvent]()
    status = Status(show, rejected=Counter, memory=lambda: 0.0)
    return Engine(show, clock=clock, inbox=inbox, status=status, stall=math.inf), clock, inbox


def drifting_beats(seconds: float, bpm: float) -> list[ControlEvent]:
    """What a tracker says of music whose tempo drifts: each beat is named half a beat before it falls."""
    beats: list[ControlEvent] = []
    time, number = 0.0, 0
    while time < seconds:
        period = 60.0 / (bpm * (1.0 + DRIFT * math.sin(2.0 * math.pi * time / DRIFT_S)))
        beats.append(
            BeatHeard(
                time=max(0.0, time - 0.5 * period),
                source="audio",
                beat_time=time,
                period=period,
                confidence=1.0,
                beat=number % 4,
                beats_per_measure=4,
            )
        )
        time, number = time + period, number + 1
    return beats


def _free_agents(show: Show) -> None:
    """Steering goes its own way, whatever dancers do."""
    advance = show.motion.advance

    def free(time: float, **_: object) -> None:
        advance(time, reference=show.state.position, reference_velocity=show.state.velocity)

    show.motion.advance = free  # type: ignore[method-assign]


def _slide(show: Show, view: StageView, ticked: float) -> None:
    """Put every body where its agent is now."""
    at = show.state.position + (view.time - ticked) * show.state.velocity
    way = at - view.joint_position[:, 0][:, (0, 2)]
    view.joint_position[:, :, 0] += way[:, None, 0].astype(np.float32)
    view.joint_position[:, :, 2] += way[:, None, 1].astype(np.float32)
