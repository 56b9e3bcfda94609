"""Random groups, ways, regions and lines, and figures of their transformations."""

import math
import time
from collections.abc import Callable
from typing import Any, Final

import numpy as np
import shapely
from scipy.interpolate import CubicSpline
from scipy.spatial import Delaunay, cKDTree
from shapely import affinity

from live.agents.material.room import Rings, room_of
from live.agents.material.transform import Transform, transform_group
from live.agents.material.ways import fit_ways, sample_ways, transform_ways
from live.cli.bench import Row

FIRST_SEED: Final = 1000
"""Constants were chosen with seeds 0 to 39; figures are of seeds from here on."""
MOMENTS: Final = 49
"""Moments of a motion that are looked at."""
BODY: Final = 0.5
"""Two bodies touch at this distance of their middles [m]."""


def random_group(chance: np.random.Generator, count: int) -> Any:
    """Return places (count, 2) at random in a round, square or slanted area, no two very near."""
    kind, sides = chance.integers(3), chance.uniform(0.7, 1.4, 2) * math.sqrt(count) * 0.75
    places, gap = np.zeros((0, 2)), 0.9
    while len(places) < count:
        at = chance.uniform(-1.0, 1.0, (1, 2))
        if (kind == 0 and (at**2).sum() > 1.0) or (kind == 2 and np.abs(at).sum() > 1.2):
            continue
        at = at * sides
        if not len(places) or np.hypot(*(places - at).T).min() > gap:
            places = np.concatenate([places, at])
        else:
            gap *= 0.999
    return places


def random_region(chance: np.random.Generator, count: int, kind: str) -> Rings:
    """Return a region of 1.2 to 2.5 m² for each dancer: convex, concave (L, U or star) or a ring."""
    area = count * chance.uniform(1.2, 2.5)
    if kind == "convex":
        angle = np.sort(chance.uniform(0.0, 2.0 * math.pi, chance.integers(4, 9)))
        points = np.stack([np.cos(angle) * chance.uniform(0.8, 1.3), np.sin(angle)], axis=1)
        shape: Any = shapely.Polygon(points).convex_hull
        if shape.area < 1.2:
            return random_region(chance, count, kind)
    elif kind == "concave":
        form, (u, v) = chance.integers(3), chance.uniform(0.35, 0.65, 2)
        if form == 0:
            shape = shapely.Polygon([(0, 0), (1, 0), (1, v), (u, v), (u, 1), (0, 1)])
        elif form == 1:
            u = u - 0.1 if u > 0.4 else u
            u = min(u, 0.4)
            shape = shapely.Polygon([(0, 0), (1, 0), (1, 1), (1 - u, 1), (1 - u, v), (u, v), (u, 1), (0, 1)])
        else:
            angle, reach = np.arange(10) * math.pi / 5, np.where(np.arange(10) % 2 == 0, 1.0, chance.uniform(0.5, 0.75))
            shape = shapely.Polygon(np.stack([reach * np.sin(angle), reach * np.cos(angle)], axis=1))
        shape = affinity.scale(shape, chance.uniform(0.8, 1.3), 1)
    else:
        hole = shapely.Point(*chance.uniform(-0.1, 0.1, 2)).buffer(chance.uniform(0.25, 0.45))
        shape = affinity.scale(shapely.Point(0, 0).buffer(1.0).difference(hole), chance.uniform(0.8, 1.3), 1)
    factor = math.sqrt(area / shape.area)
    shape = affinity.scale(shape, factor, factor)
    middle = shape.envelope.centroid
    shape = affinity.translate(shape, -middle.x, -middle.y)
    return tuple(
        tuple((float(x), float(z)) for x, z in ring.coords[:-1]) for ring in (shape.exterior, *shape.interiors)
    )


def random_line(chance: np.random.Generator, length: float) -> tuple[tuple[float, float], ...]:
    """Return a curved line of about this length [m]."""
    bends, share = chance.uniform(-0.12, 0.12, 5), np.linspace(0.0, 1.0, 60)
    points = np.stack([share, CubicSpline(np.linspace(0.0, 1.0, 5), bends)(share)], axis=1) * length
    return tuple((float(x), float(z)) for x, z in points)


def random_ways(chance: np.random.Generator, places: Any) -> Any:
    """Return the places of a flock (MOMENTS, D, 2) that drifts, turns and breathes from its places (D, 2)."""
    share = np.linspace(0.0, 1.0, MOMENTS)

    def curve(size: float) -> Any:
        return CubicSpline(np.linspace(0.0, 1.0, 5), np.concatenate([[0.0], chance.uniform(-size, size, 4)]))(share)

    turn, breath, drift = curve(0.8), 1.0 + curve(0.15), np.stack([curve(3.0), curve(3.0)], axis=1)
    around = np.stack([np.stack([np.cos(turn), -np.sin(turn)], 1), np.stack([np.sin(turn), np.cos(turn)], 1)], axis=1)
    own = np.stack([np.stack([curve(0.15), curve(0.15)], axis=1) for _ in places], axis=1)
    return np.einsum("sij,dj->sdi", around, places) * breath[:, None, None] + drift[:, None] + own


def strictly_kept(before: Any, after: Any) -> float:
    """Return the share of the edges of the Delaunay graph of `before` (D, 2) that are edges of that of `after`."""
    first, now = _edges(before), _edges(after)
    return len(first & now) / len(first)


def _edges(places: Any) -> set[tuple[int, int]]:
    corners = np.sort(Delaunay(places).simplices, axis=1)
    return {(int(a), int(b)) for a, b in np.concatenate([corners[:, :2], corners[:, 1:], corners[:, [0, 2]]])}


def least_distance(places: Any) -> float:
    """Return the least distance of two of `places` (D, 2) [m]."""
    return float(cKDTree(places).query(places, k=2)[0][:, 1].min())


Case = Callable[[np.random.Generator, Any], Transform]


def _into(kind: str) -> Case:
    return lambda chance, places: Transform(into=random_region(chance, len(places), kind))


def _bend(chance: np.random.Generator, places: Any) -> Transform:
    width, depth = np.ptp(places, axis=0)
    deepest = math.degrees(1.5 * width / depth)
    return Transform(bend_deg=min(float(chance.uniform(30.0, 120.0)), deepest) * float(chance.choice([-1.0, 1.0])))


def _along(chance: np.random.Generator, places: Any) -> Transform:
    length = float(np.ptp(places[:, 0]) * chance.uniform(0.8, 1.4))
    return Transform(along=random_line(chance, length), proportions="stretch")


def _stretch(chance: np.random.Generator, _places: Any) -> Transform:
    return Transform(scale=(float(chance.uniform(0.7, 1.8)), float(chance.uniform(0.7, 1.8))), neighbours="keep")


CASES: Final[dict[str, Case]] = {
    "into convex": _into("convex"), "into concave": _into("concave"), "into a ring": _into("ring"),
    "bent": _bend, "along a line": _along, "stretched": _stretch,
}  # fmt: skip


def material_rows(seeds: range) -> list[Row]:
    """Return the figures of transformations of 20 to 100 dancers, and of ways of flocks."""
    rows: list[Row] = []
    for name, case in CASES.items():
        figures = []
        for seed in seeds:
            chance = np.random.default_rng(seed)
            places = random_group(chance, int(chance.integers(20, 101)))
            transform = case(chance, places)
            if transform.into and room_of(transform.into).capacity < len(places):
                continue
            begin = time.process_time()
            now = transform_group(transform, places[None]).points[0]
            took = time.process_time() - begin
            inside = room_of(transform.into).contains(now, 2e-3).mean() if transform.into else 1.0
            figures.append((strictly_kept(places, now), inside, least_distance(now), took))
        rows += _rows(name, np.array(figures))
    return rows + _way_rows(seeds)


def _rows(name: str, figures: Any) -> list[Row]:
    kept, inside, least, took = figures.T
    rows = [
        Row(f"{name}: neighbours kept", 100.0 * kept.mean(), "%", 95.0, "at least"),
        Row(f"{name}: groups with 95 % kept", 100.0 * (kept >= 0.95).mean(), "%"),
        Row(f"{name}: least distance", least.min(), "m", BODY, "at least"),
        Row(f"{name}: median time", 1000.0 * float(np.median(took)), "ms"),
        Row(f"{name}: longest time", 1000.0 * took.max(), "ms"),
    ]
    if "into" in name:
        rows.insert(2, Row(f"{name}: inside", 100.0 * inside.mean(), "%", 100.0, "at least"))
    return rows


def _way_rows(seeds: range) -> list[Row]:
    fits, figures = [], []
    for seed in seeds:
        chance = np.random.default_rng(seed)
        walked = random_ways(chance, random_group(chance, int(chance.integers(20, 51))))
        fitted = fit_ways(walked)
        fits.append((100.0 * fitted.error, np.mean([len(way) for way in fitted.ways])))
        flock = sample_ways(fitted.ways, MOMENTS)
        transform = Transform(into=random_region(chance, 2 * flock.shape[1], "convex"))
        begin = time.process_time()
        now = sample_ways(transform_ways(transform, fitted.ways), MOMENTS)
        took = time.process_time() - begin
        kept = np.mean([strictly_kept(a, b) for a, b in zip(flock, now, strict=True)])
        inside = room_of(transform.into).contains(now.reshape(-1, 2), 2e-2).mean()
        figures.append((kept, inside, min(least_distance(each) for each in now), took))
    error, points = np.array(fits).T
    found = _rows("ways into convex", np.array(figures))
    before = [
        Row("fitted ways: greatest error", error.max(), "cm", 5.0),
        Row("fitted ways: points of each", points.mean(), "", note=f"for {MOMENTS} recorded places"),
    ]
    return before + found
