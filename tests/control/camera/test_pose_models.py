"""The models' decoding beside MediaPipe's own, and the pieces of it that need no model."""

import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

from live.control.camera.model_files import DETECTOR, FULL, model_folder
from live.control.camera.pose_models import (
    LandmarkModel,
    PersonDetector,
    Region,
    _anchors,
    _merge_boxes,
    _refine,
    crop,
    region_around,
)

HERE = Path(__file__).parent
needs_models = pytest.mark.skipif(
    model_folder() is None, reason="needs the pose models: live camera models gets them once"
)


@cache
def _reference() -> list[dict[str, object]]:
    """What MediaPipe 0.10.21 (model complexity 1, one picture) says of pictures of the project's own dancers."""
    found: list[dict[str, object]] = json.loads((HERE / "mediapipe_landmarks.json").read_text())
    return found


def _picture(name: object) -> npt.NDArray[np.uint8]:
    return np.asarray(Image.open(HERE / str(name)).convert("RGB"))


@needs_models
@pytest.mark.parametrize("number", [0, 1])
def test_landmarks_are_those_of_mediapipe(number: int) -> None:
    pytest.importorskip("ai_edge_litert", reason="needs the extra camera")
    folder = model_folder()
    assert folder is not None
    told = _reference()[number]
    picture = _picture(told["file"])
    height, width = picture.shape[:2]
    (person,) = PersonDetector(folder / DETECTOR).detect(picture, 3)
    assert person.score > 0.9
    pose = LandmarkModel(folder / FULL).run(picture, person.region)
    assert pose.presence > 0.99
    apart = np.linalg.norm(pose.picture - np.array(told["picture"]) * (width, height), axis=1)
    assert apart.mean() < 0.005 * person.region.size
    assert np.linalg.norm(pose.body - np.array(told["body"]), axis=1).mean() < 0.02
    assert np.abs(pose.visibility - np.array(told["visibility"])).max() < 0.1


@needs_models
def test_a_person_who_is_followed_stays_where_she_is() -> None:
    pytest.importorskip("ai_edge_litert", reason="needs the extra camera")
    folder = model_folder()
    assert folder is not None
    picture = _picture("dancer_1.png")
    model = LandmarkModel(folder / FULL)
    (person,) = PersonDetector(folder / DETECTOR).detect(picture, 1)
    region, places = person.region, []
    for _ in range(8):
        pose = model.run(picture, region)
        region = pose.next_region
        places.append(pose.picture)
    assert np.linalg.norm(places[-1] - places[-2], axis=1).mean() < 0.01 * region.size


@needs_models
def test_nobody_is_found_where_nobody_is() -> None:
    pytest.importorskip("ai_edge_litert", reason="needs the extra camera")
    folder = model_folder()
    assert folder is not None
    noise = np.random.default_rng(1).integers(0, 255, (240, 320, 3), np.uint8)
    detector = PersonDetector(folder / DETECTOR)
    for picture in (noise, np.zeros((240, 320, 3), np.uint8), np.full((16, 16, 3), 255, np.uint8)):
        assert detector.detect(picture, 3) == []


def test_a_region_is_cut_out_upright() -> None:
    picture = np.zeros((200, 300, 3), np.uint8)
    picture[90:110, 150:250, 0] = 255  # a bar from the middle to the right
    region = region_around((150.0, 100.0), (200.0, 100.0))  # whose head is to the right
    assert region.angle == pytest.approx(math.pi / 2)
    assert region.size == pytest.approx(125.0)
    upright = crop(picture, region, 64)[:, :, 0]
    assert upright[:28, 28:36].min() > 0.9, "the bar leads upwards"
    assert upright[40:].max() < 0.1


def test_a_region_beyond_the_picture_is_black_there() -> None:
    picture = np.full((50, 50, 3), 200, np.uint8)
    cut = crop(picture, Region(0.0, 0.0, 50.0, 0.0), 40)
    assert cut[25:, 25:].min() > 0.7
    assert cut[:15, :15].max() == 0.0


def test_the_anchors_are_those_of_the_model() -> None:
    anchors = _anchors()
    assert anchors.shape == (2254, 2)
    assert anchors[0] == pytest.approx((0.5 / 28, 0.5 / 28))
    assert anchors[-1] == pytest.approx((6.5 / 7, 6.5 / 7))


def test_boxes_of_one_person_become_their_mean_by_score() -> None:
    boxes = np.zeros((3, 12))
    boxes[:, :4] = (0.3, 0.3, 0.2, 0.2), (0.32, 0.3, 0.2, 0.2), (0.8, 0.8, 0.2, 0.2)
    found = _merge_boxes(boxes, np.array((0.9, 0.6, 0.8)), 5)
    assert [score for _, score in found] == [0.9, 0.8]
    assert found[0][0][0] == pytest.approx((0.9 * 0.3 + 0.6 * 0.32) / 1.5)
    assert len(_merge_boxes(boxes, np.array((0.9, 0.6, 0.8)), 1)) == 1


def test_landmarks_move_to_the_clear_peak_of_the_heatmap() -> None:
    heatmap = np.full((64, 64, 2), -20.0, np.float32)
    heatmap[30, 41, 0] = 20.0
    heatmap[30, 41, 1] = -3.0  # no clear peak
    moved = _refine(np.array(((40.2 / 64, 31.4 / 64), (40.2 / 64, 31.4 / 64))), heatmap)
    assert moved[0] == pytest.approx((41 / 64, 30 / 64), abs=1e-6)
    assert moved[1] == pytest.approx((40.2 / 64, 31.4 / 64))
