"""Formations that are like another one: its places scaled, bent, mirrored, along a line or in a region (T145, T087).

An edit of the other formation changes them too.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final

import numpy as np
import shapely

from live.agents.formations.drawing import Drawing, drawing_of
from live.agents.formations.formation_notation import parse_formation
from live.agents.formations.formation_spec import FormationSpec, spec_from_table
from live.agents.formations.symmetry import symmetry_line
from live.agents.groups.roster import Line
from live.agents.material.deformation import finish
from live.agents.material.room import LEAST_GAP
from live.agents.material.transform import Transform, Transformed, room_for, transform_group, warp_between
from live.base.arrays import Float64
from live.base.errors import PersonError

MAX_TRANSFORMED: Final = 400
"""Most dancers whose places are deformed as one; the places of more follow from those of so many."""
MAX_DEPTH: Final = 16
"""Longest row of formations that are each like the next one."""

_NO_DRAWING: Final = Drawing((), None, (0.0, 0.0))

Find = Callable[[str], FormationSpec]
"""Returns the formation of a name or of words; PersonError if there is none."""


def specs_from_tables(tables: Sequence[Mapping[str, Any]], counts: Sequence[int] = ()) -> list[FormationSpec]:
    """Return the specs of all formations of a patch, those that are like others with the specs of these.

    `counts` are the numbers of dancers that are computed ahead. PersonError, naming formation and key, if one is
    invalid, unknown, or like itself.
    """
    written = [spec_from_table(table) for table in tables]
    index = {spec.name.casefold().strip(): number for number, spec in enumerate(written)}
    found: dict[int, FormationSpec] = {}

    def resolve(number: int, above: tuple[int, ...]) -> FormationSpec:
        if number not in found:
            spec = written[number]
            if number in above or len(above) >= MAX_DEPTH:
                names = " → ".join(repr(written[each].name) for each in (*above, number))
                spec.refuse("like", f"leads back to itself or too far: {names}")
            spec = resolved(spec, lambda words: find(words, (*above, number)))
            found[number] = replace(spec, counts_ahead=tuple(counts)) if spec.like is not None else spec
        return found[number]

    def find(words: str, above: tuple[int, ...]) -> FormationSpec:
        number = index.get(words.casefold().strip())
        return parse_formation(words) if number is None else resolve(number, above)

    specs = []
    for number in range(len(written)):
        try:
            specs.append(resolve(number, ()))
        except PersonError as error:
            raise PersonError(error.message, error.remedy, ("formation", number)) from None
    return specs


def resolved(spec: FormationSpec, find: Find) -> FormationSpec:
    """Return a spec with the formations, lines and regions that it names. PersonError if there is no such one."""
    if spec.like is None:
        return spec
    changes: dict[str, Any] = {}
    if isinstance(spec.like, str):
        changes["like"] = _found(spec, "like", spec.like, find)
    if isinstance(spec.along, str):
        other = _found(spec, "along", spec.along, find)
        curves = drawing_of(other).curves if other.like is None and other.shape not in ("grid", "places") else ()
        if len(curves) != 1:
            spec.refuse(
                "along", f"{spec.along!r} is not one line", "a formation with shape line, arc, path or polyline"
            )
        changes["along"] = tuple((float(x), float(z)) for x, z in curves[0].points)
    if isinstance(spec.into, str):
        other = _found(spec, "into", spec.into, find)
        if other.like is not None or other.shape in ("grid", "places"):
            spec.refuse("into", f"{spec.into!r} has no closed line", "a formation with a closed shape, or points")
        region = drawing_of(replace(other, dancers="inside", pattern=None, mirror=None, mirror_at=None)).region
        changes["into"] = tuple(
            tuple((float(x), float(z)) for x, z in shapely.get_coordinates(ring)[:-1])
            for part in shapely.get_parts(region)
            for ring in (part.exterior, *part.interiors)
        )
    return replace(spec, **changes)


def _found(spec: FormationSpec, field: str, words: str, find: Find) -> FormationSpec:
    try:
        return find(words)
    except PersonError as error:
        if error.message.startswith("formation "):  # it names the one that is wrong
            raise
        return spec.refuse(field, error.message, error.remedy)


def transform_of(spec: FormationSpec) -> Transform:
    """Return what a formation does with the places of the one that it is like. PersonError if a name is not known."""
    for field in ("like", "along", "into"):
        if isinstance(getattr(spec, field), str):
            spec.refuse(field, "names another formation, and there is none here", "use it in a patch")
    line = None
    if spec.mirror is not None:
        axis = symmetry_line(spec, _NO_DRAWING)
        assert axis is not None
        line = Line(float(axis.point[0]), float(axis.point[1]), math.atan2(*axis.direction))
    scale = spec.scale if isinstance(spec.scale, tuple) else (spec.scale, spec.scale)
    return Transform(
        scale, spec.size, spec.proportions, spec.bend_deg, spec.rotation_deg, spec.centre, line, spec.along, spec.into,
        spec.neighbours,
    )  # fmt: skip


def capacity_of(spec: FormationSpec) -> int | None:
    """Return how many dancers fit into a formation that is squeezed into a region; None if it is not."""
    transform = transform_of(spec)
    try:
        room = room_for(transform)
    except PersonError as error:
        spec.refuse("into", error.message, error.remedy)
    return None if room is None else room.capacity


def transformed_places(spec: FormationSpec, places: Float64, seed_places: Callable[[int], Float64]) -> Transformed:
    """Return the `places` (S, 2) [m] of a formation as they are in `spec`, which is like it.

    `seed_places` returns its places for other numbers of dancers. For numbers that are not computed ahead, places
    follow the map from the nearest number that is. PersonError if the transformation does not suit the group.
    """
    transform = transform_of(spec)
    ahead = [count for count in spec.counts_ahead if count >= 2]
    many = len(places) > MAX_TRANSFORMED
    if not transform.into or not (many or (ahead and len(places) not in spec.counts_ahead)):
        return _transformed(spec, transform, places)
    room = room_for(transform)
    assert room is not None
    most = min(MAX_TRANSFORMED, room.capacity)
    near = min((min(count, most) for count in ahead or [most]), key=lambda count: (abs(count - len(places)), count))
    known = seed_places(near)
    around = _transformed(spec, transform, known)
    moved = finish(warp_between(known, around.points[0])(places), room, LEAST_GAP)
    return Transformed(np.round(moved, 3)[None], np.zeros(len(places)), around.kept, LEAST_GAP)


@lru_cache(maxsize=256)
def _solved(transform: Transform, places: bytes) -> Transformed:
    """Return the `places` of a group transformed; other numbers of dancers begin from the same ones again and again."""
    found = transform_group(transform, np.frombuffer(places).reshape(1, -1, 2))
    found.points.setflags(write=False)
    return found


def _transformed(spec: FormationSpec, transform: Transform, places: Float64) -> Transformed:
    try:
        return _solved(transform, np.ascontiguousarray(places, np.float64).tobytes())
    except PersonError as error:
        if error.message.startswith("bend_deg"):
            raise PersonError(f"formation {spec.name!r}: {error.message}", error.remedy) from None
        spec.refuse("into" if transform.into else "along", error.message.removeprefix("along: "), error.remedy)
