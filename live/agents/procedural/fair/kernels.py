"""Fair attraction: where the many voices of an audience gather, and what a place with many of them does to a dancer.

With the nearest source alone (T106) one phone beside a dancer would hold her against a hundred elsewhere, and with a
mean all of them would stand between the places. So the voices are gathered into places (modes of their density), and
a place pulls by its share of the voices, and more on those who are near it.
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.procedural.kinds import VOICE
from live.agents.procedural.sources.kernels import ROWS
from live.agents.procedural.table.kernels import LEVEL, STRENGTH, X, Z, addresses
from live.base.jit import kernel

Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# columns of a place (P, 5)
PLACE_X, PLACE_Z, SHARE, PULL, DECAY = 0, 1, 2, 3, 4
PLACE_COLUMNS = 5
PLACES = 8
"""Places of one audience at most; the voices elsewhere are not heard."""
AUDIENCES = 8
"""Different groups that voices may address at a time."""
BANDWIDTH = 1.2
"""Voices within this distance [m] of each other are one place."""
SHARPNESS = 4.0
"""A place with half the voices of another pulls 2 to the power of this less."""
NEARNESS = 8.0
"""Distance [m] on which nearness counts as much as e times the voices."""
QUORUM = 4.0
"""So many voices pull with full strength; fewer pull in proportion."""


@kernel("f8(f8,f8,f8,f8)")
def closeness(ax: float, az: float, bx: float, bz: float) -> float:
    """How much two voices are at one place: 1 together, 0 from the bandwidth on (biweight kernel)."""
    t = 1.0 - ((ax - bx) ** 2 + (az - bz) ** 2) / (BANDWIDTH * BANDWIDTH)
    return t * t if t > 0.0 else 0.0


@kernel("b1(f8[:,::1],u8[::1],i4[::1],f8[:,::1],u8[::1],f8[::1],u8,f8,i8)")
def _next_place(
    table: Float64,
    masks: UInt64,
    active: Int32,
    places: Float64,
    audience: UInt64,
    density: Float64,
    mask: np.uint64,
    total: float,
    place: int,
) -> bool:
    """The densest place that is left of one audience into row `place`: its mean, and its voices marked as taken."""
    first, end = ROWS + active[VOICE], ROWS + active[VOICE + 1]
    best = -1
    for k in range(first, end):
        a = active[k]
        if masks[a] == mask and density[a] > 0.0 and (best < 0 or density[a] > density[best]):
            best = a
    if best < 0:
        return False
    x, z, weight, strength = table[best, X], table[best, Z], 0.0, 0.0
    for _ in range(4):  # mean shift: the middle of the voices around, which moves towards most of them
        sum_x, sum_z, near_sum = 0.0, 0.0, 0.0
        for k in range(first, end):
            a = active[k]
            if masks[a] == mask and density[a] > 0.0:
                near = closeness(x, z, table[a, X], table[a, Z]) * table[a, LEVEL] * max(table[a, STRENGTH], 0.0)
                sum_x += near * table[a, X]
                sum_z += near * table[a, Z]
                near_sum += near
        if near_sum > 0.0:
            x, z = sum_x / near_sum, sum_z / near_sum
    level = 0.0
    for k in range(first, end):
        a = active[k]
        if masks[a] != mask or density[a] <= 0.0:
            continue
        d2 = (table[a, X] - x) ** 2 + (table[a, Z] - z) ** 2
        if a == best or d2 < BANDWIDTH * BANDWIDTH:
            weight += table[a, LEVEL] * max(table[a, STRENGTH], 0.0)
            strength = max(strength, table[a, STRENGTH])
            level = max(level, table[a, LEVEL])
            density[a] = -1.0
    places[place, PLACE_X], places[place, PLACE_Z], places[place, SHARE] = x, z, weight
    places[place, PULL] = min(strength * level, 1.0) * min(total / QUORUM, 1.0)
    places[place, DECAY] = 1.2
    audience[place] = mask
    return True


@kernel("i8(f8[:,::1],u8[::1],i4[::1],f8[:,::1],u8[::1],f8[::1])")
def gather(table: Float64, masks: UInt64, active: Int32, places: Float64, audience: UInt64, density: Float64) -> int:
    """Find the places of the voices that act, and return how many there are.

    places (PLACES * AUDIENCES, 5) and audience (PLACES * AUDIENCES,), the group mask of each place, are written;
    density (E,) is scratch: it holds each voice's weight around it, and -1 once a voice belongs to a place.
    """
    first, end = ROWS + active[VOICE], ROWS + active[VOICE + 1]
    count = 0
    for k in range(first, end):
        a = active[k]
        density[a] = 0.0
        for n in range(first, end):
            b = active[n]
            if masks[a] == masks[b]:
                near = closeness(table[a, X], table[a, Z], table[b, X], table[b, Z])
                density[a] += near * table[b, LEVEL] * max(table[b, STRENGTH], 0.0)
    for _ in range(AUDIENCES):
        of, total = -1, 0.0
        for k in range(first, end):
            if density[active[k]] >= 0.0:
                of = active[k]
                break
        if of < 0:
            break
        mask, begin = masks[of], count
        for k in range(first, end):
            if masks[active[k]] == mask:
                total += table[active[k], LEVEL] * max(table[active[k], STRENGTH], 0.0)
        for _p in range(PLACES):
            if not _next_place(table, masks, active, places, audience, density, mask, total, count):
                break
            count += 1
        most = 0.0
        for p in range(begin, count):
            most = max(most, places[p, SHARE])
        for p in range(begin, count):
            places[p, SHARE] = (places[p, SHARE] / most) ** SHARPNESS
        for k in range(first, end):
            if masks[active[k]] == mask:
                density[active[k]] = -1.0
    return count


@kernel("UniTuple(f8,3)(f8[:,::1],u8[::1],i8,f8,f8,u8)")
def fair_attraction(
    places: Float64, audience: UInt64, count: int, x: float, z: float, groups: np.uint64
) -> tuple[float, float, float]:
    """Wish towards the places of an audience, as a share of the top speed, and how much of it is asked (0 to 1).

    Weights are share ** SHARPNESS * exp(-SHARPNESS * d / NEARNESS): smooth, so that nobody trembles between two places
    of equal right, and so sharp that a place with a few voices among many does not count.
    """
    wish_x, wish_z, pull, total = 0.0, 0.0, 0.0, 0.0
    for p in range(count):
        if not addresses(audience[p], groups):
            continue
        dx, dz = places[p, PLACE_X] - x, places[p, PLACE_Z] - z
        d = math.sqrt(dx * dx + dz * dz)
        weight = places[p, SHARE] * math.exp(-SHARPNESS * d / NEARNESS)
        size = weight * places[p, PULL] * (1.0 - math.exp(-d / places[p, DECAY])) / max(d, 1e-9)
        wish_x += size * dx
        wish_z += size * dz
        pull += weight * places[p, PULL]
        total += weight
    if total <= 0.0:
        return 0.0, 0.0, 0.0
    return wish_x / total, wish_z / total, pull / total
