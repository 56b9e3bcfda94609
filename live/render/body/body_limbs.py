"""Limbs with elliptical cross-sections fitted to a body's surface, for the contact of cloth (Xu and Barbič 2014 call
such proxies the cheapest that keep cloth outside; here they are fitted to the implicit surface of each body).
"""

from functools import cache
from pathlib import Path
from typing import Final

import numpy as np

from live.base.arrays import Float32, Float64
from live.base.body.catalogue import BODIES, DEFAULT_BODY
from live.base.disk.array_cache import ArrayCache, Arrays, digest_of_code
from live.motion.cloth import body_sections as limbs_of_bodies
from live.motion.cloth.body_sections import COEFFICIENTS, LIMB_COUNT, LIMBS, SECTION_COLUMNS, Limb
from live.render.body.body_mesh import code_digest
from live.render.body.body_variants import parts_of
from live.render.body.implicit_surface import Shape

_PLACES: Final = 25
"""Places along a limb where its half-widths are measured."""
_STEPS: Final = 321
_REACH: Final = 0.32
"""Rays are followed so far [m]."""
_WIDEST: Final = {"shoulders": 0.150, "neck": 0.065, "left foot": 0.045}
"""Largest half-widths where another limb begins [m]."""
_ROUND: Final = 1e3
"""Fitted numbers are rounded to 1/_ROUND, so that they have the same bits whatever library solved for them."""
_CACHE: Final = ArrayCache("limbs", max_entries=32)
_LIMBS_FILE: Final = Path(limbs_of_bodies.__file__)


@cache
def body_sections(name: str) -> Float32:
    """Return the limbs' cross-sections of a body, (LIMB_COUNT, SECTION_COLUMNS); a character has those of the default
    body. Fitted once per machine and version, in a fraction of a second."""
    body = name if name in BODIES else DEFAULT_BODY
    entry = _CACHE.entry_path(code_digest(), [body.encode(), digest_of_code([_LIMBS_FILE])])
    found = _CACHE.load(entry, _unpack)
    if found is None:
        shape = Shape(parts_of(body))
        fitted = {limb.name: _fit(shape, limb) for limb in LIMBS if not limb.name.startswith("right")}
        found = np.array([fitted[limb.name.replace("right", "left")] for limb in LIMBS], np.float32)
        _CACHE.store(entry, {"sections": found})
    found.setflags(write=False)
    return found


def _unpack(arrays: Arrays) -> Float32:
    found = arrays["sections"]
    if found.shape != (LIMB_COUNT, SECTION_COLUMNS) or found.dtype != np.float32 or not np.isfinite(found).all():
        raise ValueError("no sections")
    return found


def _fit(shape: Shape, limb: Limb) -> Float64:
    start, end, axes = np.array(limb.start), np.array(limb.end), limb.axes()
    place = np.linspace(0.0, 1.0, _PLACES)
    centre = start + place[:, None] * (end - start)
    most = _WIDEST.get(limb.name, _REACH)
    widths = [np.minimum(_crossing(shape, centre, way), most) for way in (axes[:, 0], axes[:, 2], -axes[:, 2])]
    if not limb.name.endswith(("thigh", "foot")):  # whose inner sides are in another limb
        widths = _cover(shape, centre, axes, widths, most)
    powers = place[:, None] ** np.arange(COEFFICIENTS)
    rows = [np.linalg.lstsq(powers * width[:, None], np.ones(_PLACES), rcond=None)[0] for width in widths]
    ends = (start, -axes[:, 1], min(w[0] for w in widths)), (end, axes[:, 1], max(w[-1] for w in widths))
    caps = [min(float(_crossing(shape, at[None, :], way)[0]), widest) for at, way, widest in ends]
    return np.rint(np.concatenate([*rows, 1.0 / np.maximum(caps, 0.01)]) * _ROUND) / _ROUND


_BETWEEN: Final = np.deg2rad([22.0, 45.0, 68.0])
"""Directions between side and front, or back, in which the skin is looked for, too."""
_MOST_WIDENED: Final = 1.22


def _cover(shape: Shape, centre: Float64, axes: Float64, widths: list[Float64], most: float) -> list[Float64]:
    """Widen the ellipses so that they hold the skin between their axes: bodies are squarer than ellipses."""
    side, front, back = widths
    wider = np.ones((2, len(centre)))
    for half, depth in enumerate((front, back)):
        for angle in _BETWEEN:
            way = np.cos(angle) * axes[:, 0] + (np.sin(angle) if half == 0 else -np.sin(angle)) * axes[:, 2]
            far = np.minimum(_crossing(shape, centre, way), most / max(np.cos(angle), 0.5))
            wider[half] = np.maximum(wider[half], np.hypot(far * np.cos(angle) / side, far * np.sin(angle) / depth))
    wider = np.minimum(wider, _MOST_WIDENED)
    return [side * wider.max(axis=0), front * wider[0], back * wider[1]]


def _crossing(shape: Shape, centre: Float64, way: Float64) -> Float64:
    """Return how far from each of the centres (N, 3) the skin is along `way` [m], (N,)."""
    reach = np.linspace(0.0, _REACH, _STEPS)
    return np.maximum(reach[shape.first_outside(centre, way, reach)], 0.005)
