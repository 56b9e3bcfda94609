"""Performers: real dancers on the stage, where a tracker says that they are: to the agents they are obstacles.

Edges: those who repeat a captured performer from where they stand are kept on the stage, whose size is another's.

Her path, begun elsewhere, may lead over the border. There they are treated as steering treats everybody
(`keep_on_stage` of `live.agents.crowd.bounds`): nobody goes at an edge faster than she would reach it in a quarter of a
second, and along it nothing is changed. What is taken from a way is not given back: from there on she goes the same
path beside, so that it is bent at the border alone.
"""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.crowd.contact_kernels import SOFT_LANDING
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


Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

BACK: Final = 1.2
"""Who is beyond an edge, because the stage has become smaller, comes back no faster than this [m/s]: at a walk."""


class Edges:
    """Where the dancers of one performer stood at the last tick. Thread: the show's."""

    def __init__(self, half: Float64) -> None:
        """`half` (2,): half width and half depth of the stage [m], the array that the show keeps up to date."""
        self._half = half
        self.place: Float64 = np.zeros((0, 2))
        """Where each of her dancers stood [m], (n, 2)."""
        self._time = 0.0
        self._floor: tuple[float, ...] = ()
        self._mirrored = False

    def bent(self, there: Float64, time: float) -> Float64:
        """How far dancers whom their ways would take `there` (n, 2) [m] at `time` [s] are to be moved, (n, 2) [m]."""
        passed = time - self._time
        if passed <= 0.0:
            return np.zeros_like(there)
        speed, half = (there - self.place) / passed, self._half
        most = (half - self.place) / SOFT_LANDING
        least = -(half + self.place) / SOFT_LANDING
        kept = np.minimum(np.maximum(speed, np.minimum(least, BACK)), np.maximum(most, -BACK))
        return np.asarray((kept - speed) * passed)

    def settle(
        self, there: Float64, time: float, floor: tuple[float, ...], repeats: Bool, *, mirrored: bool = False
    ) -> Float64:
        """A tick: as `bent`, and that is where they stand; only those who `repeats` (n,) are moved. `floor`: how her
        floor lies on the stage; where that is another than before they are only put inside, for it acts at once.
        `mirrored`: whether her ways are; where they are turned over just now they go on from where they stood."""
        if floor != self._floor:
            way = np.clip(there, -self._half, self._half) - there
        elif mirrored != self._mirrored:
            way = self.place - there
        else:
            way = self.bent(there, time)
        way[~repeats] = 0.0
        self.place, self._time, self._floor, self._mirrored = there + way, time, floor, mirrored
        return way

    def add(self, place: Float64) -> None:
        """More dancers, who stand at `place` (n, 2) [m]."""
        self.place = np.concatenate([self.place, place])

    def keep(self, kept: Bool) -> None:
        """Only these go on, (n,)."""
        self.place = self.place[kept]
