"""Floor: how large the stage is now. What steers takes a new size at once; the border that is seen moves there.

Nobody is put anywhere: agents are bent to the new edges, and dancers come after them with the steps that they have.

Stage set: what a patch puts on the stage, round things and walls, and what becomes of it with an edited patch.

Stage steering: what a patch says of its stage's gates, and of how agents are steered on it.
"""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.crowd.agent_state import Steering
from live.agents.crowd.obstacles import Surroundings
from live.agents.entrances.gate import Gate, wings
from live.base.errors import PersonError
from live.base.stage_snapshot import FLOOR_MARGIN, StageView
from live.show.patch.patch import Patch
from live.show.patch.section_stage import ObstacleSection, StageSection

Float64 = npt.NDArray[np.float64]

SMALLEST: Final = 2.0
"""No stage is narrower or shallower than this [m], as in the patch."""
LARGEST: Final = 2.0
"""Nor more than so many times as large as the patch's; and of the floor that is drawn around that ..."""
DARK: Final = 0.5
"""... at least so much [m] stays outside."""
ROOM: Final = 0.8
"""Each dancer needs so much of it [m²]."""
MEASURES: Final = 2.0
"""Measures in which the border comes in, or half of them to go out: measures that are decided already end first ..."""
PACE: Final = 0.12
"""... and no more of it than this [m] in a beat on the average: about as fast as steps travel."""


class Floor:
    """The size of one show's stage. Call `resize` for events and `tick` once a tick."""

    def __init__(self, stage: StageSection) -> None:
        self._patch = np.array([stage.width / 2, stage.depth / 2])
        self.half: Float64 = self._patch.copy()
        """Half width and half depth [m] as whatever steers takes them, shape (2,): the same array as long as the show
        lasts."""
        self.border: Float64 = self._patch.copy()
        """The same of what is seen."""
        self._from, self._began, self._ends = self._patch.copy(), -math.inf, -math.inf

    @property
    def largest(self) -> Float64:
        """Half width and half depth [m] that can be asked for, shape (2,)."""
        return np.asarray(np.minimum(LARGEST * self._patch, self._patch + (FLOOR_MARGIN - DARK)))

    @property
    def fitting(self) -> Float64 | None:
        """Half width and half depth [m] into which what the patch has made must be fitted; None: it has its room."""
        return None if (self.half >= self._patch).all() else self.half.copy()

    def resize(self, width: float, depth: float, *, dancers: int, beat: float, beats_per_measure: float) -> bool:
        """The stage shall have this `width` and `depth` [m] from `beat` on; False if it has.

        PersonError if that is more floor than there is, or less than so many `dancers` need.
        """
        half = np.array([width / 2, depth / 2])
        if (half > self.largest + 1e-9).any() or not (half >= SMALLEST / 2 - 1e-9).all():
            most = 2.0 * self.largest
            raise PersonError(
                f"the stage cannot be {width:g} x {depth:g} m", f"from 2 x 2 to {most[0]:g} x {most[1]:g} m of it can"
            )
        if width * depth < ROOM * dancers and (half < self._patch).any():
            raise PersonError(
                f"{dancers} dancers have no room on {width:g} x {depth:g} m", f"they need {ROOM * dancers:.1f} m²"
            )
        if (half == self.half).all():
            return False
        self._from[:] = self.border
        far = np.abs(half - self.border).max()
        least = MEASURES * beats_per_measure * (1.0 if (half < self.border).any() else 0.5)
        self._began, self._ends = beat, beat + max(least, float(far) / PACE)
        self.half[:] = half
        return True

    def tick(self, beat: float) -> None:
        """The border moves on to where it is at `beat`: gently at the beginning and at the end."""
        if beat >= self._ends:
            self.border[:] = self.half
            return
        share = max(beat - self._began, 0.0) / (self._ends - self._began)
        self.border[:] = self._from + (self.half - self._from) * (share * share * (3.0 - 2.0 * share))


def furnish(surroundings: Surroundings, item: ObstacleSection) -> None:
    """Put up an item of the set."""
    if item.wall_to is not None:
        surroundings.put_wall(item.name, *item.at, *item.wall_to)
    else:
        surroundings.put_obstacle(item.name, *item.at, item.radius)


def refurnish(surroundings: Surroundings, old: Iterable[ObstacleSection], new: Iterable[ObstacleSection]) -> None:
    """Change what the two sets have otherwise; what was moved live and is the same in both stays where it is."""
    kept = {item.name: item for item in old}
    for item in new:
        before = kept.pop(item.name, None)
        if before is not None and (before.wall_to is None) != (item.wall_to is None):
            surroundings.remove(item.name)
        if item != before:
            furnish(surroundings, item)
    for name in kept:
        surroundings.remove(name)


def show_set(surroundings: Surroundings, view: StageView) -> None:
    """Copy what stands on the stage into the snapshot."""
    view.wall_count = min(surroundings.wall_count, len(view.wall))
    if view.wall_count:
        view.wall[: view.wall_count] = surroundings.walls[: view.wall_count]
    view.obstacle_count = min(surroundings.obstacle_count, len(view.obstacle))
    if view.obstacle_count:
        view.obstacle[: view.obstacle_count, :3] = surroundings.obstacles[: view.obstacle_count, :3]
        view.obstacle[: view.obstacle_count, 3] = 1.0


def gates_of(patch: Patch, half_width: float, half_depth: float) -> tuple[Gate, ...]:
    """The gates of a patch on a stage of these half sizes [m]; the usual wings if it names none."""
    named = tuple(
        Gate.at_edge(gate.name, gate.at, gate.width, half_width=half_width, half_depth=half_depth)
        for gate in patch.gate
    )
    return named or wings(half_width, half_depth)


def steering_of(patch: Patch) -> Steering:
    """The parameters of a patch's steering."""
    section = patch.steering
    return Steering(
        half_width=patch.stage.width / 2,
        half_depth=patch.stage.depth / 2,
        avoidance=section.avoidance,
        acceleration=section.acceleration,
        turn_rate=math.radians(section.turn_deg_s),
        d_s=section.near,
        d_f=section.far,
    )
