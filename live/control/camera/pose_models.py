"""BlazePose's two models, run by LiteRT: where people are in a picture, and the 33 landmarks of one of them.

After Bazarevsky et al. 2020, "BlazePose: On-device Real-time Body Pose Tracking", and MediaPipe 0.10 (Apache-2.0), with
whose landmarks the tests compare them. Decoding is our own.
"""

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from PIL import Image

from live.base.arrays import Float32, Float64, UInt8
from live.base.errors import PersonError
from live.motion.capture.landmarks import LANDMARK_COUNT

DETECTOR_SIZE: Final = 224
LANDMARK_SIZE: Final = 256
DETECTION_SCORE: Final = 0.5
"""Least score of a detected person."""
OVERLAP: Final = 0.3
"""Boxes that overlap by more of their union are one person."""
REGION_SCALE: Final = 1.25
"""Size of the region around a person over twice the distance from the hips to the point that tells the size."""
_STRIDES: Final = ((8, 2), (16, 2), (32, 6))
"""The detector's grids: pixels per cell, boxes per cell."""
_MODEL_LANDMARKS: Final = 39
"""The model's landmarks: 33 of the body, two that place the region in the next picture, four that are not used."""
_HEATMAP_REACH: Final = 3
_HEATMAP_LEAST: Final = 0.5


@dataclass(frozen=True, slots=True)
class Region:
    """A turned square of the picture around a person [pixels]."""

    x: float
    """Its middle, from the left."""
    y: float
    """Its middle, from the top."""
    size: float
    """Length of an edge."""
    angle: float
    """Rotation from upright [rad], clockwise in the picture."""


def region_around(middle: tuple[float, float], tip: tuple[float, float]) -> Region:
    """Return the region of a person with the hips at `middle` and the point that tells size and direction at `tip`
    [pixels]."""
    x, y = tip[0] - middle[0], tip[1] - middle[1]
    return Region(*middle, 2.0 * REGION_SCALE * math.hypot(x, y), math.atan2(x, -y))


def crop(picture: UInt8, region: Region, size: int) -> Float32:
    """Return the region of a picture (H, W, 3), upright, (size, size, 3), 0 to 1; black outside of the picture."""
    image = Image.fromarray(picture)
    factor = max(int(region.size / size), 1)
    x, y, edge = region.x, region.y, region.size
    if factor > 1:  # a far larger region is averaged first: single samples would pass the sensor's noise on
        image = image.reduce(factor)
        x, y, edge = x / factor, y / factor, edge / factor
    step = edge / size
    c, s = step * math.cos(region.angle), step * math.sin(region.angle)
    half = 0.5 * size
    placed = image.transform(
        (size, size),
        Image.Transform.AFFINE,
        (c, -s, x - half * (c - s), s, c, y - half * (s + c)),
        Image.Resampling.BILINEAR,
    )
    return np.asarray(placed, np.float32) / np.float32(255.0)


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """A person who was found in a picture [pixels]."""

    score: float
    region: Region
    face: tuple[float, float, float, float]
    """Left, top, right, bottom of the face's box."""


@dataclass(frozen=True, slots=True, eq=False)
class ModelPose:
    """What the landmark model says of a region of the picture."""

    picture: Float64
    """Landmarks, (L, 2) [pixels]."""
    body: Float64
    """Landmarks relative to the middle of the hips in the camera's axes, (L, 3) [m]."""
    visibility: Float64
    """(L,), 0 to 1."""
    presence: float
    """Probability that there is a person, 0 to 1."""
    next_region: Region
    """The region around the person."""
    region: Region
    """The region that was looked at."""
    mask: Float32
    """Logits of the person's silhouette in `region`, (256, 256)."""


def _interpreter(file: Path) -> Any:
    try:
        from ai_edge_litert.interpreter import Interpreter
    except ImportError:
        raise PersonError(
            "the camera needs LiteRT, which is not installed", "install the extra: choreographics-live[camera]"
        ) from None
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "2")
    runner = Interpreter(str(file), num_threads=1)
    runner.allocate_tensors()
    return runner


class PersonDetector:
    """Finds people in a whole picture. Thread: one."""

    def __init__(self, file: Path) -> None:
        """Load the model `file`."""
        self._runner = _interpreter(file)
        self._input = self._runner.get_input_details()[0]["index"]
        boxes, scores = self._runner.get_output_details()
        self._boxes, self._scores = boxes["index"], scores["index"]
        self._anchors = _anchors()

    def detect(self, picture: UInt8, most: int) -> list[Detection]:
        """Return up to `most` people in a picture (H, W, 3), the surest first."""
        height, width = picture.shape[:2]
        size = float(max(height, width))
        whole = crop(picture, Region(0.5 * width, 0.5 * height, size, 0.0), DETECTOR_SIZE)
        self._runner.set_tensor(self._input, 2.0 * whole[None] - 1.0)
        self._runner.invoke()
        logits = self._runner.get_tensor(self._scores)[0, :, 0]
        score = 1.0 / (1.0 + np.exp(-np.clip(logits, -50.0, 50.0)))
        kept = np.flatnonzero(score >= DETECTION_SCORE)
        if not len(kept):
            return []
        raw = self._runner.get_tensor(self._boxes)[0, kept].astype(np.float64) / DETECTOR_SIZE
        raw[:, [0, 1]] += self._anchors[kept]
        raw[:, 4:] += np.tile(self._anchors[kept], 4)
        found = _merge_boxes(raw, score[kept], most)
        corner = np.array([0.5 * (width - size), 0.5 * (height - size)])
        people = []
        for each, sure in found:
            points = each[4:].reshape(4, 2) * size + corner
            (x, y), (w, h) = each[:2] * size + corner, each[2:4] * size
            box = (x - 0.5 * w, y - 0.5 * h, x + 0.5 * w, y + 0.5 * h)
            region = region_around((points[0, 0], points[0, 1]), (points[1, 0], points[1, 1]))
            people.append(Detection(sure, region, box))
        return people


def _anchors() -> Float64:
    """Middles of the detector's boxes, (2254, 2), as fractions of the picture."""
    rows = []
    for stride, count in _STRIDES:
        cells = DETECTOR_SIZE // stride
        middle = (np.arange(cells) + 0.5) / cells
        y, x = np.meshgrid(middle, middle, indexing="ij")
        rows.append(np.repeat(np.stack([x.ravel(), y.ravel()], 1), count, axis=0))
    return np.concatenate(rows)


def _merge_boxes(boxes: Float64, score: Float64, most: int) -> list[tuple[Float64, float]]:
    """Return boxes with their score, those that overlap averaged by their scores (blending, Bazarevsky et al. 2019,
    "BlazeFace")."""
    low, high = boxes[:, :2] - 0.5 * boxes[:, 2:4], boxes[:, :2] + 0.5 * boxes[:, 2:4]
    area = np.prod(high - low, axis=1)
    left = np.argsort(-score, kind="stable")
    found: list[tuple[Float64, float]] = []
    while len(left) and len(found) < most:
        first = left[0]
        shared = np.clip(np.minimum(high[first], high[left]) - np.maximum(low[first], low[left]), 0.0, None)
        both = np.prod(shared, axis=1)
        same = both / (area[first] + area[left] - both) > OVERLAP
        same[0] = True
        weight = score[left[same]]
        found.append((weight @ boxes[left[same]] / weight.sum(), float(score[first])))
        left = left[~same]
    return found


class LandmarkModel:
    """Finds the landmarks of one person in a region of the picture. Thread: one."""

    def __init__(self, file: Path) -> None:
        """Load the model `file`."""
        self._runner = _interpreter(file)
        self._input = self._runner.get_input_details()[0]["index"]
        names = ("points", "presence", "mask", "heatmap", "body")
        self._output = {
            name: each["index"] for name, each in zip(names, self._runner.get_output_details(), strict=True)
        }

    def run(self, picture: UInt8, region: Region) -> ModelPose:
        """Return what the model sees in a region of a picture (H, W, 3)."""
        self._runner.set_tensor(self._input, crop(picture, region, LANDMARK_SIZE)[None])
        self._runner.invoke()
        points = self._tensor("points").reshape(_MODEL_LANDMARKS, 5).astype(np.float64)
        place = _refine(points[:, :2] / LANDMARK_SIZE, self._tensor("heatmap")[0])
        c, s = math.cos(region.angle), math.sin(region.angle)
        turn = np.array([[c, s], [-s, c]])  # for rows: from the region's axes to the picture's
        there = (place - 0.5) * region.size @ turn + (region.x, region.y)
        body = self._tensor("body").reshape(_MODEL_LANDMARKS, 3)[:LANDMARK_COUNT].astype(np.float64)
        body[:, :2] = body[:, :2] @ turn
        (x, y), (tip_x, tip_y) = there[LANDMARK_COUNT : LANDMARK_COUNT + 2].tolist()
        return ModelPose(
            picture=there[:LANDMARK_COUNT],
            body=body,
            visibility=1.0 / (1.0 + np.exp(-np.clip(points[:LANDMARK_COUNT, 3], -50.0, 50.0))),
            presence=float(self._tensor("presence")[0, 0]),
            next_region=region_around((x, y), (tip_x, tip_y)),
            region=region,
            mask=self._tensor("mask")[0, :, :, 0],
        )

    def _tensor(self, name: str) -> Float32:
        return np.asarray(self._runner.get_tensor(self._output[name]))


def _refine(place: Float64, heatmap: Float32) -> Float64:
    """Return landmarks moved to the weighted mean of the heatmap around them.

    `place` (K, 2) as fractions of the region; `heatmap` (64, 64, K) of logits. Landmarks without a clear peak stay.
    """
    cells = heatmap.shape[0]
    cell = np.floor(place * cells).astype(np.intp)
    inside = ((cell >= 0) & (cell < cells)).all(axis=1)
    reach = np.arange(-_HEATMAP_REACH, _HEATMAP_REACH + 1)
    column = cell[:, 0, None] + reach
    row = cell[:, 1, None] + reach
    near_x, near_y = np.clip(column, 0, cells - 1), np.clip(row, 0, cells - 1)
    logit = heatmap[near_y[:, :, None], near_x[:, None, :], np.arange(len(place))[:, None, None]].astype(np.float64)
    sure = 1.0 / (1.0 + np.exp(-np.clip(logit, -50.0, 50.0)))
    sure *= ((row == near_y)[:, :, None]) & ((column == near_x)[:, None, :])
    total = sure.sum(axis=(1, 2))
    clear = inside & (sure.max(axis=(1, 2)) >= _HEATMAP_LEAST)
    total[~clear] = 1.0
    moved = np.stack([(sure * column[:, None, :]).sum(axis=(1, 2)), (sure * row[:, :, None]).sum(axis=(1, 2))], 1)
    refined = moved / total[:, None] / cells
    return np.where(clear[:, None], refined, place)
