"""One camera's eye: a picture that is upside down is turned, and stays so."""

import numpy as np
import numpy.typing as npt
import pytest

import live.control.camera.people_tracker as tracker_module
from live.control.camera.camera_eye import CameraEye
from live.control.camera.pose_models import Detection
from tests.control.camera.painted_people import HEIGHT, Painted, PaintedPeople

UInt8 = npt.NDArray[np.uint8]
RATE = 30.0
FACE = (250, 250, 10)


class UprightFinder(PaintedPeople):
    """Finds nobody whose head, a patch of `FACE`, is not above the middle of the picture."""

    def paint(self) -> UInt8:
        picture = super().paint()
        for each in self.people:
            left, right, top, _ = each.box
            picture[top : top + 20, left:right] = FACE
        return picture

    def detect(self, picture: UInt8, most: int) -> list[Detection]:
        rows = np.flatnonzero((picture == FACE).all(axis=2).any(axis=1))
        return super().detect(picture, most) if rows.size and rows.mean() < 0.5 * len(picture) else []


@pytest.fixture(autouse=True)
def _whole_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """The painted finder takes every square for the whole picture."""
    monkeypatch.setattr(tracker_module, "search_squares", lambda width, height: [(0, 0, max(width, height))])


def looked_at(turns: int, frames: int) -> tuple[CameraEye, list[float]]:
    """An eye that has looked at a dancer through a camera turned by `turns` quarters; the heights of her nose."""
    people = UprightFinder()
    people.people = [Painted(300.0)]
    eye = CameraEye(people, people, 1)
    heights = []
    for frame in range(frames):
        people.people[0].x = 300.0 + 2.0 * frame
        picture = np.ascontiguousarray(np.rot90(people.paint(), turns))
        heights += [float(each.landmarks.picture[0, 1]) for each in eye.look(picture, frame / RATE)]
    return eye, heights


def test_a_camera_that_hangs_upside_down_is_turned() -> None:
    eye, heights = looked_at(2, 40)
    assert eye.is_upside_down
    assert len(heights) > 20, "she is seen soon"
    nose = (180.0 - 0.42 * 200.0) / HEIGHT
    assert heights == pytest.approx([nose] * len(heights), abs=0.02), "landmarks are those of the upright picture"


def test_a_camera_that_stands_upright_is_not() -> None:
    eye, heights = looked_at(0, 40)
    assert not eye.is_upside_down
    assert len(heights) > 30


def test_an_empty_picture_is_not_turned() -> None:
    people = UprightFinder()
    eye = CameraEye(people, people, 1)
    for frame in range(40):
        assert eye.look(people.paint(), frame / RATE) == []
    assert not eye.is_upside_down
