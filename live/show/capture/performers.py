"""Performers: real dancers on the stage, where a tracker says that they are: to the agents they are obstacles."""

import math
from typing import Final

from live.agents.crowd.obstacles import Surroundings
from live.base.stage_snapshot import StageView
from live.control.events.events import Performer

LOST_S: Final = 2.0
"""A real dancer of whom nothing is heard for so long [s] has left."""
FASTEST: Final = 6.0
"""Nobody dances faster than this [m/s]: such leaps are faults of the tracking."""
PERFORMER: Final = "performer "
"""Real dancers' names among the obstacles begin so."""


class Performers:
    """Who is there, among the obstacles of `surroundings`."""

    def __init__(self, surroundings: Surroundings, radius: float) -> None:
        """Each is a circle of this radius [m]."""
        self._surroundings, self._radius = surroundings, radius
        self._last: dict[str, Performer] = {}

    def track(self, event: Performer) -> bool:
        """Take up where a real dancer is; False if there are too many obstacles already."""
        last = self._last.get(event.name)
        velocity = (0.0, 0.0)
        if last is not None and event.time - last.time > 1e-3:
            since = event.time - last.time
            velocity = ((event.x - last.x) / since, (event.z - last.z) / since)
            fast = max(math.hypot(*velocity) / FASTEST, 1.0)
            velocity = (velocity[0] / fast, velocity[1] / fast)
        taken = self._surroundings.put_obstacle(_name(event.name), event.x, event.z, self._radius, *velocity)
        if taken:
            self._last[event.name] = event
        return taken

    def tick(self, time: float) -> None:
        """Forget those of whom nothing is heard at `time` [s] any more."""
        if not self._last:
            return
        for name in [name for name, event in self._last.items() if time - event.time > LOST_S]:
            del self._last[name]
            self._surroundings.remove(_name(name))

    def show(self, view: StageView) -> None:
        """Say in the snapshot which of its obstacles are real dancers: they are not drawn."""
        if self._last:
            for row, name in enumerate(self._surroundings.obstacle_names[: view.obstacle_count]):
                view.obstacle[row, 3] = not name.startswith(PERFORMER)


def _name(performer: str) -> str:
    """The name of a real dancer among the obstacles: no item of the set is called so."""
    return PERFORMER + performer
