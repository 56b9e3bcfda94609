"""Real dancers on the stage as obstacles (`Performers`), and stage bounds for dancers in a canon (`Edges`).

A dancer who repeats a performer's path from another place may be led over the border. As in `keep_on_stage` of
`live.agents.crowd.bounds`, the speed towards an edge is limited so that it is reached in a quarter of a second at the
earliest; motion along the edge is unchanged. The removed displacement is not given back: the path continues with an
offset, so it is bent at the border only.
"""

import math
from typing import Final

import numpy as np

from live.agents.crowd.contact_kernels import EDGE_TIME
from live.agents.crowd.obstacles import Surroundings
from live.base.arrays import Bool, Float64
from live.base.stage_snapshot import StageView
from live.control.events.events import Performer

LOST_S: Final = 2.0
"""Time [s] without data after which a real dancer counts as gone."""
MAX_SPEED: Final = 6.0
"""Speed limit [m/s]; faster jumps are tracking errors."""
OBSTACLE_PREFIX: Final = "performer "
"""Prefix of real dancers' names among the obstacles."""


class Performers:
    """Tracked real dancers among the obstacles of `surroundings`."""

    def __init__(self, surroundings: Surroundings, radius: float) -> None:
        """`radius` [m] of each dancer's circle."""
        self._surroundings, self._radius = surroundings, radius
        self._last: dict[str, Performer] = {}

    def track(self, event: Performer) -> bool:
        """Update the position of a real dancer; False if there are too many obstacles already."""
        last = self._last.get(event.name)
        velocity = (0.0, 0.0)
        if last is not None and event.time - last.time > 1e-3:
            since = event.time - last.time
            velocity = ((event.x - last.x) / since, (event.z - last.z) / since)
            fast = max(math.hypot(*velocity) / MAX_SPEED, 1.0)
            velocity = (velocity[0] / fast, velocity[1] / fast)
        taken = self._surroundings.set_obstacle(_name(event.name), event.x, event.z, self._radius, *velocity)
        if taken:
            self._last[event.name] = event
        return taken

    def tick(self, time: float) -> None:
        """Remove dancers without data for LOST_S at `time` [s]."""
        if not self._last:
            return
        for name in [name for name, event in self._last.items() if time - event.time > LOST_S]:
            del self._last[name]
            self._surroundings.remove(_name(name))

    def mark_obstacles(self, view: StageView) -> None:
        """Mark the snapshot's obstacles that are real dancers: they are not drawn."""
        if self._last:
            for row, name in enumerate(self._surroundings.obstacle_names[: view.obstacle_count]):
                view.obstacle[row, 3] = not name.startswith(OBSTACLE_PREFIX)


def _name(performer: str) -> str:
    """Return the obstacle name of a real dancer; no item of the set has such a name."""
    return OBSTACLE_PREFIX + performer


MAX_RETURN_SPEED: Final = 1.2
"""Maximum speed [m/s] of the return from beyond an edge, after the stage has become smaller: a walk."""


class CanonBounds:
    """Positions of one performer's dancers at the last tick, and their limits. Thread: the show's."""

    def __init__(self, half: Float64) -> None:
        """`half` (2,): half width and half depth of the stage [m]; the show updates this array in place."""
        self._half = half
        self.last_position: Float64 = np.zeros((0, 2))
        """Position of each dancer at the last tick [m], (n, 2)."""
        self._time = 0.0
        self._floor: tuple[float, ...] = ()
        self._mirrored = False

    def correction(self, positions: Float64, time: float) -> Float64:
        """Return the displacement (n, 2) [m] that keeps dancers inside whose paths lead to `positions` (n, 2) [m] at
        `time` [s]."""
        passed = time - self._time
        if passed <= 0.0:
            return np.zeros_like(positions)
        speed, half = (positions - self.last_position) / passed, self._half
        most = (half - self.last_position) / EDGE_TIME
        least = -(half + self.last_position) / EDGE_TIME
        kept = np.minimum(np.maximum(speed, np.minimum(least, MAX_RETURN_SPEED)), np.maximum(most, -MAX_RETURN_SPEED))
        return np.asarray((kept - speed) * passed)

    def update(
        self, positions: Float64, time: float, floor: tuple[float, ...], in_canon: Bool, *, mirrored: bool = False
    ) -> Float64:
        """Advance one tick: as `correction`, and store the result; only dancers `in_canon` (n,) are moved.

        `floor`: placement of the performer's floor; after a change positions are only clipped to the stage, because it
        acts at once. `mirrored`: whether paths are mirrored; after a change they continue from the last positions.
        """
        if floor != self._floor:
            way = np.clip(positions, -self._half, self._half) - positions
        elif mirrored != self._mirrored:
            way = self.last_position - positions
        else:
            way = self.correction(positions, time)
        way[~in_canon] = 0.0
        self.last_position, self._time, self._floor, self._mirrored = positions + way, time, floor, mirrored
        return way

    def add(self, place: Float64) -> None:
        """Add dancers at `place` (n, 2) [m]."""
        self.last_position = np.concatenate([self.last_position, place])

    def keep(self, kept: Bool) -> None:
        """Keep only these dancers, (n,)."""
        self.last_position = self.last_position[kept]
