"""Behind: dancers whose steps do not take them where they are sent, and what would (T003, T068, T075)."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.graph.select.placing import turn_vectors
from live.graph.select.reach import direction_of
from live.show.selection.choices import BEHIND_MEASURES, Choices

Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]


def behind(
    choices: Choices, group: Int32, names: tuple[str, ...], steps: tuple[str, ...], present: Bool
) -> dict[str, Any]:
    """By group: mean distances of the last measure [m], how many are behind, and what should be recorded.

    `group` (A,) into `names`; `steps` are the library's. "record" is null where nobody is behind.
    """
    told: dict[str, Any] = {}
    for index, name in enumerate(names):
        members = (group == index) & present
        if not members.any():
            continue
        rows = np.flatnonzero(members & (choices.behind >= BEHIND_MEASURES))
        told[name] = {
            "error_m": round(float(choices.error[members].mean()), 3),
            "lag_m": round(float(choices.lag[members].mean()), 3),
            "behind": len(rows),
            "record": _record(choices, rows, steps) if len(rows) else None,
        }
    return told


def _record(choices: Choices, rows: npt.NDArray[np.intp], steps: tuple[str, ...]) -> str:
    """What the dancers `rows` (n,) lack most: a step, a direction as the dancer sees it, a way."""
    way = turn_vectors(choices.wish[rows] - choices.stand[rows], -choices.heading[rows])
    got = turn_vectors(choices.target[rows] - choices.stand[rows], -choices.heading[rows])
    directions = [direction_of(one) for one in way]
    most = max(sorted(set(directions)), key=directions.count)
    those = np.array([direction == most for direction in directions])
    needed, reached = np.hypot(*way[those].T), np.hypot(*got[those].T)
    kinds = choices.step[rows][those]
    step = int(np.bincount(kinds[kinds >= 0]).argmax()) if (kinds >= 0).any() else -1
    which = "any step" if step < 0 else f"{steps[step]!r}"
    return (
        f"{which} gets {np.median(reached):.1f} m {most} in a measure, {np.median(needed):.1f} m are wanted: "
        "record it longer that way, or give the group a travel_step that goes there"
    )
