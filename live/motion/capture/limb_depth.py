"""Depth of trunk and limbs seen by one camera, from the lengths of bones and from usual poses.

A picture tells places across the camera's rays to 2 cm, but the pose model's depth is off by 5 (shoulders) to 15 cm
(wrists), and pulled towards the plane of the body: knees and elbows look straighter than they are. So the depth of each
bone is first mixed with the usual one, then all bones get their lengths by moving their ends where they are least sure
(projection of constraints by inverse mass: Müller et al. 2007, "Position Based Dynamics", with a mass for each
direction).
"""

from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.capture.landmark_kernels import ANKLE, ELBOW, HIP, KNEE, SHOULDER, WRIST
from live.motion.capture.landmarks import LANDMARK_COUNT
from live.motion.capture.limb_depth_kernels import fit_limbs
from live.motion.skeleton import SKELETON

MODEL_SIZE: Final = 0.97
"""Size of the engine's skeleton over the pose model's average person."""
USUAL_DEPTH: Final = np.array(((0.2, 0.05), (0.6, -0.055), (0.4, 0.11), (0.85, 0.08), (0.75, -0.1)))
"""Depth of trunk (hips to shoulders), upper arm, forearm, thigh and shin: share of that seen, and what is added [m]
where the dancer faces along the camera's ray; the same taken off where they face the camera. Seen from the side the
model's depth is taken as it is. Least squares of the truth over what the model sees on made films, rounded: dancers
lean forward, bend elbows and knees."""
_DOWN: Final = np.array((0.015, 0.02))
"""How much farther along the upper bone elbow and knee lie than where the model sees them [m]; learned likewise."""


_JOINTS: Final = {
    SHOULDER: "UpperArm", ELBOW: "LowerArm", WRIST: "Hand", HIP: "UpperLeg", KNEE: "LowerLeg", ANKLE: "Foot"
}  # fmt: skip
"""Joint of each landmark, of either side."""


def _bones() -> tuple[list[tuple[int, int]], list[float]]:
    """Return the pairs of landmarks that are bones, and the lengths [m] of these bones in the skeleton."""
    rest = SKELETON.rest_positions().astype(np.float64)
    places = {
        row + n: rest[SKELETON.index(side + name)]
        for row, name in _JOINTS.items()
        for n, side in enumerate(("left", "right"))
    }
    rows = [(HIP, HIP + 1), (SHOULDER, SHOULDER + 1)]
    for i, j in ((SHOULDER, ELBOW), (ELBOW, WRIST), (HIP, KNEE), (KNEE, ANKLE)):
        rows += [(i, j), (i + 1, j + 1)]
    return rows, [float(np.linalg.norm(places[j] - places[i])) for i, j in rows]


_PAIRS, _LONG = _bones()
_BONES: Final = np.array(_PAIRS, np.int64)
_LENGTHS: Final = np.array(_LONG)


def _spread() -> Float64:
    """Return the standard deviation of each landmark across and along the ray [m], (L, 2), seen on made films."""
    spread = np.full((LANDMARK_COUNT, 2), 0.02)
    for row, both in (
        (SHOULDER, (0.015, 0.04)), (ELBOW, (0.03, 0.09)), (WRIST, (0.015, 0.15)), (HIP, (0.015, 0.02)),
        (KNEE, (0.02, 0.06)), (ANKLE, (0.015, 0.09)),
    ):  # fmt: skip
        spread[row : row + 2] = both
    return spread


_SPREAD: Final = _spread()
_EVEN: Final = np.ascontiguousarray(np.repeat(_SPREAD[:, :1], 2, axis=1))


class LimbDepth:
    """Fits landmarks; holds the array for it."""

    def __init__(self) -> None:
        self._points = np.zeros((LANDMARK_COUNT, 3))

    def fit(self, points: Float64, eye: Float64, depth: Float64, size: float) -> Float64:
        """Return landmarks `points` (L, 3) [m] of the stage with trunk and limbs fitted; they hold until the next call.

        `eye` (3,): the camera's place. `depth` (3,): the ray of the only camera, or zero where several measured the
        depth: then only lengths are used. `size`: the person's size over the model's average person.
        """
        self._points[:] = points
        spread = _SPREAD if depth.any() else _EVEN
        fit_limbs(self._points, eye, depth, size / MODEL_SIZE, USUAL_DEPTH, _DOWN, _BONES, _LENGTHS, spread)
        return self._points
