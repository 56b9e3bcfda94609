"""Effect of captured and tracked performers on agents: obstacles, attractors, repulsors."""

from typing import TYPE_CHECKING, Final

import numpy as np

from live.control.events.elements import PlaceElement
from live.control.events.groups import Performer
from live.show.capture.performer import HOLD_S, CapturedPerformer
from live.show.stages.now import Now

if TYPE_CHECKING:
    from live.show.group.group_motion import GroupMotion

ATTRACT_INTERVAL_TICKS: Final = 8
"""Ticks between updates of an attractor's position."""
MAX_ATTRACT_MEASURES: Final = 1024.0
"""Duration of an attractor [measures]; it ends earlier when the performer's data stop."""
SOURCE: Final = "mocap"


class PerformerForces:
    """Effects of all performers of one show. Thread: the show's."""

    def __init__(self, motion: "GroupMotion") -> None:
        self._motion = motion
        self._tick = 0

    def tick(self) -> None:
        """Count one tick."""
        self._tick += 1

    def update(self, captured: CapturedPerformer, now: Now) -> None:
        """Update a performer's obstacle and attractor."""
        time = now.time
        source = f"{SOURCE} {captured.section.name}"
        there = time - captured.last_time <= HOLD_S
        x, z = captured.position(time) if there and (captured.obstacle or captured.attract) else (0.0, 0.0)
        if there and captured.obstacle and not captured.is_danced:
            self._motion.performers.track(Performer(time=time, source=SOURCE, name=captured.section.name, x=x, z=z))
        sign = np.sign(captured.attract) if there else 0.0
        elements = self._motion.elements
        if sign != captured.attraction_sign:
            elements.end_source(source, now.beat)
            captured.attraction_sign = sign
        if sign and self._tick % ATTRACT_INTERVAL_TICKS == 0:
            event = PlaceElement(
                time=time, source=source, kind="attract" if sign > 0.0 else "repel", points=((x, z),),
                strength=abs(captured.attract), measures=MAX_ATTRACT_MEASURES, group=captured.attracts, drag=True,
            )  # fmt: skip
            elements.handle(event, now)
