"""Following: partners who follow choose their next measures after their leaders have, to end at their side."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.graph.choosing.choosing import Choosing, with_direction
from live.show.choices import Choices
from live.show.partners import Partners

Float64 = npt.NDArray[np.float64]


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
    sides = partners.sides(choosing.graph.library.node_side[chosen])
    results = tuple(np.ascontiguousarray(array[follow]) for array in out)
    choosing.choose(
        slice(0, len(follow)), node[follow], placement[follow], wish[follow], row[follow], ahead, sides,
        manner[follow], results,
    )  # fmt: skip
    for array, result in zip(out, results, strict=True):
        array[follow] = result
