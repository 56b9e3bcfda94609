"""Trunk and neck chains of any length spread over the engine's three spine joints and one neck joint."""

from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.retarget.rest_pose_alignment import SourcePoints
from live.motion.skeleton import SKELETON

Float = npt.NDArray[np.floating]

SPINE: Final = ("spine", "chest", "upperChest")


def _engine_places() -> list[float]:
    """Where between hips (0) and neck (1) the middles of the segments above spine, chest and upperChest lie."""
    chain = [SKELETON.index(name) for name in (*SPINE, "neck")]
    heights = np.cumsum([np.linalg.norm(SKELETON.offsets[joint]) for joint in chain])
    return [float(0.5 * (heights[n] + heights[n + 1]) / heights[-1]) for n in range(len(SPINE))]


PLACES: Final = _engine_places()


def source_places(rest: SourcePoints) -> Float:
    """Middles of the source's segments above the hips and above each spine joint, from 0 (hips) to 1 (arms).

    Lengths are taken along the chain in the rest pose; the last joint's segment reaches up to the neck, or to the
    line between the shoulder joints where the neck hangs on the same spot.
    """
    body = rest.body
    chain = [rest.at("hips")[0], *(rest.positions[0, joint] for joint in body.spine)]
    top = rest.positions[0, body.neck[0]] if body.neck else rest.middle("UpperArm")[0]
    lengths = [float(np.linalg.norm(b - a)) for a, b in zip(chain, [*chain[1:], top], strict=True)]
    ends = np.cumsum(lengths)
    middles = ends - 0.5 * np.array(lengths)
    return np.asarray(middles / max(float(ends[-1]), 1e-9))


def spine_rotations(rest: SourcePoints, hips: Float, chain: list[Float]) -> dict[str, Float]:
    """World rotations of spine, chest and upperChest, (T, 4) each, from the hips' and the chain's aligned ones.

    Each of ours takes the rotation that the source's trunk has at the same height: SLERP between the two nearest.
    """
    known = [hips, *chain]
    places = source_places(rest)
    rotations = {}
    for name, place in zip(SPINE, PLACES, strict=True):
        above = int(np.searchsorted(places, place))
        if above == 0 or above == len(known):
            rotations[name] = known[min(above, len(known) - 1)]
        else:
            gap = places[above] - places[above - 1]
            part = (place - places[above - 1]) / gap if gap > 1e-9 else 1.0
            rotations[name] = quaternion.slerp(known[above - 1], known[above], np.asarray(part))
    return rotations


def neck_rotation(chain: list[Float], chest: Float, head: Float) -> Float:
    """World rotation of the neck, (T, 4): that of the middle of the chain, or half way from chest to head."""
    if not chain:
        return quaternion.slerp(chest, head, np.asarray(0.5))
    low, high = chain[(len(chain) - 1) // 2], chain[len(chain) // 2]
    return low if low is high else quaternion.slerp(low, high, np.asarray(0.5))
