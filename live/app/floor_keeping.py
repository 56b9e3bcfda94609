"""Where a hall's floor lies in the picture: what is known of it, and what becomes of corners that were pointed at."""

from collections.abc import Callable, Sequence

import numpy as np

from live.app.output_keeping import OutputKeeping
from live.app.session import Session
from live.base.errors import PersonError
from live.base.picture import camera_of, camera_values
from live.base.projector_perspective import floor_corners, matched
from live.base.stage_snapshot import Camera
from live.control.events.event import ControlEvent
from live.control.registry.registry import REGISTRY
from live.render.camera import pixel_of
from live.render.outputs.output import Point

GUESS = ((0.25, 0.45), (0.75, 0.45), (0.95, 0.9), (0.05, 0.9))
"""Where the corners are put while the camera does not see all of them: they are to be measured anyway."""
WITHIN = 0.48
"""They must not be farther from the picture's middle, or nobody could take hold of them."""
DIGITS = 5


class FloorKeeping:
    """`corners` and `keep` belong to the main thread."""

    def __init__(self, session: Session, keeping: OutputKeeping, size: Callable[[], tuple[int, int]]) -> None:
        """`size`: of the picture [pixels]."""
        self._session, self._keeping, self._size = session, keeping, size
        self._kept: tuple[Point, ...] | None = None

    def corners(self) -> tuple[Point, ...]:
        """The floor's corners in the picture, as they were kept last, or as the camera sees them now."""
        projector = None if self._session.venue is None else self._session.venue.projector
        if self._kept is not None:
            return self._kept
        if projector is not None and projector.corners is not None:
            return projector.corners
        row = self._session.engine.view.picture
        return seen_corners(None if row is None else camera_of(row), self._stage, self._size())

    def keep(self, corners: Sequence[Point]) -> str:
        """Let the picture be seen from the projector's place, with the floor there, and put it into the venue's file;
        why not, in words, if that cannot be, else nothing."""
        venue = self._session.venue
        if venue is None or venue.projector is None:
            return "NOT KEPT: say in the venue's file where the lens is: [projector] at = [x, y, z], in metres"
        width, height = self._size()
        try:
            camera = matched(venue.projector.at, corners, self._stage, width / height)
        except PersonError as error:
            return f"NOT KEPT: {error}"
        self._kept = tuple((float(x), float(y)) for x, y in corners)
        for address, value in camera_values(camera).items():
            values = list(value) if isinstance(value, tuple) else [value]
            event = REGISTRY.call(address, values, self._session.clock.now(), "key")
            if isinstance(event, ControlEvent):
                self._session.inbox.put(event)
        rounded = [[round(x, DIGITS), round(y, DIGITS)] for x, y in self._kept]
        self._keeping.keep_values({"projector": {"corners": rounded, "aspect": round(width / height, DIGITS)}})
        return ""

    @property
    def _stage(self) -> tuple[float, float]:
        stage = self._session.show.patch.stage
        return stage.width, stage.depth


def seen_corners(camera: Camera | None, stage: tuple[float, float], size: tuple[int, int]) -> tuple[Point, ...]:
    """Where a camera sees the corners of a floor, as shares of its picture; a guess where it does not."""
    if camera is None:
        return GUESS
    floor = [(x, 0.0, z) for x, z in floor_corners(*stage)]
    forward = np.subtract(camera.target, camera.eye)
    if min(float(np.dot(np.subtract(corner, camera.eye), forward)) for corner in floor) <= 0.0:
        return GUESS  # one lies behind it
    places = pixel_of(camera, size, floor) / size
    if not (np.isfinite(places).all() and np.abs(places - 0.5).max() < WITHIN):
        return GUESS
    return tuple((float(x), float(y)) for x, y in places)
