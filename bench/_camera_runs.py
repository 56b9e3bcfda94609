"""Made films looked at as a show does: poses of performers beside the truth. Offline, picture by picture."""

import contextlib
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import av
import numpy as np
import numpy.typing as npt

from bench._camera_films import FilmTruth, to_pixels
from live.control.camera.camera_eye import CameraEye
from live.control.camera.model_files import DETECTOR, FULL, checked_model
from live.control.camera.performers import Performers
from live.control.camera.pose_models import LandmarkModel, PersonDetector
from live.motion.capture.camera_view import CameraView, calibrate
from live.motion.capture.packed_pose import unpack_pose
from live.motion.skeleton import JOINT_COUNT

Float64 = npt.NDArray[np.float64]

MARKS: Final = np.array(((-1.2, 1.2), (1.2, 1.2), (1.2, -1.2), (-1.2, -1.2)))
"""Floor marks [m], those of four pieces of tape a person lays down."""
CLICK_PIXELS: Final = 1.5
"""Standard deviation of a click."""


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """What was seen of a film: F frames, S performers."""

    hips: Float64
    """(F, S, 3) [m], NaN where a performer is not seen."""
    rotation: Float64
    """(F, S, J, 4)."""
    cpu_ms: float
    """Processor time of a picture, median."""

    def people(self) -> list[list[tuple[int, float, float]]]:
        """Return for each frame who is seen where, as `identities` of the scores takes it."""
        return [
            [(who, float(hips[0]), float(hips[2])) for who, hips in enumerate(frame) if np.isfinite(hips[0])]
            for frame in self.hips
        ]


def marked_view(truth: FilmTruth) -> CameraView:
    """Return the film's camera as found by four marks that somebody clicks, in the order of `MARKS`."""
    floor = np.column_stack((MARKS[:, 0], np.zeros(len(MARKS)), MARKS[:, 1])) * truth.scale
    clicks = to_pixels(truth.camera, floor)
    clicks = clicks + np.random.default_rng(7).normal(0.0, CLICK_PIXELS, clicks.shape)
    width, height = truth.size
    return calibrate(floor[:, ::2], clicks / (width, height), width / height)


def see_film(truth: FilmTruth, *, delay: float = 0.0, calibrated: bool = True) -> Seen:
    """Look at a film with as many performers as it has dancers; poses are predicted by `delay` [s]."""
    return see_films((truth,), delay=delay, calibrated=calibrated)


def see_films(truths: Sequence[FilmTruth], *, delay: float = 0.0, calibrated: bool = True) -> Seen:
    """The same with the films of several cameras of one dance; the pictures of a moment come one after another."""
    count = truths[0].joints.shape[1]
    eyes = [
        CameraEye(PersonDetector(checked_model(DETECTOR)), LandmarkModel(checked_model(FULL)), count) for _ in truths
    ]
    performers = Performers([str(number) for number in range(count)])
    views = [marked_view(truth) if calibrated else None for truth in truths]
    frames = len(truths[0].time)
    hips = np.full((frames, count, 3), np.nan)
    rotation = np.full((frames, count, JOINT_COUNT, 4), np.nan)
    spent = []
    with contextlib.ExitStack() as stack:
        films = [stack.enter_context(av.open(str(truth.film))).decode(video=0) for truth in truths]
        for frame, pictures in zip(range(frames), zip(*films, strict=False), strict=False):
            begin = time.process_time()
            for camera, picture in enumerate(pictures):
                moment = float(truths[0].time[frame]) + 1e-3 * camera
                sightings = eyes[camera].look(np.asarray(picture.to_ndarray(format="rgb24"), np.uint8), moment)
                for pose in performers.update(camera, views[camera], sightings, moment + delay):
                    place, turned = unpack_pose(pose.packed)
                    hips[frame, int(pose.name)], rotation[frame, int(pose.name)] = place, turned
            spent.append(time.process_time() - begin)
    return Seen(hips, rotation, 1e3 * float(np.median(spent)))


def film_folder(folder: Path, *, held: bool) -> Path:
    """Return the folder of the films held back, or of those to tune on."""
    return folder / "held" if held else folder
