"""Following: partners who follow choose their next measures after their leaders have, to end at their side."""

from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.graph.select.selector import Choosing, with_direction
from live.show.dancers.partners import Partners
from live.show.selection.choices import Choices

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

TOO_FAR: Final = 0.4
"""A follower whose measure would end so far [m] from her place may dance any side of the step."""


def place_followers(
    partners: Partners, choosing: Choosing, choices: Choices, heading: Float64, asked: tuple[Any, ...]
) -> tuple[Int32, Int32]:
    """Say where followers should end, once everybody has chosen, `asked` with these arguments of `Choosing.choose`.

    Leaders end where their clips and corrections take them, and face what their turns reach: both are written into
    the targets and `heading` (A,) [rad], and their followers' places and headings beside them. Returns the followers
    (P,) and the sides they want: the mirror image of what their leaders dance where they face them, else the same.
    """
    node, _, wish, _, _, _, manner, _ = asked
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
    return follow, partners.sides(choosing.graph.library.node_side[chosen])


def choose_following(rows: Int32, sides: Int32, choosing: Choosing, choices: Choices, asked: tuple[Any, ...]) -> None:
    """Choose anew for the followers `rows` (n,) who want these `sides` (n,); to stay together is more than to dance on
    the same feet."""
    _choose(rows, sides, choosing, asked)
    off = np.hypot(*(choices.end[rows, :2] - choices.target[rows]).T)
    far = rows[off > TOO_FAR]
    if len(far):
        _choose(far, np.zeros(len(far), np.int32), choosing, asked)


def _choose(rows: Int32, sides: Int32, choosing: Choosing, asked: tuple[Any, ...]) -> None:
    node, placement, wish, row, ahead, _, manner, out = asked
    results: Any = tuple(np.ascontiguousarray(array[rows]) for array in out)
    choosing.choose(
        slice(0, len(rows)), node[rows], placement[rows], wish[rows], row[rows], ahead, sides, manner[rows], results
    )
    for array, result in zip(out, results, strict=True):
        array[rows] = result
