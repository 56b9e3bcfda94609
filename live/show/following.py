"""Following: partners who follow choose their next measures after their leaders have, to end at their side."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.graph.choosing.choosing import Choosing, with_direction
from live.show.choices import Choices
from live.show.partners import Partners

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

TOO_FAR: Final = 0.4
"""A follower whose measure would end so far [m] from her place may dance any side of the step."""


def follow_leaders(
    partners: Partners, choosing: Choosing, choices: Choices, heading: Float64, asked: tuple[Any, ...]
) -> None:
    """Choose anew for the followers: everybody's choice is made, `asked` with these arguments of `Choosing.choose`.

    Leaders end where their clips and corrections take them, and face what their turns reach: both are written into
    the targets and `heading` (A,) [rad], and their followers' places and headings beside them. Followers want the
    mirror image of what their leaders dance where they face them, else the same.
    """
    node, placement, wish, row, ahead, _, manner, out = asked
    lead, follow = partners.leader, partners.follower
    end, edge = choices.end[lead], choices.edge[lead, 0]
    chosen = np.where(edge < 0, node[lead], choosing.graph.edge_target[np.maximum(edge, 0)])
    way = choices.target[lead] - end[:, :2]
    most = manner[lead, 2] * choosing.facts[chosen, 0]
    reached = end[:, :2] + way * np.minimum(1.0, most / np.maximum(np.hypot(*way.T), 1e-9))[:, None]
    facing = heading[lead] - end[:, 3]
    lost = edge < 0  # cannot happen in a pruned graph
    reached[lost], facing[lost] = choices.target[lead][lost], heading[lead][lost]
    partners.follow(reached, facing, choices.target, heading)
    wish[follow] = with_direction(np.column_stack([choices.target[follow], heading[follow]]))

    def choose(rows: Int32, sides: Int32) -> None:
        results = tuple(np.ascontiguousarray(array[rows]) for array in out)
        choosing.choose(
            slice(0, len(rows)), node[rows], placement[rows], wish[rows], row[rows], ahead, sides, manner[rows],
            results,
        )  # fmt: skip
        for array, result in zip(out, results, strict=True):
            array[rows] = result

    choose(follow, partners.sides(choosing.graph.library.node_side[chosen]))
    off = np.hypot(*(choices.end[follow, :2] - choices.target[follow]).T)
    far = follow[off > TOO_FAR]
    if len(far):  # to stay together is more than to dance on the same feet
        choose(far, np.zeros(len(far), np.int32))
