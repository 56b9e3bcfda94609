"""Stage set: what a patch puts on the stage, round things and walls, and what becomes of it with an edited patch."""

from collections.abc import Iterable

from live.agents.crowd.surroundings import Surroundings
from live.show.sections.stage import ObstacleSection


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
