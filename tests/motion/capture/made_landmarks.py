"""Made landmarks: what a pose model would see of a clip's dancer through a known camera, with noise."""

from pathlib import Path

import numpy as np

from live.base.arrays import Float64
from live.library.step_folder import load_folder
from live.motion import quaternion
from live.motion.capture.camera_view import CameraView
from live.motion.capture.landmarks import LANDMARK_COUNT, LANDMARK_NAMES, Landmarks
from live.motion.clip import Clip, resample
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

RATE = 30.0
MODEL_SIZE = 0.97
"""The engine's dancer over the model's average person."""
_PLACES = {
    "nose": ("head", (0.0, 0.045, 0.12)), "leftEye": ("head", (0.03, 0.075, 0.1)),
    "leftEyeInner": ("head", (0.015, 0.075, 0.1)), "leftEyeOuter": ("head", (0.045, 0.075, 0.09)),
    "leftEar": ("head", (0.075, 0.07, 0.0)), "mouthLeft": ("head", (0.025, 0.01, 0.1)),
    "leftShoulder": ("leftUpperArm", (0.0, 0.0, 0.0)), "leftElbow": ("leftLowerArm", (0.0, 0.0, 0.0)),
    "leftWrist": ("leftHand", (0.0, 0.0, 0.0)), "leftPinky": ("leftHand", (0.08, 0.0, -0.03)),
    "leftIndex": ("leftHand", (0.09, 0.0, 0.03)), "leftThumb": ("leftHand", (0.05, 0.0, 0.05)),
    "leftHip": ("leftUpperLeg", (0.0, 0.0, 0.0)), "leftKnee": ("leftLowerLeg", (0.0, 0.0, 0.0)),
    "leftAnkle": ("leftFoot", (0.0, 0.0, 0.0)), "leftHeel": ("leftFoot", (0.0, -0.045, -0.04)),
    "leftFootIndex": ("leftToes", (0.0, 0.005, 0.05)),
}  # fmt: skip
"""Joint of each landmark, and where it lies in the joint's axes [m]; those of the right side are mirrored."""


def look_at(eye: tuple[float, float, float], target: tuple[float, float, float], focal: float = 1.0) -> CameraView:
    """Return a level camera at `eye` that looks at `target`, `focal` [heights of the picture], 16 to 9."""
    away = quaternion.unit(np.array(target) - np.array(eye))
    right = quaternion.unit(np.cross(away, (0.0, 1.0, 0.0)))
    return CameraView(focal, 16.0 / 9.0, np.stack((right, np.cross(away, right), away)), np.array(eye, float), True)


def step_clip(folder: str, step: str) -> Clip:
    """Return a step of the project's patches at 30 samples a second."""
    steps = load_folder(Path(__file__).parents[3] / "patches" / folder / "steps")
    return resample(next(each.clip for each in steps if each.step == step), RATE)


def landmark_places(joints: Float64, rotation: Float64) -> Float64:
    """Return all landmarks (T, 33, 3) [m] of poses with world `joints` (T, J, 3) [m] and `rotation` (T, J, 4)."""
    places = np.zeros((len(joints), LANDMARK_COUNT, 3))
    for number, name in enumerate(LANDMARK_NAMES):
        right = name.startswith("right") or name.endswith("Right")
        own = name.replace("right", "left").replace("Right", "Left")
        joint, offset = _PLACES[own]
        index = SKELETON.index(joint.replace("left", "right") if right else joint)
        turned = quaternion.rotate(rotation[:, index], np.array(offset) * ((-1.0, 1.0, 1.0) if right else 1.0))
        places[:, number] = joints[:, index] + turned
    return places


def truth(clip: Clip) -> tuple[Float64, Float64]:
    """Return world joints (T, J, 3) [m] and landmarks (T, 33, 3) [m] of a clip."""
    joints, rotation = forward_kinematics(clip.root_position.astype(np.float64), clip.rotation.astype(np.float64))
    return joints, landmark_places(joints, rotation)


def seen(
    places: Float64, view: CameraView, time: float, generator: np.random.Generator, *,
    across: float = 0.01, along: float = 0.05, clicks: float = 0.003, presence: float = 0.98, visibility: float = 0.95,
) -> Landmarks:  # fmt: skip
    """Return what the model sees of landmarks `places` (33, 3) [m] on the stage.

    Noise: `across` and `along` the ray [m] of the model's metres, `clicks` of its places in heights of the picture.
    """
    camera = view.to_camera(places)
    middle = camera[[23, 24]].mean(axis=0)
    turn = quaternion.from_two_vectors(quaternion.unit(middle), np.array((0.0, 0.0, 1.0)))
    body = quaternion.rotate(turn, camera - middle) / MODEL_SIZE
    body = body + generator.normal(size=body.shape) * (across, across, along)
    picture = view.project(places) + generator.normal(size=(LANDMARK_COUNT, 2)) * clicks / (view.aspect, 1.0)
    return Landmarks(
        time, picture.astype(np.float32), body.astype(np.float32), np.full(LANDMARK_COUNT, visibility, np.float32),
        presence, view.aspect,
    )  # fmt: skip
