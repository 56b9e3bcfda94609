"""Framing: the camera of a shot from a given direction, and how long a frame may stand while the dancers move.

A frame fills 72 % of the picture's width or 77 % of its height, whichever is reached first. It stands as long as it
fills 65 to 80 % with everybody's feet and heads in; like a camera operator's, it does not tremble with each step.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import Bool, Float64
from live.show.desk.camera_kernels import HEIGHT, RADIUS, box_in_view, fit_view
from live.show.desk.camera_shots import ShotKind

WIDTH_SHARE: Final = 0.72
"""Share of the picture's width that a formation fills."""
TOP: Final = 0.82
"""Where heads are, from the middle (0) to the upper edge (1): 9 % of headroom."""
BOTTOM: Final = 0.72
"""Where feet are below the middle: 14 % of floor below them."""
EDGE: Final = 0.97
"""Where a shot of a part of the body ends below."""
NEAREST_BODY: Final = 1.6
"""Least depth of a body [m]."""
FARTHEST: Final = 90.0
"""Largest distance of the camera from its dancers [m]: the renderer sees 120 m far. Wider lenses show larger stages."""
LEAST_FILL, MOST_FILL = 0.65, 0.80
"""A frame stands while its dancers fill a share between these."""
SIDE_LIMIT, TOP_LIMIT, FEET_LIMIT = 0.86, 0.87, 0.87
"""A frame stands while nobody is nearer to its edges: shares of the half picture."""
MIDDLE_LIMIT: Final = 0.25
"""A soloist is no farther from the middle: a share of half the picture."""
STAGE_BODY: Final = np.array([0.0, 1.2, 0.0])
"""What is framed of an empty stage: its floor, and air above it."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """A camera: target, distance, direction and lens."""

    target: Float64
    """x, y, z [m], shape (3,)."""
    distance: float
    """From target to eye [m]."""
    bearing: float
    elevation: float
    """[rad]"""
    field_of_view: float
    """Vertical [degrees]."""

    @property
    def eye(self) -> Float64:
        """Its position, shape (3,) [m]."""
        return self.target + self.distance * direction(self.bearing, self.elevation)

    @property
    def extent(self) -> float:
        """Height of what the picture shows at the target [m]."""
        return 2.0 * self.distance * math.tan(math.radians(0.5 * self.field_of_view))

    @property
    def numbers(self) -> Float64:
        """Target, logarithm of the distance, bearing, elevation [rad] and field of view [degrees], shape (7,)."""
        return np.array(
            [*self.target, math.log(self.distance), self.bearing, self.elevation, self.field_of_view], np.float64
        )


def direction(bearing: float, elevation: float) -> Float64:
    """Return the unit vector from what a camera looks at to the camera, shape (3,)."""
    flat = math.cos(elevation)
    return np.array([flat * math.sin(bearing), math.sin(elevation), flat * math.cos(bearing)], np.float64)


def turn_between(first: Frame, second: Frame) -> float:
    """Return the angle between the directions of two cameras [rad]."""
    cos = math.sin(first.elevation) * math.sin(second.elevation) + math.cos(first.elevation) * math.cos(
        second.elevation
    ) * math.cos(first.bearing - second.bearing)
    return math.acos(min(max(cos, -1.0), 1.0))


class Framing:
    """Framing for pictures of one aspect ratio on one stage. Thread: the show's."""

    def __init__(self, aspect: float, half_stage: Float64) -> None:
        """`half_stage` (2,) [m] is what an empty stage shows."""
        self._aspect, self._half = aspect, half_stage

    def view(self, kind: ShotKind, bearing: float, elevation: float, field_of_view: float) -> Float64:
        """Return the view of a shot as the kernels take it, shape (9,)."""
        up = math.tan(math.radians(0.5 * field_of_view))
        top, bottom = (TOP, BOTTOM) if kind.whole else (0.82, EDGE)
        return np.array(
            [bearing, elevation, up * self._aspect, up, WIDTH_SHARE, top, bottom, kind.above, NEAREST_BODY], np.float64
        )

    def fit(
        self, kind: ShotKind, place: Float64, chosen: Bool, bearing: float, elevation: float, top: float = HEIGHT
    ) -> Frame:
        """Return the nearest camera from a direction that shows the chosen dancers, who are at `place` (n, 2) [m] and
        reach up to `top` [m]; the stage if nobody is chosen."""
        found, lens = np.empty(4), kind.field_of_view_deg
        body = body_of(kind, top)
        if not chosen.any():
            place, chosen, body = self._corners(), np.ones(4, np.bool_), STAGE_BODY
        while True:
            fit_view(place, chosen, body, self.view(kind, bearing, elevation, lens), found)
            if found[3] <= FARTHEST or lens >= 80.0:
                return Frame(found[:3].copy(), float(found[3]), bearing, elevation, lens)
            lens = min(lens * 1.25, 80.0)

    def stands(self, kind: ShotKind, place: Float64, chosen: Bool, frame: Frame, top: float = HEIGHT) -> bool:
        """Whether a frame still shows its dancers well, who reach up to `top` [m]."""
        if not chosen.any():
            return False
        view = self.view(kind, frame.bearing, frame.elevation, frame.field_of_view)
        box, camera = np.empty(4), np.array([*frame.target, frame.distance], np.float64)
        box_in_view(place, chosen, body_of(kind, top), view, camera, box)
        left, right, bottom, high = box.tolist()
        if not kind.whole:
            middle = abs(0.5 * (left + right)) < MIDDLE_LIMIT and max(-left, right) < SIDE_LIMIT
            return middle and 0.74 < high < 0.9 and -1.08 < bottom < -0.86
        if kind.subject == "soloist" and abs(0.5 * (left + right)) > MIDDLE_LIMIT:
            return False
        if max(-left, right) > SIDE_LIMIT or high > TOP_LIMIT or -bottom > FEET_LIMIT:
            return False
        return LEAST_FILL <= max(0.5 * (right - left), 0.5 * (high - bottom)) <= MOST_FILL

    def _corners(self) -> Float64:
        x, z = self._half.tolist()
        return np.array([[-x, -z], [x, -z], [-x, z], [x, z]], np.float64)


def body_of(kind: ShotKind, top: float = HEIGHT) -> Float64:
    """Return the part of a body that a shot shows, of dancers who reach up to `top` [m]: lowest and highest height, and
    radius [m]. A near shot goes down with whom it shows."""
    return np.array([kind.lowest if kind.whole else kind.lowest + top - HEIGHT, top, RADIUS], np.float64)
