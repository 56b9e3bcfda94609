"""Dancers inside a region: which pattern makes the places, with and without symmetry (T091, T092, T144)."""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import numpy.typing as npt
import shapely

from live.agents.formations.blue_noise import (
    Density,
    hexagonal_spacing,
    middle_of_line,
    scatter,
    scatter_mirrored,
)
from live.agents.formations.drawing import Drawing
from live.agents.formations.lattice import place_on_lattice
from live.agents.formations.on_lines import density_at, place_mirrored, place_on_curves
from live.agents.formations.silhouettes import Core, core_of, silhouettes, unmarked
from live.agents.formations.spec import FormationSpec
from live.agents.formations.symmetry import SymmetryLine, half_drawing

Float64 = npt.NDArray[np.float64]


SEAM: Final = 2e-7


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """A region and what takes long to find out about it."""

    region: Any
    half: Any
    """Its kept half, None without a symmetry line."""
    line: SymmetryLine | None
    core: Core | None
    """For concentric silhouettes."""


def ground_of(spec: FormationSpec, drawing: Drawing, line: SymmetryLine | None) -> Ground:
    """The region of a drawing with closed lines, symmetrical where wished."""
    region, half = drawing.region, None
    if line is not None:
        half = half_drawing(spec, drawing, line)[2]
        overlapping = half.buffer(SEAM, join_style="mitre")  # rounding would leave a slit between the halves
        region = overlapping.union(line.reflect_shape(overlapping))
        shapely.prepare(region)
    return Ground(region, half, line, core_of(region) if spec.distribution == "concentric" else None)


def place_inside(spec: FormationSpec, ground: Ground, count: int, seed: int) -> Float64:
    """`count` places inside a region, shape (count, 2)."""
    if count == 0:
        return np.zeros((0, 2))
    region, half, line = ground.region, ground.half, ground.line
    if count == 1:
        return (_middle(region) if half is None or line is None else middle_of_line(half, line))[None]
    pattern = spec.distribution
    if pattern in ("grid", "diagonal"):
        found = _on_lattice(spec, region, count, line)
        if found is not None:
            return found
    if ground.core is not None:
        return _in_silhouettes(spec, ground.core, line, count)
    density: Density | None = (lambda points: density_at(spec, points)) if pattern == "weighted" else None
    even = pattern in ("even", "grid", "diagonal")
    if half is not None and line is not None:
        return scatter_mirrored(half, line, count, seed, density=density, even=even)
    return scatter(region, count, seed, density=density, even=even)


def count_by_spacing(spec: FormationSpec, region: Any, spacing: float) -> int:
    """About how many dancers fit inside with neighbours `spacing` [m] apart."""
    area = float(region.area)
    if spec.distribution == "concentric":
        return round(area / spacing**2 + float(region.length) / (2.0 * spacing))
    # share of the hexagonal spacing that the pattern reaches
    reached = {"poisson": 0.7, "weighted": 0.6, "even": 0.85}.get(spec.distribution)
    if reached is None:
        return round(area / spacing**2)
    return round((reached * hexagonal_spacing(area, 1) / spacing) ** 2)


def _middle(region: Any) -> Float64:
    """The middle of the widest place inside, or of the whole if that is inside, shape (2,)."""
    low_x, low_z, high_x, high_z = region.bounds
    centre = np.array([(low_x + high_x) / 2, (low_z + high_z) / 2])
    if shapely.contains_xy(region, centre[0], centre[1]):
        return centre
    return np.asarray(shapely.get_coordinates(shapely.maximum_inscribed_circle(region))[0])


def _on_lattice(spec: FormationSpec, region: Any, count: int, line: SymmetryLine | None) -> Float64 | None:
    diagonal = spec.distribution == "diagonal"
    if line is None:
        yaw = math.radians(spec.rotation_deg)
        turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
        turned = shapely.get_coordinates(region) @ turn.T
        origin = ((turned.min(axis=0) + turned.max(axis=0)) / 2) @ turn
        return place_on_lattice(region, count, origin, yaw, diagonal=diagonal)
    low_x, low_z, high_x, high_z = region.bounds
    centre = np.array([(low_x + high_x) / 2, (low_z + high_z) / 2])
    origin = centre - line.side(centre[None])[0] * line.normal
    yaw = math.atan2(line.along[0], line.along[1])
    found = place_on_lattice(region, count, origin, yaw, diagonal=diagonal, symmetrical=True)
    if found is None:
        return None
    kept = found[line.side(found) > 1e-4]
    on_line = found[np.abs(line.side(found)) <= 1e-4]
    on_line = on_line - line.side(on_line)[:, None] * line.normal
    if 2 * len(kept) + len(on_line) != count:  # a place so near the border that its reflection fell outside
        return None
    return np.concatenate([kept, on_line, line.reflect(kept)])


def _in_silhouettes(spec: FormationSpec, core: Core, line: SymmetryLine | None, count: int) -> Float64:
    curves, middle = silhouettes(core, count)
    curves = unmarked(curves, count)
    corners = spec.mark_corners is not False
    if line is None:
        return np.concatenate([place_on_curves(curves, count - len(middle), corners=corners)[0], middle])
    on_line = middle - line.side(middle)[:, None] * line.normal
    rings = Drawing(tuple(curves), None, (0.0, 0.0))
    kept, straight, _ = half_drawing(spec, rings, line)
    places = place_mirrored(kept, straight, line, count - len(middle), corners=corners)[0]
    return np.concatenate([places, on_line])
