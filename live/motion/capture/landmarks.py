"""Body landmarks of one person as a pose model sees them in one picture of a camera.

The 33 points are those of BlazePose (Bazarevsky et al. 2020, "BlazePose: On-device Real-time Body Pose Tracking"), in
the order of its landmark model.
"""

from dataclasses import dataclass
from typing import Final

from live.base.arrays import Float32

LANDMARK_NAMES: Final = (
    "nose",
    "leftEyeInner", "leftEye", "leftEyeOuter", "rightEyeInner", "rightEye", "rightEyeOuter",
    "leftEar", "rightEar", "mouthLeft", "mouthRight",
    "leftShoulder", "rightShoulder", "leftElbow", "rightElbow", "leftWrist", "rightWrist",
    "leftPinky", "rightPinky", "leftIndex", "rightIndex", "leftThumb", "rightThumb",
    "leftHip", "rightHip", "leftKnee", "rightKnee", "leftAnkle", "rightAnkle",
    "leftHeel", "rightHeel", "leftFootIndex", "rightFootIndex",
)  # fmt: skip
LANDMARK_COUNT: Final = len(LANDMARK_NAMES)


@dataclass(frozen=True, slots=True, eq=False)
class Landmarks:
    """One person in one picture (L landmarks, 33)."""

    time: float
    """Capture time of the picture in show time [s]."""
    picture: Float32
    """Places in the picture, (L, 2), as fractions of its width (from the left) and height (from the top)."""
    body: Float32
    """Places relative to the middle of the hips, (L, 3) [m], in the camera's axes: x to the picture's right, y down, z
    away from the camera. Scaled for the model's average person."""
    visibility: Float32
    """Probability that each landmark is in the picture and not hidden, (L,), 0 to 1."""
    presence: float
    """The model's confidence that there is a person at all, 0 to 1."""
    aspect: float
    """Width of the picture over its height."""
