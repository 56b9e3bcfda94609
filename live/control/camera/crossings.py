"""Who is who after a crossing: decided by the costumes when those who crossed are apart again.

Evidence is collected first, then people are assigned all together, as trackers link pieces of tracks by appearance
(Wojke et al. 2017, "Simple online and realtime tracking with a deep association metric"); here a costume's colours are
the appearance.
"""

import itertools
import math
import warnings
from typing import Final

import numpy as np
from scipy.optimize import linear_sum_assignment

from live.base.arrays import Float64
from live.control.camera.costume import colour_difference
from live.control.camera.seen_person import NEAR, Person, people_distance

_APART: Final = 0.2
"""People whose regions' middles are farther from each other than this share of a region show their costumes."""
_FRESH: Final = 5
"""Pictures after a crossing by which it is decided who is who."""
_SURE_GAIN: Final = 0.5
"""People are exchanged if their costumes then fit better by this share of their difference."""
_LEAST_GAIN: Final = 0.06
"""Nor are they if the costumes fit better by less than this."""


def note_crossings(people: list[Person], seen: list[Person], colours: dict[int, Float64]) -> None:
    """Note who crosses whom, and decide by the costumes who is who when they are apart."""
    covering = {
        each.behind.number for each in people if each not in seen and each.behind and each.time < each.behind.time
    }
    for each in seen:
        others = [other for other in seen if other is not each]
        hiding = [other for other in others if people_distance(each, other) < NEAR]
        each.behind = min(hiding, key=lambda other: people_distance(each, other), default=None)
        close = [other for other in others if people_distance(each, other) < _APART]
        if close:
            each.crossed |= {other.number for other in close}
            each.fresh.clear()
        elif each.crossed and each.number not in covering:
            each.fresh.append(colours[each.number])
    for group in _groups(seen, people):
        if all(len(each.fresh) >= _FRESH for each in group if each in seen):
            _decide(group)


def _groups(seen: list[Person], people: list[Person]) -> list[list[Person]]:
    """Return those among `people` who crossed each other, directly or by others; of each group somebody is seen."""
    left = [each for each in seen if each.crossed]
    groups: list[list[Person]] = []
    while left:
        group = [left[0]]
        for one in group:
            group += [
                each for each in people
                if each not in group and (each.number in one.crossed or one.number in each.crossed)
            ]  # fmt: skip
        left = [each for each in left if each not in group]
        groups.append(group)
    return groups


def _decide(group: list[Person]) -> None:
    """Exchange people who took each other's place, by their costumes: those of before against those seen since.

    Who is not seen now may have lost their place to another.
    """
    seen = [index for index, each in enumerate(group) if each.fresh]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # parts that were never seen
        fresh = [np.nanmedian(group[index].fresh, axis=0) for index in seen]
    unlike = [colour_difference(one.colours, other.colours) for one, other in itertools.combinations(group, 2)]
    cost = np.nan_to_num([[colour_difference(each.colours, one) for one in fresh] for each in group])
    rows, columns = linear_sum_assignment(cost)
    gain = sum(cost[index, column] for column, index in enumerate(seen)) - cost[rows, columns].sum()
    if gain > max(_SURE_GAIN * min(unlike, default=math.inf), _LEAST_GAIN):
        taken = {int(row): seen[column] for row, column in zip(rows, columns, strict=True)}
        free = [index for index in range(len(group)) if index not in taken.values()]
        taken |= dict(zip((row for row in range(len(group)) if row not in taken), free, strict=True))
        places = [(each.pose, each.velocity, each.low, each.time, each.behind) for each in group]
        for row, index in taken.items():
            person = group[row]
            person.pose, person.velocity, person.low, person.time, person.behind = places[index]
            person.behind = None if person.behind is person else person.behind
    for each in group:
        if each.fresh:
            each.crossed.clear()
        each.fresh.clear()
