"""Remembered poses of a captured body: found by their stamps, sampled between them, and put on the stage."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel, part
from live.motion.capture.rotations_kernels import Vector, heading, mix, row_of

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]

TIME, BEAT = range(2)
"""Columns of `stamp`: when a remembered pose came [s], and the danced beat at that time."""
KEY, WANTED, CAUGHT, SHARE, PLACE_X, PLACE_Z, YAW, TURNED, ASKED = range(9)
"""Columns of what is asked: by which stamp, of when; how much of that pose, the rest being the one held before a gap;
how much is worn of it, the rest being the dancer's own; where the capture's origin lies [m] and its turn [rad]; and how
far the dancer was turned from her own heading last [rad], whole turns counted."""


@part
def find_stamps(stamp: Float64, count: int, key: int, wanted: float) -> tuple[int, int, float]:
    """The two remembered poses around `wanted`, and how far it is from the first to the second."""
    size = stamp.shape[0]
    newer = (count - 1) % size
    if stamp[newer, key] <= wanted:
        return newer, newer, 0.0
    for back in range(2, min(count, size) + 1):
        older = (count - back) % size
        if stamp[older, key] <= wanted:
            gap = stamp[newer, key] - stamp[older, key]
            return older, newer, (wanted - stamp[older, key]) / gap if gap > 1e-9 else 1.0
        newer = older
    return newer, newer, 0.0


@part
def _between_two(root: Float32, held: int, i: int, j: int, t: float, caught: float, c: int) -> float:
    """A coordinate of the hips between two remembered poses, or on the way to there from the one that was held."""
    value = root[i, c] + t * (root[j, c] - root[i, c])
    mixed: float = root[held, c] + caught * (value - root[held, c])
    return mixed


@part
def stood(
    root: Float32, held: int, i: int, j: int, t: float, asked: Float64, n: int, scale: float, mirrored: bool
) -> Vector:
    """Where the hips of what row `n` asks for are on the stage [m]."""
    caught = asked[n, CAUGHT]
    x = _between_two(root, held, i, j, t, caught, 0) * (-scale if mirrored else scale)
    y = _between_two(root, held, i, j, t, caught, 1)
    z = _between_two(root, held, i, j, t, caught, 2) * scale
    c, s = math.cos(asked[n, YAW]), math.sin(asked[n, YAW])
    return asked[n, PLACE_X] + c * x + s * z, y, asked[n, PLACE_Z] + c * z - s * x


@part
def rotation_between(
    turned: Float32, held: int, i: int, j: int, t: float, caught: float, joint: int, mirrored: bool
) -> Any:
    """The local rotation of a joint between two remembered poses, or on the way there from the one that was held."""
    q = mix(row_of(turned[i], joint), row_of(turned[j], joint), t)
    if caught < 1.0:
        q = mix(row_of(turned[held], joint), q, caught)
    return (q[0], q[1], -q[2], -q[3]) if mirrored else q


@kernel("void(f8[:,::1], f8[:,::1], f4[:,::1], f4[:,:,::1], f8[:,::1], i8, f8, b1)")
def where_captured(
    place: Float64, asked: Float64, root: Float32, turned: Float32, stamp: Float64, count: int, scale: float,
    mirrored: bool,
) -> None:  # fmt: skip
    """Where the hips of what is `asked` (n, 8) are on the stage: `place` (n, 4), x, y, z [m] and their heading [rad];
    the rest as in `live.motion.captured.wearing`."""
    held = stamp.shape[0]
    for n in range(asked.shape[0]):
        i, j, t = find_stamps(stamp, count, int(asked[n, KEY]), asked[n, WANTED])
        place[n, 0], place[n, 1], place[n, 2] = stood(root, held, i, j, t, asked, n, scale, mirrored)
        place[n, 3] = asked[n, YAW] + heading(rotation_between(turned, held, i, j, t, asked[n, CAUGHT], 0, mirrored))
