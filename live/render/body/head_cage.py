"""Cage of the head: a closed mesh of quadrilaterals with edge loops around eyes and mouth, in the rest pose.

The left half is a grid of rows, from the neck to the crown, by columns, from the middle of the face to the back of the
head. Two holes are cut into it: one of 2 x 2 faces around the eye, one around half of the mouth. Loops lead from their
borders to the edges of lids and lips and inside. The cage without holes is for levels of detail whose eyes and mouth
are only painted.

Proportions follow the canon of drawing (Loomis, Drawing the Head and Hands, 1956; Farkas, Anthropometry of the Head
and Face, 1994): eyes at half of the head's height, an eye's width between the eyes, equal thirds from hairline to brow,
to the base of the nose, to the chin; ears between brow and base of the nose.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Float64, Int64
from live.render.body.closed_meshes import spline

Point = tuple[float, float, float]

EYE_CENTRE: Final[Point] = (0.0310, 1.5940, 0.0648)
"""Centre of the left eyeball [m]."""
EYE_RADIUS: Final = 0.0126
"""Radius of the eyeballs [m]."""
CHIN: Final = 1.4880
"""Height of the chin's lowest point [m]; the crown is at 1.70."""
_UPPER_LID: Final = 0.0140
_LOWER_LID: Final = 0.0136
"""Distances of the lids' edges from the eye's centre [m]."""
_OUTLINE_COLUMNS: Final = 11

# Millimetres: x, height above 1400, z; columns from the middle of the face to the middle of the back.
_GRID_MM: Final[tuple[tuple[Point, ...], ...]] = (
    # neck, twice: put on the body's surface later
    ((0, 12, 44), (9, 13, 43), (19, 17, 38), (28, 24, 30), (35, 31, 20), (41, 37, 6), (46, 41, -8), (48, 43, -24),
     (44, 43, -42), (29, 42, -58), (0, 42, -66)),
    ((0, 42, 37), (9, 42, 36), (18, 44, 32), (26, 47, 26), (33, 51, 18), (38, 59, 8), (42, 64, -5), (44, 66, -20),
     (42, 66, -37), (29, 65, -54), (0, 64, -62)),
    # below the chin
    ((0, 78, 43), (9, 77.5, 42), (17, 77, 39.5), (23.5, 76, 35), (29, 75.5, 29.5), (35, 75, 20), (39.5, 74, 7),
     (42.5, 77, -12), (42, 76, -32), (31, 75, -52), (0, 75, -62)),
    ((0, 87, 69), (9, 87.5, 68), (16.5, 89, 62.5), (22.5, 90.5, 55), (28, 92, 46.5), (35, 94.5, 31.5), (40.5, 96, 13.5),
     (44, 87, -9), (43, 87, -30), (32, 86, -52.5), (0, 86, -62.5)),
    # edge of the jaw
    ((0, 92.5, 86.5), (9.5, 93, 84.8), (18.5, 95.3, 77.5), (26.5, 97.5, 69), (33, 99.5, 59.5), (41.5, 102, 40.5),
     (46.5, 105, 19), (47.5, 95.5, -5), (45.5, 97, -29), (33, 97, -53), (0, 97, -63.5)),
    ((0, 102.5, 90.0), (10.5, 103, 88.4), (21.5, 105, 80.8), (30.5, 106.3, 72.6), (38, 107.5, 62.5),
     (46.5, 109.5, 42.0),
     (51.5, 111.5, 20.5), (51, 103, -3), (48, 105.5, -28), (34, 106, -54), (0, 106, -65)),
    # below the mouth, at its corner (the first two are in the hole), above it
    ((0, 112.3, 85.8), (11.5, 112.9, 84.6), (26, 116.0, 78.4), (34.5, 117, 72.6), (41.5, 117, 63.6),
     (50.5, 117.5, 43.2),
     (55.0, 119, 21.5), (54, 111, -2), (50.5, 113.5, -28), (35, 114, -55), (0, 114, -66.5)),
    ((0, 127.4, 94.2), (12, 127.2, 91.4), (29.3, 126.6, 78.2), (37, 127, 73.6), (44, 127.2, 65.2), (54, 127.5, 44.6),
     (58.5, 128, 22.5), (57.5, 120, -1), (53.5, 121.5, -29), (37, 122, -57), (0, 122, -69)),
    ((0, 141.2, 91.4), (11.5, 140.6, 89.8), (27.2, 137.2, 80.4), (35.5, 137, 75.8), (44.8, 137.4, 67.4),
     (56.5, 138, 46.4),
     (61.5, 138, 23.5), (61, 131, 0), (57, 129, -31), (39.5, 129, -61), (0, 129, -73)),
    # base of the nose, below its tip, its tip
    ((0, 147.6, 90.6), (7.6, 147.8, 89.8), (14.2, 147.4, 85.4), (26, 145.5, 81.4), (43.8, 147.5, 70.0),
     (58.8, 149, 48.4),
     (64.0, 149, 25), (64, 143, 0), (60.5, 142, -34), (42, 142, -66), (0, 142, -78)),
    ((0, 152.0, 105.2), (6.6, 151.4, 100.4), (15.8, 152.0, 90.6), (24.2, 153.0, 82.6), (44.2, 157, 72.0),
     (60.6, 160, 50.4),
     (66.0, 160, 26), (66.5, 155, 0), (64, 154, -37), (45, 154, -71), (0, 154, -84)),
    ((0, 159.2, 109.4), (6.2, 159.2, 105.0), (14.6, 158.8, 90.4), (23.8, 160.4, 82.0), (43.8, 164, 73.2),
     (61.6, 167.5, 51.4),
     (67.2, 167.5, 26.5), (68, 164, 0), (66.5, 164, -39), (47, 164, -75), (0, 164, -88.5)),
    # bridge of the nose and cheekbone
    ((0, 171.0, 102.4), (6.6, 171.0, 96.6), (12.6, 170.4, 84.0), (27.4, 170.6, 79.2), (46.4, 172.6, 71.6),
     (61.4, 175.5, 51.8),
     (67.6, 175.5, 26.8), (69, 174, 0), (68.5, 174, -40.5), (48.5, 174, -79), (0, 174, -92.5)),
    # below, at, and above the eye
    ((0, 182.4, 95.0), (6.0, 182.0, 89.8), (12.4, 182.4, 79.6), (31.0, 178.6, 77.6), (49.0, 181.4, 68.4),
     (60.6, 184.5, 51.4),
     (67.6, 184.5, 27.2), (70, 184, 0), (70.5, 184, -42), (50, 184, -82), (0, 184, -95.5)),
    ((0, 195.4, 87.8), (6.0, 195.2, 85.0), (11.2, 194.8, 78.6), (31.0, 194.0, 77.8), (50.2, 194.8, 62.0),
     (59.6, 195.5, 50.4),
     (67.4, 195.5, 27.6), (71.2, 195, -0.5), (72.2, 195, -42.5), (51, 195, -84), (0, 195, -97.5)),
    ((0, 208.0, 89.0), (7.2, 208.0, 88.2), (15.0, 207.4, 84.8), (31.6, 209.6, 80.8), (48.6, 208.0, 69.6),
     (59.8, 206.5, 52.4),
     (67.4, 206.5, 28), (72.0, 206.5, -1), (73.2, 206.5, -43), (51.5, 206.5, -85.5), (0, 206.5, -99)),
    # forehead and skull
    ((0, 221.5, 90.2), (8.6, 221.5, 89.8), (18.0, 221.5, 87.6), (32.8, 222.0, 81.4), (47.8, 221.0, 69.4),
     (59.4, 219.5, 52.4),
     (68.0, 219.5, 27.6), (73.0, 219.5, -2), (74, 219.5, -43.5), (52, 219.5, -86), (0, 219.5, -100)),
    ((0, 242.5, 86.4), (9.2, 242.5, 85.9), (19.0, 242.5, 83.8), (33.2, 242.5, 77.4), (47.4, 241.8, 65.6),
     (59.0, 240.5, 48.8),
     (68.0, 240.5, 24.6), (73.2, 240.5, -4.5), (73.6, 240.5, -44.5), (51.5, 240.5, -85), (0, 240.5, -98.5)),
    ((0, 266.0, 73.4), (8.8, 266.0, 72.9), (17.6, 266.0, 70.6), (30.0, 265.6, 64.4), (42.2, 265.0, 53.6),
     (52.8, 264.2, 38.2),
     (60.8, 263.6, 16.4), (65.0, 263.4, -9.5), (63.8, 263.4, -45), (44.0, 263.4, -79.5), (0, 263.4, -92)),
    ((0, 284.6, 51.6), (7.4, 284.6, 51.0), (14.6, 284.4, 48.8), (24.6, 284.0, 43.2), (34.2, 283.4, 33.4),
     (42.2, 282.4, 20.2),
     (48.2, 281.6, 3), (50.6, 281.2, -16), (48.2, 281.2, -42), (33.2, 281.2, -66.5), (0, 281.2, -77)),
    ((0, 296.0, 22.4), (4.4, 296.0, 21.8), (8.6, 295.9, 20.0), (14.4, 295.8, 16.2), (19.8, 295.6, 10.6),
     (24.2, 295.3, 3),
     (27.0, 295.0, -6), (27.6, 294.9, -16), (25.6, 294.9, -29), (17.6, 294.9, -41), (0, 294.9, -47)),
)  # fmt: skip
_NECK_ROWS: Final = 2
_MOUTH: Final = (6, 8, 0, 2)
_EYE: Final = (13, 15, 2, 4)
"""Holes: first and last row, first and last column."""
_MOUTH_CORNER: Final = (7, 2)

# Around the eye from the inner lower corner outwards and up: offsets from its centre in the plane of the face [mm].
_MARGIN: Final = (
    (-8.2, -4.3),
    (0.4, -5.3),
    (8.6, -3.8),
    (14.6, 0.9),
    (8.6, 3.3),
    (-0.6, 4.0),
    (-8.6, 2.8),
    (-14.4, -1.4),
)
_FOLD: Final = (
    (-10.6, -7.4),
    (0.4, -9.8),
    (11.4, -7.2),
    (17.2, 1.2),
    (11.6, 7.2),
    (-0.4, 8.8),
    (-11.4, 6.6),
    (-17.2, -1.4),
)
_MARGIN_DEPTH: Final = {3: 2.2, 7: 6.2}
"""Corners of the eye: place in the loop, and how far the margin lies before the eye's centre [mm]; …"""
_FOLD_DEPTH: Final = {0: 9.6, 3: -1.4, 6: 10.6, 7: 8.4}
"""… and the fold, where it does not follow the eyeball."""
_UPPER: Final = (4, 5, 6)
_LOWER: Final = (0, 1, 2)

# Loops of half the mouth, from the middle of the upper lip around the corner [mm as above].
_LIP_LOOPS: Final[tuple[tuple[Point, ...], ...]] = (
    # border of the lips, their middle, where they touch, behind them, the cavity
    ((0, 136.4, 95.2), (7.6, 136.9, 93.6), (18.0, 131.9, 87.6), (24.8, 127.6, 80.8), (18.6, 121.2, 86.4),
     (9.0, 118.1, 90.6),
     (0, 117.4, 91.2)),
    ((0, 131.9, 97.0), (8.4, 132.2, 95.2), (18.0, 129.9, 89.0), (24.4, 127.6, 81.2), (18.4, 124.0, 88.6),
     (9.0, 122.4, 94.2),
     (0, 122.0, 95.2)),
    ((0, 127.3, 94.6), (8.6, 127.3, 92.8), (17.8, 127.3, 87.8), (24.0, 127.5, 81.0), (17.8, 127.9, 87.8),
     (8.6, 128.0, 92.4),
     (0, 128.0, 94.0)),
    ((0, 129.6, 86.6), (8.4, 129.4, 85.2), (16.6, 128.4, 81.0), (22.0, 127.5, 77.0), (16.6, 126.4, 80.6),
     (8.4, 125.4, 84.6),
     (0, 125.4, 86.0)),
    ((0, 133.0, 68.0), (9.0, 133.0, 67.0), (16.0, 130.5, 64.0), (19.0, 127.3, 63.0), (16.0, 123.5, 63.5),
     (9.0, 120.5, 66.0),
     (0, 120.5, 67.0)),
)  # fmt: skip
_CAVITY_MIDDLE: Final[tuple[Point, Point]] = ((0.0, 127.0, 62.0), (9.0, 127.0, 61.0))

EYE_LOOPS: Final = ("fold", "lid", "margin", "edge", "behind")
MOUTH_LOOPS: Final = ("border", "lip", "touch", "within", "cavity")


def grid_points(row: Float64, column: Float64) -> Float64:
    """Return places on the left half of the usual head by fractional rows and columns of its grid, shape (N, 3) [m]."""
    grid = np.array(_GRID_MM) / 1000.0 + np.array([0.0, 1.4, 0.0])
    mirrored = grid[:, ::-1] * np.array([-1.0, 1.0, 1.0])
    ring = np.concatenate(
        [mirrored[:, -2:-1], grid, mirrored[:, 1:2]], axis=1
    )  # one column beyond the middle, each side
    low = np.clip(np.floor(row).astype(np.int64), 0, len(grid) - 2)
    around = [_cubic(ring[np.clip(low + step, 0, len(grid) - 1)], column + 1.0) for step in (-1, 0, 1, 2)]
    return spline(around, (row - low)[:, None])


def _cubic(rows: Float64, at: Float64) -> Float64:
    """Return a point of each row (N, C, 3) at fractional columns (N,), by Catmull and Rom's splines (1974)."""
    low = np.clip(np.floor(at).astype(np.int64), 1, rows.shape[1] - 3)
    t = (at - low)[:, None]
    return spline([rows[np.arange(len(rows)), low + step] for step in (-1, 0, 1, 2)], t)


@dataclass(frozen=True, slots=True, eq=False)
class HeadCage:
    """The cage (V corners, F faces); the left half's corners come first."""

    points: Float64
    """[m], shape (V, 3)."""
    faces: Int64
    """Counter-clockwise seen from outside, shape (F, 4)."""
    loops: dict[str, Int64]
    """Corners of the left half by place: `row N`, `fold` … (around the eye), `border` … (around half the mouth)."""
    mirror: Int64
    """For each corner its mirror image, shape (V,)."""


class _Half:
    """Builder of the left half."""

    def __init__(self) -> None:
        self.points: list[Point] = []
        self.faces: list[tuple[int, int, int, int]] = []
        self.loops: dict[str, list[int]] = {}

    def add(self, point: Point) -> int:
        self.points.append(point)
        return len(self.points) - 1

    def loop(self, name: str, points: list[Point]) -> list[int]:
        self.loops[name] = [self.add(point) for point in points]
        return self.loops[name]

    def bridge(self, outer: list[int], inner: list[int], *, closed: bool) -> None:
        """Faces between two loops that run counter-clockwise around a hole."""
        count = len(outer)
        for i in range(count if closed else count - 1):
            j = (i + 1) % count
            self.faces.append((outer[i], outer[j], inner[j], inner[i]))

    def lid(self, chain: list[int], heights: Callable[[float], Point], *, up: bool) -> None:
        """Close a row of the grid with points along the middle plane, at shares 0 to 1 from front to back."""
        last = len(chain) - 1
        middle = [self.add(heights(k / (last - 2))) for k in range(1, last - 2)]
        rows = [(chain[0], chain[1], chain[2], middle[0])]
        rows += [(middle[k], chain[k + 2], chain[k + 3], middle[k + 1]) for k in range(len(middle) - 1)]
        rows.append((middle[-1], chain[last - 2], chain[last - 1], chain[last]))
        self.faces += rows if up else [tuple(reversed(row)) for row in rows]  # type: ignore[misc]


def _metres(point: Point) -> Point:
    return point[0] / 1000.0, 1.4 + point[1] / 1000.0, point[2] / 1000.0


def _eye_point(across: float, up: float, radius: float, depth: float | None, open_: float, tilt: float) -> Point:
    """Return a point on a sphere about the eye's centre, by its offsets in the plane of the face [mm]."""
    c, s = np.cos(tilt), np.sin(tilt)
    up *= open_
    x, y = (c * across - s * up) / 1000.0, (s * across + c * up) / 1000.0
    z = depth / 1000.0 if depth is not None else float(np.sqrt(max(radius**2 - x * x - y * y, 1e-8)))
    return EYE_CENTRE[0] + x, EYE_CENTRE[1] + y, EYE_CENTRE[2] + z


def _eye_loops(half: _Half, border: list[int], open_: float, tilt: float) -> None:
    previous = border
    for name in EYE_LOOPS:
        points = []
        for place in range(8):
            radius = _UPPER_LID if place in _UPPER else _LOWER_LID
            if name in ("fold", "lid"):
                share = 1.0 if name == "fold" else 0.5  # from the margin to the fold
                ends = zip(_MARGIN[place], _FOLD[place], strict=True)
                across, up = (margin + share * (fold - margin) for margin, fold in ends)
                swell = (0.0013 if place in _UPPER else 0.0017) * share
                depth = _FOLD_DEPTH.get(place)
                if depth is not None and name == "lid":
                    flat = np.hypot(across, up) / 1000.0
                    free = _MARGIN_DEPTH.get(place, 1000.0 * float(np.sqrt(max(radius**2 - flat**2, 0.0))))
                    depth = 0.5 * (depth + free) if place in _MARGIN_DEPTH else free + 0.3 * max(depth - free, 0.0)
                open_share = 1.0 + (open_ - 1.0) * (1.0 - share)
                points.append(_eye_point(across, up, radius + swell, depth, open_share, (1.0 - 0.5 * share) * tilt))
                continue
            across, up = _MARGIN[place]
            depth = _MARGIN_DEPTH.get(place)
            if name == "edge":  # the lid's thickness
                across, up, radius = across * 0.985, up - (0.35 if place in _UPPER else -0.35), EYE_RADIUS + 0.0002
                depth = None if depth is None else depth - 0.4
            elif name == "behind":
                across, up, radius = across * 0.76, up * 0.9, 0.0104
                depth = None if depth is None else depth - 1.2
            points.append(_eye_point(across, up, radius, depth, open_, tilt))
        loop = half.loop(name, points)
        half.bridge(previous, loop, closed=True)
        previous = loop
    half.faces += [tuple(previous[k] for k in four) for four in ((0, 1, 2, 3), (0, 3, 4, 7), (4, 5, 6, 7))]  # type: ignore[misc]


def _mouth_loops(half: _Half, border: list[int]) -> None:
    previous = border
    for name, loop in zip(MOUTH_LOOPS, _LIP_LOOPS, strict=True):
        made = half.loop(name, [_metres(point) for point in loop])
        half.bridge(made, previous, closed=False)
        previous = made
    m, q = (half.add(_metres(point)) for point in _CAVITY_MIDDLE)
    a, b, c, d, e, f, g = previous
    half.faces += [(a, m, q, b), (b, q, d, c), (d, q, f, e), (q, m, g, f)]


def build_head_cage(*, holes: bool = True, eye_open: float = 1.0, eye_tilt: float = 0.0) -> HeadCage:
    """Return the cage of the usual head; `holes`: with open eyes and mouth; `eye_open`: factor of the lids' distance;
    `eye_tilt`: how far the outer corners of the eyes are turned up [rad]."""
    half = _Half()
    rows: list[list[int]] = []
    removed = {(7, 0), (7, 1), (14, 3)} if holes else set()
    for number, row in enumerate(_GRID_MM):
        rows.append([-1 if (number, c) in removed else half.add(_metres(p)) for c, p in enumerate(row)])
        half.loops[f"row {number}"] = [one for one in rows[-1] if one >= 0]

    def in_hole(r: int, c: int) -> bool:
        return holes and any(a <= r < b and left <= c < right for a, b, left, right in (_MOUTH, _EYE))

    for r in range(len(rows) - 1):
        for c in range(_OUTLINE_COLUMNS - 1):
            if not in_hole(r, c):
                half.faces.append((rows[r][c], rows[r][c + 1], rows[r + 1][c + 1], rows[r + 1][c]))
    half.lid(rows[-1], lambda s: (0.0, 1.6965 + 0.0035 * float(np.sin(np.pi * s)), 0.014 - 0.050 * s), up=True)
    half.lid(rows[0], lambda s: (0.0, 1.405, 0.034 - 0.086 * s), up=False)
    if holes:
        a, b, left, right = _EYE
        around = [
            (a, left),
            (a, left + 1),
            (a, right),
            (a + 1, right),
            (b, right),
            (b, left + 1),
            (b, left),
            (a + 1, left),
        ]
        _eye_loops(half, [rows[r][c] for r, c in around], eye_open, eye_tilt)
        a, b, _, right = _MOUTH
        around = [(b, 0), (b, 1), (b, right), (a + 1, right), (a, right), (a, 1), (a, 0)]
        _mouth_loops(half, [rows[r][c] for r, c in around])
    return _whole(half)


def _whole(half: _Half) -> HeadCage:
    points = np.array(half.points)
    faces = np.array(half.faces, np.int64)
    middle = points[:, 0] == 0.0
    other = np.arange(len(points))
    other[~middle] = len(points) + np.arange(int((~middle).sum()))
    mirror = np.concatenate([other, np.flatnonzero(~middle)])
    both = np.concatenate([faces, other[faces][:, [0, 3, 2, 1]]])
    whole = np.concatenate([points, points[~middle] * np.array([-1.0, 1.0, 1.0])])
    loops = {name: np.array(loop, np.int64) for name, loop in half.loops.items()}
    return HeadCage(whole, both, loops, mirror)
