"""The places of a group on the stage, computed from a formation spec (T090-T093, T144)."""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
import numpy.typing as npt

from live.agents.formations.casting import (
    clear_soloist_area,
    place_headings,
    section_sizes,
    sections_along,
    sections_in_area,
    soloist_places,
)
from live.agents.formations.distances import closest_distance
from live.agents.formations.drawing import Drawing, drawing_of, places_by_hand
from live.agents.formations.formation_spec import MAX_DANCERS, FormationSpec
from live.agents.formations.like import capacity_of, transform_of, transformed_places
from live.agents.formations.line_placement import place_on_lines
from live.agents.formations.region_placement import PlacementRegion, count_by_spacing, place_inside, placement_region
from live.agents.formations.shapes import staggered_rows
from live.agents.formations.symmetry import LINE_TOLERANCE, SymmetryLine, clip_drawing, symmetry_line
from live.agents.material.deformation import WANTED_SHARE
from live.agents.material.transform import map_points
from live.base.arrays import Float64, Int64

TOUCH_DISTANCE: Final = 0.5
"""Bodies of radius 0.25 m touch at this distance of centres [m]."""
MIN_CLEARANCE: Final = 0.71
"""Straight ways into a formation are collision-free if its places are farther apart than this (CAPT) [m]."""
NO_SECTION: Final = -1
SOLOIST: Final = "soloist"
"""Mark of soloist places."""


@dataclass(frozen=True, slots=True, eq=False)
class Formation:
    """S places; place k belongs to dancer k if dancers are ordered soloists first, then section by section."""

    name: str
    slots: Float64
    """Places (x, z) [m], shape (S, 2)."""
    heading: Float64
    """Heading of each place [rad], shape (S,)."""
    section: Int64
    """Section of each place, from 0; NO_SECTION for soloists and where there are no sections, shape (S,)."""
    soloist: npt.NDArray[np.bool_]
    """Whether each place is a soloist's, shape (S,)."""
    min_distance: float
    """Smallest distance of two places [m]; infinite for fewer than two."""
    unplaced_dancers: int
    """Number of dancers without a place."""
    empty_places: int
    """Number of places without a dancer; they are the last ones."""
    warnings: tuple[str, ...]
    """Warnings for the user, one line each."""
    lines: tuple[Float64, ...]
    """The drawn lines, each (P, 2) [m]."""
    symmetry: SymmetryLine | None
    """The symmetry line, or None."""
    marks: tuple[str, ...]
    """Required word of each place, S words: "soloist", the name of a section, or "" for any dancer."""

    def extent(self) -> tuple[float, float, float, float]:
        """Return (least x, least z, greatest x, greatest z) of the places [m]; zeros if there are none."""
        if not len(self.slots):
            return (0.0, 0.0, 0.0, 0.0)
        low, high = self.slots.min(axis=0), self.slots.max(axis=0)
        return (float(low[0]), float(low[1]), float(high[0]), float(high[1]))


def check_formation(spec: FormationSpec) -> None:
    """Raise the PersonError that `formation_of` would raise; the spec is then cached and later calls are fast."""
    formation_of(spec, max(2, spec.soloists + 2), 0)


def formation_of(spec: FormationSpec, count: int, seed: int = 0) -> Formation:
    """Return the formation of a spec for `count` dancers; the same arguments give bit-identical places.

    There are as many places as dancers, unless the spec has a count, density or spacing; then `waiting` and `empty`
    give the difference. PersonError, naming the field, if the shape cannot be used.
    """
    if spec.like is not None:
        return _like(spec, count, seed)
    if spec.shape == "places":
        return _by_hand(spec, count)
    drawing, line, room, ground = _prepare(spec)
    places_wanted = _place_count(spec, drawing, count)
    soloists = min(spec.soloists, places_wanted)
    others, ways = _other_places(spec, room, ground, places_wanted - soloists, seed, line)
    order, section = _sections(spec, others)
    others = others[order]
    alone = soloist_places(spec, drawing, others, soloists, line)
    middle = np.array(drawing.middle)
    heading = place_headings(spec, others, None if ways is None else ways[order], middle, drawing.curves)
    facing = 0.0 if spec.heading != "angle" else math.radians(spec.heading_deg)
    slots = np.ascontiguousarray(np.concatenate([alone, others]))
    if line is not None:
        on_axis = np.abs(line.signed_distance(slots)) < LINE_TOLERANCE
        slots[on_axis] = line.project(slots[on_axis])
    names = spec.section_names
    closest = closest_distance(slots)
    waiting, empty = max(0, count - places_wanted), max(0, places_wanted - count)
    formation = Formation(
        name=spec.name,
        slots=slots,
        heading=np.concatenate([np.full(soloists, facing), heading]),
        section=np.concatenate([np.full(soloists, NO_SECTION), section]),
        soloist=np.arange(places_wanted) < soloists,
        min_distance=closest,
        unplaced_dancers=waiting,
        empty_places=empty,
        warnings=_warnings(spec, drawing, closest, waiting, empty, others),
        lines=_lines(spec),
        symmetry=line,
        marks=(*[SOLOIST] * soloists, *(names[each] if names else "" for each in section)),
    )
    for array in (formation.slots, formation.heading, formation.section, formation.soloist):
        array.setflags(write=False)
    return formation


def _by_hand(spec: FormationSpec, count: int) -> Formation:
    """Return the formation of places that are written one by one: as many as dancers, the first ones."""
    written = places_by_hand(spec)
    slots = np.ascontiguousarray(written[: max(count, 0)])
    size, waiting = len(slots), max(0, count - len(written))
    soloists = min(spec.soloists, size)
    middle = (written.min(axis=0) + written.max(axis=0)) / 2
    if spec.headings_deg:
        turned = np.radians(np.array(spec.headings_deg) + spec.rotation_deg)[:size]
        heading = np.asarray(np.mod(turned + math.pi, 2.0 * math.pi) - math.pi)
    else:
        heading = place_headings(spec, slots, None, middle, ())
    section = np.full(size, NO_SECTION)
    if spec.sections:
        section[soloists:] = sections_along(section_sizes(spec.sections, size - soloists))
    names, closest = spec.section_names, closest_distance(slots)
    found = [f"{waiting} dancers have no place: add places for them"] if waiting else []
    if closest < TOUCH_DISTANCE:
        found.append(f"two dancers are only {closest:.2f} m apart, bodies touch: move one of them")
    for array in (slots, heading, section):
        array.setflags(write=False)
    soloist = np.arange(size) < soloists
    soloist.setflags(write=False)
    return Formation(
        name=spec.name, slots=slots, heading=heading, section=section, soloist=soloist, min_distance=closest,
        unplaced_dancers=waiting, empty_places=0, warnings=tuple(found), lines=(), symmetry=None,
        marks=tuple(SOLOIST if n < soloists else names[section[n]] if names else "" for n in range(size)),
    )  # fmt: skip


def _like(spec: FormationSpec, count: int, seed: int) -> Formation:
    """Return the formation of a spec that is like another one: as many places as that one has, or as have room."""
    transform, most = transform_of(spec), capacity_of(spec)
    other = formation_of(spec.like, count if most is None else min(count, most), seed)
    size = len(other.slots) if most is None else min(len(other.slots), most)
    before = other.slots[:size]
    found = transformed_places(spec, before, lambda number: formation_of(spec.like, number, seed).slots[:most])
    slots = np.ascontiguousarray(found.points[0])
    heading = other.heading[:size]
    if spec.heading == "along":
        heading = found.turn + math.pi / 2.0
    elif spec.heading != "public":
        middle = (slots.min(axis=0) + slots.max(axis=0)) / 2.0 if size else np.zeros(2)
        heading = place_headings(spec, slots, None, middle, ())
    elif heading.any():  # those who face the public still do
        heading = found.turn - heading if transform.mirror is not None else found.turn + heading
    heading = np.asarray(np.mod(heading + math.pi, 2.0 * math.pi) - math.pi)
    lines = tuple(np.array([*ring, ring[0]]) for ring in transform.into)
    if not lines and size:
        lines = tuple(map_points(transform, line[None], before[None])[0][0] for line in other.lines)
    waiting, words = max(0, count - size), []
    if most is not None and size < count:
        words = [f"the region has room for {most} dancers; {count - size} have no place: make it larger"]
    elif waiting:
        words = [f"{waiting} dancers have no place: {spec.like.name!r} has as many places as it says"]
    if found.kept < WANTED_SHARE:
        words.append(f"{round(100 * (1.0 - found.kept))} of 100 neighbours do not stay neighbours")
    closest = closest_distance(slots)
    if closest < TOUCH_DISTANCE:
        words.append(f"two dancers are only {closest:.2f} m apart, bodies touch: take fewer dancers")
    section, soloist = other.section[:size], other.soloist[:size]
    for array in (slots, heading):
        array.setflags(write=False)
    return Formation(
        name=spec.name, slots=slots, heading=heading, section=section, soloist=soloist, min_distance=closest,
        unplaced_dancers=waiting, empty_places=max(0, size - count), warnings=tuple(words), lines=lines,
        symmetry=None, marks=other.marks[:size],
    )  # fmt: skip


def _place_count(spec: FormationSpec, drawing: Drawing, dancers: int) -> int:
    """Return the number of places, soloists included."""
    if spec.count is not None:
        return spec.count
    if spec.density is None and spec.spacing is None:
        return max(0, dancers)
    if spec.density is not None:
        number = round(spec.density * float(drawing.region.area))
    elif drawing.region is not None:
        number = count_by_spacing(spec, drawing.region, float(spec.spacing or 1.0))
    else:
        gaps = [round(curve.length / float(spec.spacing or 1.0) - sum(curve.gaps)) for curve in drawing.curves]
        ends = [0 if curve.closed else 1 for curve in drawing.curves]
        number = sum(max(gap + end, 0) for gap, end in zip(gaps, ends, strict=True))
    if number + spec.soloists > MAX_DANCERS:
        field = "density" if spec.density is not None else "spacing"
        spec.refuse(field, f"makes {number} places; {MAX_DANCERS} at most")
    return number + spec.soloists


def _other_places(
    spec: FormationSpec,
    drawing: Drawing,
    ground: PlacementRegion | None,
    count: int,
    seed: int,
    line: SymmetryLine | None,
) -> tuple[Float64, Float64 | None]:
    """Return the places of all but the soloists, and for those on lines the direction along the line."""
    if spec.shape == "grid":
        yaw = math.radians(spec.rotation_deg)
        turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
        return staggered_rows(count, spec.size or (8.0, 5.0)) @ turn + np.array(spec.centre), None
    if ground is not None:
        return place_inside(spec, ground, count, seed), None
    if count == 0:
        return np.zeros((0, 2)), np.zeros((0, 2))
    return place_on_lines(spec, drawing, count, line)


def _sections(spec: FormationSpec, others: Float64) -> tuple[Int64, Int64]:
    """Return the order of places section by section, and the section of each place in that order."""
    everybody = np.arange(len(others))
    if not spec.sections:
        return everybody, np.full(len(others), NO_SECTION)
    sizes = section_sizes(spec.sections, len(others))
    on_one_way = not spec.inside and spec.shape != "grid" and spec.mirror is None
    section = sections_along(sizes) if on_one_way else sections_in_area(others, sizes)
    order = np.argsort(section, kind="stable")
    return order, section[order]


@lru_cache(maxsize=64)
def _prepare(spec: FormationSpec) -> tuple[Drawing, SymmetryLine | None, Drawing, PlacementRegion | None]:
    """Return all that is independent of the dancer count: drawing, symmetry line, drawing without central soloists,
    ground.
    """
    drawing = drawing_of(spec)
    line = symmetry_line(spec, drawing)
    room = clear_soloist_area(spec, drawing, line)
    inside = spec.inside and spec.shape != "grid"
    return drawing, line, room, placement_region(spec, room, line) if inside else None


@lru_cache(maxsize=64)
def _lines(spec: FormationSpec) -> tuple[Float64, ...]:
    """Return the lines to draw on the floor; with a symmetry line the kept side and its reflection."""
    drawing, line, _, _ = _prepare(spec)
    if spec.shape == "grid":
        return ()
    if line is None:
        return tuple(curve.points for curve in drawing.curves)
    kept, on_line, _ = clip_drawing(spec, drawing, line)
    halves = [curve.points for curve in kept]
    return (*halves, *(curve.points for curve in on_line), *(line.reflect(points) for points in halves))


def _warnings(
    spec: FormationSpec,
    drawing: Drawing,
    closest: float,
    waiting: int,
    empty: int,
    others: Float64,
) -> tuple[str, ...]:
    found = []
    if waiting:
        found.append(f"{waiting} dancers have no place: give a greater count, or leave it out")
    if empty:
        found.append(f"{empty} places stay empty: give a smaller count, or leave it out")
    if closest < MIN_CLEARANCE:
        what = "bodies touch" if closest < TOUCH_DISTANCE else "ways into it may need steering"
        size = f"make it {MIN_CLEARANCE / closest:.2f} times as large" if closest > 0.01 else "some lines share a place"
        found.append(f"two dancers are only {closest:.2f} m apart, {what}: {size}, or take fewer dancers")
    if 0 < len(others) < len(drawing.curves) and not spec.inside:
        found.append(f"{len(drawing.curves)} lines and only {len(others)} dancers for them: some lines stay empty")
    return tuple(found)
