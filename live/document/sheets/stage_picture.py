"""A picture of the stage from above on a page: floor with metres along its front, set, gates, ways and marks."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.agents.entrances.gate import Gate
from live.base.arrays import Float64
from live.document.sheets.group_marks import GroupMark, draw_mark
from live.document.sheets.page import BLACK, FAINT, SMALL, WHITE, Ink, Page, Point, grey, text_width
from live.show.group.stage_area import gates_of
from live.show.patch.patch import Patch

SPARE_M: Final = 0.45
"""Space around the stage [m]: marks at its edge are whole."""
FOOT: Final = 20.0
"""Height of the metres and of the word below the stage [pt]."""
GRID: Final = grey(0.86)
SET: Final = grey(0.80)
WAY: Final = grey(0.42)
NUMBER_RADIUS: Final = 7.6
"""Radius of a mark that has room for a number of two digits [pt]."""
LEAST_RADIUS: Final = 2.2
HEAD: Final = 4.6
"""Length of an arrow's head [pt]."""


@dataclass(frozen=True, slots=True)
class StagePlan:
    """The stage as all pictures show it."""

    half: tuple[float, float]
    """Half width and half depth [m]."""
    low: tuple[float, float]
    """Least x and z that a picture shows [m]."""
    high: tuple[float, float]
    gates: tuple[Gate, ...]
    discs: tuple[tuple[float, float, float], ...]
    """Round obstacles: x, z, radius [m]."""
    walls: tuple[tuple[Point, Point], ...]

    @staticmethod
    def of(patch: Patch, places: Float64) -> "StagePlan":
        """Return the plan of a patch's stage, large enough for these places (P, 2) [m]."""
        half = np.array([patch.stage.width, patch.stage.depth]) / 2.0
        inside = places[np.isfinite(places).all(axis=1)]
        far = np.vstack([inside, -half, half]) if len(inside) else np.vstack([-half, half])
        low, high = far.min(axis=0) - SPARE_M, far.max(axis=0) + SPARE_M
        return StagePlan(
            (float(half[0]), float(half[1])), (float(low[0]), float(low[1])), (float(high[0]), float(high[1])),
            gates_of(patch, float(half[0]), float(half[1])) if patch.gate else (),
            tuple((*one.at, one.radius) for one in patch.obstacle if one.wall_to is None),
            tuple((one.at, one.wall_to) for one in patch.obstacle if one.wall_to is not None),
        )  # fmt: skip

    @property
    def size(self) -> tuple[float, float]:
        """Width and depth that a picture shows [m]."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    def height_for(self, width: float) -> float:
        """Return the height of a picture of this width [pt]."""
        return width * self.size[1] / self.size[0] + FOOT


class StagePicture:
    """Draws one picture. Draw the floor first, then ways, marks, and labels last."""

    def __init__(self, page: Page, plan: StagePlan, corner: Point, width: float) -> None:
        """`corner`: the upper left one [pt]."""
        self._page, self._plan, self._corner = page, plan, corner
        self.scale = width / plan.size[0]
        """Points of a metre."""
        self.width, self.height = width, plan.height_for(width)
        self._taken: list[tuple[float, float, float, float]] = []

    def at(self, x: float, z: float) -> Point:
        """Return the point of a place [m]."""
        low = self._plan.low
        return self._corner[0] + (x - low[0]) * self.scale, self._corner[1] + (z - low[1]) * self.scale

    def floor(self) -> None:
        """Draw the floor with a grid of metres, the set, the gates, and the front edge."""
        page, (w, d) = self._page, self._plan.half
        page.shape([self.at(-w, -d), self.at(w, -d), self.at(w, d), self.at(-w, d)], WHITE, grey(0.6), 0.6)
        step = 1 if self.scale >= 17.0 else 2 if self.scale >= 8.0 else 5 if self.scale >= 3.4 else 10
        for x in range(-int(w) // step * step, int(w) + 1, step):
            if -w < x < w:
                page.stroke([self.at(x, -d), self.at(x, d)], 0.9 if x == 0 else 0.4, GRID)
            if -w <= x <= w:
                page.words((self.at(x, d)[0], self.at(x, d)[1] + 9.5), str(abs(x)), SMALL, ink=FAINT, anchor="m")
        for z in range(-int(d) // step * step, int(d) + 1, step):
            if -d < z < d:
                page.stroke([self.at(-w, z), self.at(w, z)], 0.9 if z == 0 else 0.4, GRID)
        for across, along, radius in self._plan.discs:
            page.disc(self.at(across, along), radius * self.scale, SET, grey(0.5), 0.6)
        for a, b in self._plan.walls:
            page.stroke([self.at(*a), self.at(*b)], 2.4, grey(0.5))
        page.stroke([self.at(-w, d), self.at(w, d)], 2.2, BLACK)
        self._front_words(w, d)
        for gate in self._plan.gates:
            self._gate(gate)
        for gate in self._plan.gates if self.width > 200.0 else ():
            self.label((gate.x, gate.z), gate.name, 5.0, ink=FAINT)

    def _front_words(self, w: float, d: float) -> None:
        page = self._page
        (left, y), (right, _) = self.at(-w, d), self.at(w, d)
        page.words(((left + right) / 2.0, y + 19.0), "audience", SMALL, ink=FAINT, anchor="m")
        if right - left > 136.0:
            page.words((left, y + 19.0), "stage right", SMALL, ink=FAINT)
            page.words((right, y + 19.0), "stage left", SMALL, ink=FAINT, anchor="r")

    def _gate(self, gate: Gate) -> None:
        half = gate.width / 2.0
        along = (-gate.out_z * half, gate.out_x * half)
        ends = [self.at(gate.x + side * along[0], gate.z + side * along[1]) for side in (-1.0, 1.0)]
        self._page.stroke(ends, 2.6, WHITE)
        out = 0.3 * self.scale
        for x, y in ends:
            self._page.stroke([(x, y), (x + gate.out_x * out, y + gate.out_z * out)], 1.2, BLACK)

    def way(self, points: Float64, *, ink: Ink = WAY, width: float = 0.8, short: float = 0.0) -> None:
        """Draw a way (P, 2) [m] as an arrow; its head ends `short` [pt] before the last point."""
        there = [self.at(float(x), float(z)) for x, z in points]
        there = _cut(there, short)
        if len(there) < 2 or _length(there) < 3.0:
            return
        tip = there[-1]
        head = min(HEAD * max(width, 0.8) ** 0.5, _length(there))
        neck = _cut(there, 0.8 * head)
        base = _cut(there, head)[-1]
        self._page.stroke(neck if len(neck) > 1 else there, width, ink)
        angle = math.atan2(tip[1] - base[1], tip[0] - base[0])
        sides = [
            (tip[0] - head * math.cos(angle + side), tip[1] - head * math.sin(angle + side)) for side in (-0.4, 0.4)
        ]
        self._page.shape([tip, *sides], ink, None)

    def mark(
        self, mark: GroupMark, place: tuple[float, float], radius: float, *, heading: float | None = None,
        ink: Ink = BLACK, width: float = 0.7,
    ) -> None:  # fmt: skip
        """Draw a dancer's mark, with a line to where she faces."""
        x, y = self.at(*place)
        if heading is not None:
            far = radius * 1.5 + 0.8
            self._page.stroke([(x, y), (x + far * math.sin(heading), y + far * math.cos(heading))], 1.1, ink)
        draw_mark(self._page, mark, (x, y), radius, ink=ink, width=width)
        reach = radius * 1.1
        self._taken.append((x - reach, y - reach, x + reach, y + reach))

    def number_in(self, mark: GroupMark, place: tuple[float, float], words: str) -> None:
        """Write a number in a mark."""
        x, y = self.at(*place)
        self._page.words((x, y + 0.36 * SMALL), words, SMALL, bold=True, ink=mark.ink, anchor="m")

    def keep_free(self, way: Float64, start: tuple[float, float]) -> None:
        """Keep labels off a way (P, 2) [m] and its ring at the start."""
        x, y = self.at(*start)
        self._taken.append((x - 3.2, y - 3.2, x + 3.2, y + 3.2))
        points = [self.at(float(x), float(z)) for x, z in way]
        for a, b in itertools.pairwise(points):
            parts = max(int(math.dist(a, b) / 3.0), 1)
            for part in range(parts + 1):
                x, y = (a[axis] + part / parts * (b[axis] - a[axis]) for axis in (0, 1))
                self._taken.append((x - 1.0, y - 1.0, x + 1.0, y + 1.0))

    def label(
        self, place: tuple[float, float], words: str, away: float, *, bold: bool = False, ink: Ink = BLACK
    ) -> bool:
        """Write words beside a place where nothing else is, `away` [pt] from it; False if there is no room."""
        x, y = self.at(*place)
        width, tall = text_width(words, SMALL, bold), 0.74 * SMALL
        edge_x, edge_y = self._corner
        for dx, dy in ((1, 0), (-1, 0), (0, -1), (0, 1), (0.8, -0.8), (-0.8, -0.8), (0.8, 0.8), (-0.8, 0.8)):
            left = x + dx * away + (0.0 if dx > 0.1 else -width if dx < -0.1 else -width / 2.0)
            top = y + dy * away + (-tall / 2.0 if abs(dy) < 0.1 else -tall if dy < 0 else 0.0)
            box = (left - 0.8, top - 0.8, left + width + 0.8, top + tall + 0.8)
            inside = edge_x <= box[0] and box[2] <= edge_x + self.width and edge_y <= box[1]
            inside = inside and box[3] <= edge_y + self.height - FOOT
            if inside and not any(_overlap(box, other) for other in self._taken):
                self._page.words((left, top + tall), words, SMALL, bold=bold, ink=ink)
                self._taken.append(box)
                return True
        return False


def mark_radius(places: Float64, scale: float, most: float = NUMBER_RADIUS) -> float:
    """Return the radius [pt] of marks at `places` (D, 2) [m] that hardly overlap at `scale` [pt/m]."""
    if len(places) < 2:
        return most
    apart = np.hypot(*np.moveaxis(places[:, None] - places[None], 2, 0))
    np.fill_diagonal(apart, np.inf)
    near = float(np.percentile(apart.min(axis=1), 15.0)) * scale
    return min(max(0.46 * near, LEAST_RADIUS), most)


def _overlap(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _length(points: Sequence[Point]) -> float:
    return sum(math.dist(a, b) for a, b in itertools.pairwise(points))


def _cut(points: list[Point], short: float) -> list[Point]:
    """Return a line without the last `short` [pt] of its length."""
    kept = list(points)
    while len(kept) > 1 and short > 0.0:
        step = math.dist(kept[-2], kept[-1])
        if step > short:
            share = 1.0 - short / step
            (ax, ay), (bx, by) = kept[-2], kept[-1]
            kept[-1] = (ax + share * (bx - ax), ay + share * (by - ay))
            return kept
        short -= step
        kept.pop()
    return kept
