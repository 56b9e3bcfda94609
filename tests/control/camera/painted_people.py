"""People for tests of cameras, painted as rectangles; a finder and a poser that know where they stand."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.control.camera.pose_models import Detection, ModelPose, Region
from live.motion.capture.landmarks import LANDMARK_COUNT, LANDMARK_NAMES

UInt8 = npt.NDArray[np.uint8]
Float64 = npt.NDArray[np.float64]
WIDTH, HEIGHT = 640, 360

_SHAPE = np.zeros((LANDMARK_COUNT, 2))
"""Places of a standing person's landmarks over their height, from the middle of the hips."""
for _name, _x, _y in (
    ("nose", 0.0, -0.42), ("leftShoulder", 0.1, -0.3), ("rightShoulder", -0.1, -0.3), ("leftElbow", 0.13, -0.15),
    ("rightElbow", -0.13, -0.15), ("leftWrist", 0.14, 0.0), ("rightWrist", -0.14, 0.0), ("leftHip", 0.06, 0.0),
    ("rightHip", -0.06, 0.0), ("leftKnee", 0.06, 0.25), ("rightKnee", -0.06, 0.25), ("leftAnkle", 0.06, 0.47),
    ("rightAnkle", -0.06, 0.47), ("leftHeel", 0.06, 0.5), ("rightHeel", -0.06, 0.5),
):  # fmt: skip
    _SHAPE[LANDMARK_NAMES.index(_name)] = _x, _y


@dataclass
class Painted:
    """Somebody in the picture."""

    x: float
    """Middle of the hips [pixels]."""
    y: float = 180.0
    tall: float = 200.0
    colour: tuple[int, int, int] = (200, 40, 40)
    distance: float = 4.0
    """The nearer one hides the other."""
    swing: float = 0.0
    """Rotation of the arms' places, so that somebody moves without walking."""

    @property
    def landmarks(self) -> Float64:
        """Landmarks, (L, 2) [pixels]."""
        shape = _SHAPE.copy()
        shape[13:17, 1] -= 0.3 * np.sin(self.swing)
        return shape * self.tall + (self.x, self.y)

    @property
    def region(self) -> Region:
        """The region around."""
        return Region(self.x, self.y, 1.25 * self.tall, 0.0)


class PaintedPeople:
    """A finder and a poser. The picture is painted by `paint`."""

    def __init__(self, jitter: float = 0.004, seed: int = 1) -> None:
        """`jitter`: noise of the landmarks, over a person's height."""
        self.people: list[Painted] = []
        self.runs = 0
        """How often the landmark model ran."""
        self.searches = 0
        self._jitter, self._chance = jitter, np.random.default_rng(seed)

    def paint(self) -> UInt8:
        """Return the picture, (H, W, 3)."""
        picture = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
        for each in sorted(self.people, key=lambda one: -one.distance):
            left, right = round(each.x - 0.12 * each.tall), round(each.x + 0.12 * each.tall)
            top, low = round(each.y - 0.45 * each.tall), round(each.y + 0.5 * each.tall)
            picture[max(top, 0) : max(low, 0), max(left, 0) : max(right, 0)] = each.colour
        return picture

    def _visible(self) -> list[Painted]:
        """People whose middle no nearer one covers."""
        return [
            each for each in self.people
            if not any(
                other.distance < each.distance and abs(other.x - each.x) < 0.1 * other.tall for other in self.people
            )
        ]  # fmt: skip

    def detect(self, picture: UInt8, most: int) -> list[Detection]:
        """Find everybody, wherever the square is: it is the whole picture here."""
        self.searches += 1
        found = [Detection(0.9, each.region, (0.0, 0.0, 1.0, 1.0)) for each in self._visible()]
        return found[:most]

    def run(self, picture: UInt8, region: Region) -> ModelPose:
        """Return the pose of the person nearest to the middle of the region, or of nobody."""
        self.runs += 1
        near = [each for each in self._visible() if abs(each.x - region.x) < 0.35 * region.size]
        if not near:
            return _pose(np.zeros((LANDMARK_COUNT, 2)), region, 0.01)
        each = min(near, key=lambda one: abs(one.x - region.x))
        noise = self._chance.normal(0.0, self._jitter * each.tall, (LANDMARK_COUNT, 2))
        return _pose(each.landmarks + noise, each.region, 0.99)


def _pose(picture: Float64, region: Region, presence: float) -> ModelPose:
    body = np.zeros((LANDMARK_COUNT, 3))
    seen = np.full(LANDMARK_COUNT, 0.95)
    return ModelPose(picture, body, seen, presence, region, region, np.zeros((256, 256), np.float32))
