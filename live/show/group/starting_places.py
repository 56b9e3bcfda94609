"""Starting places: where everybody stands before a show begins: in her group's formation, or in the wings."""

import numpy as np
import numpy.typing as npt

from live.agents.entrances.gate import Gate
from live.agents.separation.parting import Parting
from live.show.dancers.partners import Partners
from live.show.group.evolutions import Evolutions

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

FROM_THE_EDGE = 0.3
"""Nobody begins nearer to the edge of the stage than this [m]."""


def starting_places(
    evolutions: Evolutions, partners: Partners, part: Parting, gate: Gate, on: Bool, half: Float32, heading: Float64
) -> Float32:
    """Places [m], shape (A, 2): of those who are `on` the stage (A,), of half sizes `half` (2,) [m], and of those who
    wait behind `gate`, who come last. Pairs are joined; `heading` (A,) [rad] becomes what everybody faces."""
    count = len(on)
    placed = evolutions.starting_places()
    position = np.zeros((count, 2), np.float32)
    position[: len(placed)] = placed
    position[len(placed) :] = gate.places(count - len(placed))
    edge = half - np.float32(FROM_THE_EDGE)
    partners.pair(on)
    partners.begin(position, heading)
    position[on] = np.clip(position[on], -edge, edge)
    wanted = position.copy()
    for _ in range(8):  # formations of two groups may lie on each other
        part(position, wanted, float(edge.max()))
        position[on] = np.clip(position[on], -edge, edge)
        partners.gather(position, heading)
    position[~on] = wanted[~on]
    return position
