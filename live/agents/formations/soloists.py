"""Soloists: in front of the others, or in the middle, where the others make room (T093)."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt
import shapely

from live.agents.formations.curve import curve_of
from live.agents.formations.drawing import Drawing, met
from live.agents.formations.spec import FormationSpec
from live.agents.formations.symmetry import SymmetryLine

Float64 = npt.NDArray[np.float64]


def soloist_places(spec: FormationSpec, drawing: Drawing, others: Float64) -> Float64:
    """Where the soloists stand, shape (K, 2): side by side in front of all `others` (S, 2), or around the middle."""
    gap, number = spec.soloist_gap, spec.soloists
    if spec.soloist_place == "centre":
        return _around(drawing.middle, number, gap)
    front = float(others[:, 1].max()) if len(others) else drawing.middle[1] - gap
    x = drawing.middle[0] + gap * (np.arange(number) - (number - 1) / 2)
    return np.stack([x, np.full(number, front + gap)], axis=1)


def _around(middle: tuple[float, float], number: int, gap: float) -> Float64:
    if number == 1:
        return np.array([middle])
    angle = 2.0 * math.pi * np.arange(number) / number
    radius = gap / (2.0 * math.sin(math.pi / number))
    return np.array(middle) + radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)


def make_room(spec: FormationSpec, drawing: Drawing, line: SymmetryLine | None) -> Drawing:
    """The drawing without what lies nearer to soloists in the middle than their gap.

    PersonError if nothing is left for the others.
    """
    if spec.soloists == 0 or spec.soloist_place != "centre":
        return drawing
    taken: Any = shapely.MultiPoint(_around(drawing.middle, spec.soloists, spec.soloist_gap)).buffer(spec.soloist_gap)
    if line is not None:
        taken = taken.union(line.reflect_shape(taken))
    curves = []
    for curve in drawing.curves:
        drawn = shapely.LineString(curve.points)
        if not drawn.intersects(taken):
            curves.append(curve)
            continue
        parts = [part for part in shapely.get_parts(drawn.difference(taken)) if part.length > 1e-9]
        merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(parts))) if parts else []
        left = [curve_of(shapely.get_coordinates(part), closed=False) for part in merged]
        curves += [each for each in left if each is not None]
    region = None if drawing.region is None else drawing.region.difference(taken)
    if (region is None and not curves) or (region is not None and region.area < 0.1 * drawing.region.area):
        spec.refuse(
            "soloist_gap", "the soloists in the middle leave no room for the others", "a smaller gap or a larger size"
        )
    if region is not None:
        shapely.prepare(region)
    return Drawing(met(curves), region, drawing.middle)
