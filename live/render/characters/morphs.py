"""Blend shapes of a character, sparse: for each vertex how far each channel of the face moves it."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.render.characters.expressions import BLINKS, CHANNELS
from live.render.characters.lod import SimplifiedMesh
from live.render.characters.model import Model
from live.render.characters.skeleton_fit import FittedCharacter

_LEAST: Final = 1e-4
"""Shorter movements are left out [m]."""
_MIDDLE: Final = 0.01
"""Half-width of the blend between both sides of a face whose blend shape closes both eyes [m]."""
RANGE: Final = 0.25
"""Longest movement along an axis [m]."""
NORMAL_RANGE: Final = 2.0
"""Longest movement of a normal along an axis."""
MAX_ENTRIES: Final = 1 << 23
"""Maximum number of entries of a character: their numbers have 24 bits with those of others."""

UInt32 = np.ndarray[tuple[int, ...], np.dtype[np.uint32]]


@dataclass(frozen=True, slots=True, eq=False)
class Morphs:
    """What moves V vertices, E entries."""

    count: UInt32
    """Number of entries of each vertex, shape (V,)."""
    entry: UInt32
    """Entries of all vertices in their order: movement x, y, z of position and normal as pairs of 16-bit numbers
    (32768: none), channel; shape (E, 4)."""


Movements = dict[int, tuple[Float64, Float64]]
"""For each channel how far vertices and normals move in the rest pose, both (V, 3) [m]."""


def fitted_movements(model: Model, fitted: FittedCharacter, left_out: frozenset[int]) -> Movements:
    """Return the movements of all parts' vertices by channel in the engine's rest pose, without channels `left_out`."""
    main = fitted.weight.argmax(axis=1)
    found: Movements = {}
    for channel in sorted({channel for part in model.parts for channel in part.morphs} - left_out):
        shifts = [
            np.concatenate([part.morphs.get(channel, (zero, zero))[which] for part in model.parts
                            for zero in (np.zeros_like(part.position),)])
            for which in range(2)
        ]  # fmt: skip
        moved, turned = (fitted.transform.apply_to_vectors(shift, main) for shift in shifts)
        turned = turned / fitted.transform.scale
        if channel >= 0:
            found[channel] = moved, turned
            continue
        left = np.clip(fitted.position[:, :1] / (2.0 * _MIDDLE) + 0.5, 0.0, 1.0)
        for number, share in zip(BLINKS, (left, 1.0 - left), strict=True):
            found[number] = moved * share, turned * share
    return found


def simplified(movements: Movements, level: SimplifiedMesh) -> Movements:
    """Return the movements of a simplified mesh: those of positions are shared by each cell, like positions."""
    return {
        channel: (level.mean_positions(moved), level.mean(turned)) for channel, (moved, turned) in movements.items()
    }


def pack(movements: Movements, vertices: int) -> Morphs:
    """Return movements as entries for the shader (`skin_fragment.glsl`)."""
    vertex, entry = [np.zeros(0, np.int64)], [np.zeros((0, 4), np.uint32)]
    for channel, (moved, turned) in movements.items():
        rows = np.flatnonzero(np.abs(moved).max(axis=1) > _LEAST)
        share = np.hstack([moved[rows] / RANGE, turned[rows] / NORMAL_RANGE])
        numbers = (np.rint(np.clip(share, -1.0, 1.0) * 32767.0) + 32768.0).astype(np.uint16)
        packed = np.full((len(rows), 4), channel, np.uint32)
        packed[:, :3] = numbers.view(np.uint32)
        vertex.append(rows)
        entry.append(packed)
    vertices_of, entries = np.concatenate(vertex), np.concatenate(entry)
    order = np.argsort(vertices_of, kind="stable")[:MAX_ENTRIES]
    return Morphs(np.bincount(vertices_of[order], minlength=vertices).astype(np.uint32), entries[order])


def channel_names(movements: Movements) -> tuple[str, ...]:
    """Return the names of the channels that move anything."""
    return tuple(CHANNELS[channel].name for channel in sorted(movements))
