"""Fair attraction to the many attractor points ("voices") of an audience.

With the nearest source alone (T106) one phone next to a dancer would outweigh a hundred elsewhere; with a mean, all
dancers would stand between the places. So the voices are clustered into places (modes of their density). A place pulls
in proportion to its share of the voices, and more on nearby dancers.
"""

import math

import numpy as np
import numpy.typing as npt

from live.agents.elements.element_table_kernels import (
    ACTIVE_START,
    ADDRESSED_LEVEL,
    LEVEL,
    PLACE_COUNT,
    STRENGTH,
    SWITCHED,
    X,
    Z,
    add_velocity,
    addresses,
)
from live.base.element_kinds import PARTICIPANT
from live.base.jit import kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
UInt64 = npt.NDArray[np.uint64]

# columns of a place (P, 5)
PLACE_X, PLACE_Z, SHARE, PULL, DECAY = 0, 1, 2, 3, 4
PLACE_COLUMNS = 5
MAX_PLACES = 8
"""Largest number of places per audience; voices elsewhere are ignored."""
MAX_AUDIENCES = 8
"""Largest number of different group masks addressed at a time."""
BANDWIDTH = 1.2
"""Voices within this distance [m] of each other form one place."""
SHARPNESS = 4.0
"""Exponent of the share: a place with half the voices pulls less by a factor of 2 to the power of this."""
NEAR_DISTANCE = 8.0
"""Distance [m] over which nearness counts as much as a factor e in voices."""
QUORUM = 4.0
"""Number of voices that pull with full strength; fewer pull in proportion."""


@kernel("f8(f8,f8,f8,f8)")
def kernel_weight(ax: float, az: float, bx: float, bz: float) -> float:
    """Return the kernel weight of two voices: 1 at the same point, 0 from the bandwidth on (biweight kernel)."""
    t = 1.0 - ((ax - bx) ** 2 + (az - bz) ** 2) / (BANDWIDTH * BANDWIDTH)
    return t * t if t > 0.0 else 0.0


@kernel("b1(f8[:,::1],u8[::1],i4[::1],f8[:,::1],u8[::1],f8[::1],u8,f8,i8)")
def find_densest_place(
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
    """Write the densest remaining place of one audience into row `place` and mark its voices as used.

    The place is the mean of its voices. Return False if no voice is left.
    """
    first, end = ACTIVE_START + active[PARTICIPANT], ACTIVE_START + active[PARTICIPANT + 1]
    best = -1
    for k in range(first, end):
        a = active[k]
        if masks[a] == mask and density[a] > 0.0 and (best < 0 or density[a] > density[best]):
            best = a
    if best < 0:
        return False
    x, z, weight, strength = table[best, X], table[best, Z], 0.0, 0.0
    for _ in range(4):  # mean shift
        sum_x, sum_z, near_sum = 0.0, 0.0, 0.0
        for k in range(first, end):
            a = active[k]
            if masks[a] == mask and density[a] > 0.0:
                near = kernel_weight(x, z, table[a, X], table[a, Z]) * table[a, LEVEL] * max(table[a, STRENGTH], 0.0)
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


@kernel("void(f8[:,::1],u8[::1],i4[::1],f8[::1])")
def weigh_voices(table: Float64, masks: UInt64, active: Int32, density: Float64) -> None:
    """Write the weight of the voices around each voice, itself included, into density (E,)."""
    first, end = ACTIVE_START + active[PARTICIPANT], ACTIVE_START + active[PARTICIPANT + 1]
    for k in range(first, end):
        a = active[k]
        density[a] = 0.0
        for n in range(first, end):
            b = active[n]
            if masks[a] == masks[b]:
                near = kernel_weight(table[a, X], table[a, Z], table[b, X], table[b, Z])
                density[a] += near * table[b, LEVEL] * max(table[b, STRENGTH], 0.0)


@kernel("i8(f8[:,::1],u8[::1],i4[::1],f8[:,::1],u8[::1],f8[::1],u8,i8)")
def find_mask_places(
    table: Float64,
    masks: UInt64,
    active: Int32,
    places: Float64,
    audience: UInt64,
    density: Float64,
    mask: np.uint64,
    begin: int,
) -> int:
    """Find the places of the voices of one group mask, from row `begin` on; return the row after the last one."""
    first, end = ACTIVE_START + active[PARTICIPANT], ACTIVE_START + active[PARTICIPANT + 1]
    total, most, count = 0.0, 0.0, begin
    for k in range(first, end):
        if masks[active[k]] == mask:
            total += table[active[k], LEVEL] * max(table[active[k], STRENGTH], 0.0)
    for _ in range(MAX_PLACES):
        if not find_densest_place(table, masks, active, places, audience, density, mask, total, count):
            break
        most = max(most, places[count, SHARE])
        count += 1
    for p in range(begin, count):
        places[p, SHARE] = (places[p, SHARE] / most) ** SHARPNESS
    for k in range(first, end):
        if masks[active[k]] == mask:
            density[active[k]] = -1.0
    return count


@kernel("i8(f8[:,::1],u8[::1],i4[::1],f8[:,::1],u8[::1],f8[::1])")
def find_places(
    table: Float64, masks: UInt64, active: Int32, places: Float64, audience: UInt64, density: Float64
) -> int:
    """Find the places of the acting voices; return their number.

    Writes places (MAX_PLACES * MAX_AUDIENCES, 5) and audience (MAX_PLACES * MAX_AUDIENCES,), the group mask of each
    place. density (E,) is scratch: the weight around each voice, or -1 once a voice belongs to a place.
    """
    weigh_voices(table, masks, active, density)
    count = 0
    for _ in range(MAX_AUDIENCES):
        of = -1
        for k in range(ACTIVE_START + active[PARTICIPANT], ACTIVE_START + active[PARTICIPANT + 1]):
            if density[active[k]] >= 0.0:
                of = active[k]
                break
        if of < 0:
            break
        count = find_mask_places(table, masks, active, places, audience, density, masks[of], count)
    return count


@kernel("void(f8[:,::1],u8[::1],f4[:,::1],u8[::1],f8[::1],f8[:,::1])")
def fair_attraction(
    places: Float64, audience: UInt64, position: Float32, groups: UInt64, numbers: Float64, sums: Float64
) -> None:
    """Add the attraction to the places of an audience.

    Weights are share ** SHARPNESS * exp(-SHARPNESS * d / NEAR_DISTANCE). They are smooth, so that a dancer does not
    jitter between two equal places, and so sharp that a place with few voices does not count next to one with many.
    """
    for i in range(position.shape[0]):
        if sums[i, ADDRESSED_LEVEL] <= 0.0:
            continue
        wish_x, wish_z, pull, total = 0.0, 0.0, 0.0, 0.0
        for p in range(int(numbers[PLACE_COUNT])):
            if not addresses(audience[p], groups[i]):
                continue
            dx, dz = places[p, PLACE_X] - position[i, 0], places[p, PLACE_Z] - position[i, 1]
            d = math.sqrt(dx * dx + dz * dz)
            weight = places[p, SHARE] * math.exp(-SHARPNESS * d / NEAR_DISTANCE)
            size = weight * places[p, PULL] * (1.0 - math.exp(-d / places[p, DECAY])) / max(d, 1e-9)
            wish_x += size * dx
            wish_z += size * dz
            pull += weight * places[p, PULL]
            total += weight
        if total > 0.0:
            add_velocity(sums, i, wish_x / total, wish_z / total, pull / total, numbers[SWITCHED] > 0.0)
