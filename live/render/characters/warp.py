"""A smooth warp that brings a character's joints to the dancer's: displacements spread by multiquadrics (Hardy 1971).

Every joint lands exactly; between and around them the displacement changes smoothly, so limbs keep their roundness and
clothes hold together. Soles come to lie on the floor; head, hands and toes move as a whole.
"""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.skeleton import SKELETON

Float64 = npt.NDArray[np.float64]

_REST: Final = SKELETON.rest_positions().astype(np.float64)
_SOFT: Final = 0.05
"""How far around a joint the warp is nearly the same [m]."""
_BLOCK: Final = 20_000


def warp(position: Float64, place: Float64, weight: Float64) -> Float64:
    """Positions (V, 3) warped as joints go from `place` (J, 3) to the rest pose; `weight` (V, J): what is a head."""
    start, end = _anchors(position, place, weight)
    moved = end - start
    if np.abs(moved).max() < 1e-9:
        return position
    count = len(start)
    system = np.zeros((count + 1, count + 1))
    system[:count, :count] = _kernel(start, start)
    system[:count, count] = system[count, :count] = 1.0
    spread = np.linalg.lstsq(system, np.vstack([moved, np.zeros((1, 3))]), rcond=1e-10)[0]
    out = position.copy()
    for first in range(0, len(out), _BLOCK):
        some = slice(first, first + _BLOCK)
        out[some] += _kernel(position[some], start) @ spread[:count] + spread[count]
    return out


def _kernel(a: Float64, b: Float64) -> Float64:
    squared = ((a[:, None, :] - b[None, :, :]) ** 2).sum(axis=2)
    return np.asarray(-np.sqrt(squared + _SOFT * _SOFT))


def _anchors(position: Float64, place: Float64, weight: Float64) -> tuple[Float64, Float64]:
    """Points of the character and where they go: joints, soles, and what surrounds head, hands and toes."""
    start, end = [*place], [*_REST]

    def carry(joint: int, offset: Float64) -> None:
        start.append(place[joint] + offset)
        end.append(_REST[joint] + offset)

    head = SKELETON.index("head")
    own = position[weight[:, head] > 0.5] - place[head]
    if len(own):
        low, high = own.min(axis=0), own.max(axis=0)
        middle = 0.5 * (low + high)
        for axis in range(3):
            for edge in (low, high):
                offset = middle.copy()
                offset[axis] = edge[axis]
                if offset[1] >= 0.0:
                    carry(head, offset)
    for side, out in (("left", 1.0), ("right", -1.0)):
        foot, toes, hand = (SKELETON.index(side + each) for each in ("Foot", "Toes", "Hand"))
        carry(hand, np.array([0.17 * out, 0.0, 0.0]))
        for joint in (foot, toes):
            start.append(place[joint] * (1.0, 0.0, 1.0))
            end.append(_REST[joint] * (1.0, 0.0, 1.0))
        start.append((place[toes] + (0.0, 0.0, 0.07)) * (1.0, 0.0, 1.0))
        end.append((_REST[toes] + (0.0, 0.0, 0.07)) * (1.0, 0.0, 1.0))
    return np.array(start), np.array(end)
