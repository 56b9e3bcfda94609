"""Stage set: what a patch puts on the stage, round things and walls, and what becomes of it with an edited patch."""

from collections.abc import Iterable

from live.agents.crowd.obstacles import Surroundings
from live.base.stage_snapshot import StageView
from live.show.patch.section_stage import ObstacleSection


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
