"""One camera with its models: picture by picture, the people in it as landmarks."""

import numpy as np

from live.base.arrays import Float64, UInt8
from live.control.camera.drawn_figures import DrawnFigures
from live.control.camera.light import LightMeter
from live.control.camera.people_tracker import Finder, PeopleTracker, Poser
from live.control.camera.performers import Sighting
from live.control.camera.pose_models import ModelPose
from live.control.camera.seen_person import Person
from live.motion.capture.landmarks import Landmarks

_TURN_EVERY = 4
"""One picture in so many is looked at upside down, until anybody has been found."""


class CameraEye:
    """Looks at the pictures of one camera. Thread: one; `draw` may be called by another."""

    def __init__(
        self, finder: Finder, poser: Poser, most: int, *, turn_deg: int = 0, screen: Float64 | None = None
    ) -> None:  # fmt: skip
        """`most`: how many people. `turn_deg`: by how much the camera is turned clockwise, in quarters; `screen`
        (4, 2): the corners of the projected picture, as `DrawnFigures` takes them."""
        self._size = (1, 1)
        self._drawn = None if screen is None else DrawnFigures(screen)
        self._tracker = PeopleTracker(finder, poser, most, self._accepts)
        self._finder = finder
        self._quarters = round(turn_deg / 90)
        self._count = self._found_turned = 0
        self.light = LightMeter()
        """How well it sees."""
        self.is_upside_down = False
        """Whether the camera turned out to hang upside down."""
        self.people: list[Person] = []
        """Who is seen in the last picture."""
        self.drawn_left_out = 0
        """Figures that turned out to be drawn ones."""

    def draw(self, time: float, joints: Float64) -> None:
        """Note where figures were drawn at `time` [s]: see `DrawnFigures.draw`."""
        if self._drawn is not None:
            self._drawn.draw(time, joints)

    @property
    def still_figures(self) -> int:
        """How many figures are there that never moved."""
        return len(self._tracker.still)

    def look(self, picture: UInt8, time: float) -> list[Sighting]:
        """Return the people in a picture (H, W, 3) taken at `time` [s]."""
        picture = self._upright(picture)
        height, width = picture.shape[:2]
        self._size = (width, height)
        self.people = self._tracker.update(picture, time) if self.light.look(picture) else []
        self.light.judge(picture, self.people)
        return [Sighting(each.number, _landmarks(each.pose, time, width, height)) for each in self.people]

    def _upright(self, picture: UInt8) -> UInt8:
        """Return the picture turned as the camera hangs; find out if it hangs upside down."""
        quarters = self._quarters + 2 * self.is_upside_down
        picture = np.ascontiguousarray(np.rot90(picture, quarters)) if quarters % 4 else picture
        if self._tracker.has_found or self.is_upside_down:
            return picture
        self._count += 1
        if self._count % _TURN_EVERY:
            return picture
        turned = np.ascontiguousarray(np.rot90(picture, 2))
        height, width = picture.shape[:2]
        edge = min(height, width)
        left, top = (width - edge) // 2, (height - edge) // 2
        middle = np.ascontiguousarray(turned[top : top + edge, left : left + edge])
        self._found_turned = self._found_turned + 1 if self._finder.detect(middle, 1) else 0
        if self._found_turned >= 3 and not self._tracker.people:
            self.is_upside_down = True
            return turned
        return picture

    def _accepts(self, pose: ModelPose) -> bool:
        if self._drawn is not None and self._drawn.shows(pose, *self._size):
            self.drawn_left_out += 1
            return False
        return True


def _landmarks(pose: ModelPose, time: float, width: int, height: int) -> Landmarks:
    """Return a pose in a picture of this size [pixels] as landmarks."""
    return Landmarks(
        time=time,
        picture=(pose.picture / (width, height)).astype(np.float32),
        body=pose.body.astype(np.float32),
        visibility=pose.visibility.astype(np.float32),
        presence=pose.presence,
        aspect=width / height,
    )
