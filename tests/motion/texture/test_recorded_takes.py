"""A walker never seen: arms of the recordings of two others swing in time with the walker's legs."""

import numpy as np
import pytest

from live.library.capture_material import read_material
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON
from live.motion.texture.coordination import correlation
from live.motion.texture.drivers import DRIVER_SETS, ROTATIONS
from live.motion.texture.frequency_bands import SampledClip, sample_clip, split_bands
from live.motion.texture.texture_settings import UPPER
from live.motion.texture.upper_body_regression import UpperBodyRegression, learn_upper_body
from tests.places import SHARED

WALKS = [
    SHARED / "mocap" / "walk" / f"{name}.bvh" for name in ("cmu_02_01_walk", "cmu_12_01_walk", "figure8_MS2_8Walk_M")
]
HANDS = [SKELETON.index(side + end) for side in ("left", "right") for end in ("LowerArm", "Hand")]
SWING = 4
"""The band of an arm's swing, once in a stride."""

pytestmark = pytest.mark.skipif(not all(path.is_file() for path in WALKS), reason="recorded walks are not here")


def hands(rotation: np.ndarray) -> np.ndarray:
    """The swing of elbows and hands, seen from the hips, (T, 12)."""
    seen = rotation.copy()
    seen[:, 0] = (1.0, 0.0, 0.0, 0.0)
    position, _ = forward_kinematics(np.zeros((len(seen), 3)), seen)
    return split_bands(position[:, HANDS].reshape(len(seen), -1), SWING)[SWING - 1]


def in_time(model: UpperBodyRegression, unseen: SampledClip) -> float:
    made, told = unseen.rotation.copy(), model.predict(unseen)
    made[:, list(UPPER)] = model.rotations(told, np.zeros_like(told))
    return correlation(hands(unseen.rotation), hands(made))


def test_arms_of_one_walker_never_seen_are_in_time() -> None:
    first, *others = (sample_clip(read_material([path]).clips[0].clip) for path in WALKS)
    assert in_time(learn_upper_body(others, UPPER, None), first) > 0.5


@pytest.mark.long
def test_arms_of_a_walker_never_seen_are_in_time() -> None:
    takes = [sample_clip(read_material([path]).clips[0].clip) for path in WALKS]
    places = next(one for one in DRIVER_SETS if one.measured != ROTATIONS)
    for drive, least in ((None, 0.5), (places, 0.4)):
        models = [learn_upper_body([*takes[:n], *takes[n + 1 :]], UPPER, drive) for n in range(len(takes))]
        found = [in_time(model, take) for model, take in zip(models, takes, strict=True)]
        assert min(found) > least
        assert np.mean(found) > least + 0.1
