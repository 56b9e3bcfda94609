"""Stage area of a show: its size, the set (obstacles and walls), the gates and the steering parameters.

A new stage size applies to steering at once, while the drawn border moves gradually. Dancers are not displaced: agents
are steered inside the new edges, and dancers follow with their steps.
"""

import math
from collections.abc import Iterable
from typing import Final

import numpy as np

from live.agents.crowd.agent_state import Steering
from live.agents.crowd.obstacles import Surroundings
from live.agents.entrances.gate import Gate, default_gates
from live.base.arrays import Float64
from live.base.errors import PersonError
from live.base.stage_snapshot import FLOOR_MARGIN, StageView
from live.show.patch.patch import Patch
from live.show.patch.section_stage import ObstacleSection, StageSection

MIN_SIZE: Final = 2.0
"""Least width and depth of a stage [m], as in the patch."""
MAX_SCALE: Final = 2.0
"""Largest size of a stage, relative to the patch's."""
OUTER_MARGIN: Final = 0.5
"""Least margin of the drawn floor around the stage [m]."""
AREA_PER_DANCER: Final = 0.8
"""Least area per dancer [m²]."""
RESIZE_MEASURES: Final = 2.0
"""Least time in which the border moves inwards [measures], so that measures decided already end first. Half of that
outwards."""
MAX_BORDER_SPEED: Final = 0.12
"""Mean speed limit of the border [m per beat]: about as fast as steps travel."""


class StageArea:
    """Size of one show's stage. `resize` is called for events, `tick` once a tick."""

    def __init__(self, stage: StageSection) -> None:
        self._patch = np.array([stage.width / 2, stage.depth / 2])
        self.half: Float64 = self._patch.copy()
        """Half width and half depth for steering [m], shape (2,): the same array for the whole show."""
        self.border: Float64 = self._patch.copy()
        """Half width and half depth as drawn [m], shape (2,)."""
        self._from, self._began, self._ends, self._beat = self._patch.copy(), -math.inf, -math.inf, 0.0

    @property
    def largest(self) -> Float64:
        """Largest half width and half depth that `resize` accepts [m], shape (2,)."""
        return np.asarray(np.minimum(MAX_SCALE * self._patch, self._patch + (FLOOR_MARGIN - OUTER_MARGIN)))

    @property
    def fit_size(self) -> Float64 | None:
        """Half width and half depth [m] to which formations must be fitted, None if the patch's stage fits."""
        return None if (self.half >= self._patch).all() else self.half.copy()

    def resize(self, width: float, depth: float, *, dancers: int, beat: float, beats_per_measure: float) -> bool:
        """Set the stage's `width` and `depth` [m] from `beat` on. Returns False if nothing changes.

        Raises PersonError if the floor is too small for that, or the stage too small for so many `dancers`.
        """
        half = np.array([width / 2, depth / 2])
        if (half > self.largest + 1e-9).any() or not (half >= MIN_SIZE / 2 - 1e-9).all():
            most = 2.0 * self.largest
            raise PersonError(
                f"the stage cannot be {width:g} x {depth:g} m", f"use 2 x 2 to {most[0]:g} x {most[1]:g} m"
            )
        if width * depth < AREA_PER_DANCER * dancers and (half < self._patch).any():
            raise PersonError(
                f"{dancers} dancers have no room on {width:g} x {depth:g} m",
                f"they need {AREA_PER_DANCER * dancers:.1f} m²",
            )
        if (half == self.half).all():
            return False
        self._begin(half, beat, beats_per_measure)
        return True

    def change_patch(self, stage: StageSection, *, beats_per_measure: float) -> None:
        """Take the size of an edited patch, also if another size was set live."""
        self._patch[:] = stage.width / 2, stage.depth / 2
        self._begin(self._patch, self._beat, beats_per_measure)

    def _begin(self, half: Float64, beat: float, beats_per_measure: float) -> None:
        """Steer within `half` (2,) [m] from now on, and begin to move the border there at `beat`."""
        self._from[:] = self.border
        far = np.abs(half - self.border).max()
        least = RESIZE_MEASURES * beats_per_measure * (1.0 if (half < self.border).any() else 0.5)
        self._began, self._ends = beat, beat + max(least, float(far) / MAX_BORDER_SPEED)
        self.half[:] = half

    def tick(self, beat: float) -> None:
        """Move the border to its place at `beat`, with easing at both ends."""
        self._beat = beat
        if beat >= self._ends:
            self.border[:] = self.half
            return
        share = max(beat - self._began, 0.0) / (self._ends - self._began)
        self.border[:] = self._from + (self.half - self._from) * (share * share * (3.0 - 2.0 * share))


def place_item(surroundings: Surroundings, item: ObstacleSection) -> None:
    """Put an item of the set on the stage."""
    if item.wall_to is not None:
        surroundings.set_wall(item.name, *item.at, *item.wall_to)
    else:
        surroundings.set_obstacle(item.name, *item.at, item.radius)


def update_set(surroundings: Surroundings, old: Iterable[ObstacleSection], new: Iterable[ObstacleSection]) -> None:
    """Apply the differences between two sets. Items that are the same in both stay where they are, also if moved
    live."""
    kept = {item.name: item for item in old}
    for item in new:
        before = kept.pop(item.name, None)
        if before is not None and (before.wall_to is None) != (item.wall_to is None):
            surroundings.remove(item.name)
        if item != before:
            place_item(surroundings, item)
    for name in kept:
        surroundings.remove(name)


def show_set(surroundings: Surroundings, view: StageView) -> None:
    """Copy walls and obstacles into the drawing snapshot."""
    view.wall_count = min(surroundings.wall_count, len(view.wall))
    if view.wall_count:
        view.wall[: view.wall_count] = surroundings.walls[: view.wall_count]
    view.obstacle_count = min(surroundings.obstacle_count, len(view.obstacle))
    if view.obstacle_count:
        view.obstacle[: view.obstacle_count, :3] = surroundings.obstacles[: view.obstacle_count, :3]
        view.obstacle[: view.obstacle_count, 3] = 1.0


def gates_of(patch: Patch, half_width: float, half_depth: float) -> tuple[Gate, ...]:
    """Return the gates of a patch on a stage of these half sizes [m], or the default wings if it names none."""
    named = tuple(
        Gate.at_edge(gate.name, gate.at, gate.width, half_width=half_width, half_depth=half_depth)
        for gate in patch.gate
    )
    return named or default_gates(half_width, half_depth)


def steering_of(patch: Patch) -> Steering:
    """Return the steering parameters of a patch."""
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
