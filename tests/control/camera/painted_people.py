"""People for tests of cameras, painted as rectangles; a finder and a poser that know where they stand."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from live.control.camera.pose_models import Detection, ModelPose, Region
from live.motion.capture.landmarks import LANDMARK_COUNT, LANDMARK_NAMES

UInt8 = npt.NDArray[np.uint8]
Float64 = npt.NDArray[np.float64]
Float32 = npt.NDArray[np.float32]
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

    def mask(self, region: Region) -> Float32:
        """Return the logits of the silhouette in an upright region, (256, 256)."""
        across = region.x + region.size * ((np.arange(256) + 0.5) / 256 - 0.5)
        down = region.y + region.size * ((np.arange(256) + 0.5) / 256 - 0.5)
        left, right, top, low = self.box
        inside = ((down >= top) & (down < low))[:, None] & ((across >= left) & (across < right))[None, :]
        return np.where(inside, 9.0, -9.0).astype(np.float32)

    @property
    def box(self) -> tuple[int, int, int, int]:
        """Left, right, top and bottom of what is painted [pixels]."""
        left, right = round(self.x - 0.12 * self.tall), round(self.x + 0.12 * self.tall)
        return left, right, round(self.y - 0.45 * self.tall), round(self.y + 0.5 * self.tall)

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
            left, right, top, low = each.box
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
        return _pose(each.landmarks + noise, each.region, 0.99, each.mask(region), region)


def _pose(
    picture: Float64, there: Region, presence: float, mask: Float32 | None = None, region: Region | None = None
) -> ModelPose:  # fmt: skip
    body = np.zeros((LANDMARK_COUNT, 3))
    seen = np.full(LANDMARK_COUNT, 0.95)
    mask = np.full((256, 256), -9.0, np.float32) if mask is None else mask
    return ModelPose(picture, body, seen, presence, there, region or there, mask)


class PixelPoser:
    """A poser that knows a person only by the pixels of their colour, and takes whoever shows most of them in its
    region: as a model for one person is stolen by the one in front."""

    def __init__(self, people: PaintedPeople, least: float = 0.15) -> None:
        """`people`: who may be seen. `least`: least share of a person's surface."""
        self._people, self._least = people, least

    def run(self, picture: UInt8, region: Region) -> ModelPose:
        """Return the pose of the person of whom most is seen in the region, or of nobody."""
        best, found = 0.0, None
        for each in self._people.people:
            left, right, top, low = each.box
            half = round(0.5 * region.size)
            first, last = max(left, round(region.x) - half, 0), min(right, round(region.x) + half, WIDTH)
            if last <= first:
                continue
            seen = (picture[max(top, 0) : low, first:last] == each.colour).all(axis=2).sum()
            if seen > self._least * (right - left) * (low - top) and seen > best:
                best, found = float(seen), each
        if found is None:
            return _pose(np.zeros((LANDMARK_COUNT, 2)), region, 0.01)
        return _pose(found.landmarks, found.region, 0.99, found.mask(region), region)
