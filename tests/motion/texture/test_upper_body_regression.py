"""Laws of what legs tell: a coupling is recovered, nothing told is the mean pose, poor data gives the mean, not NaN."""

from dataclasses import replace

import numpy as np
import pytest

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.quaternion import mean_rotation
from live.motion.skeleton import SKELETON
from live.motion.texture.drivers import DRIVER_SETS, ROTATIONS, driver_signals
from live.motion.texture.frequency_bands import SampledClip, sample_clip, split_bands
from live.motion.texture.texture_corpus import make_corpus
from live.motion.texture.texture_settings import UPPER, TextureSettings
from live.motion.texture.texture_synthesis import texture_sketch
from live.motion.texture.upper_body_regression import UpperBodyRegression, damp_bands, learn_upper_body
from tests.fixtures.mostly_long import mostly_long
from tests.motion.texture.made_dance import improvisation, without_arms

ARMS = [SKELETON.index(name) for name in ("leftUpperArm", "rightUpperArm", "leftLowerArm", "rightLowerArm")]


def learn(told: float, seeds: range = range(4), seconds: float = 12.0) -> UpperBodyRegression:
    return learn_upper_body([sample_clip(improvisation(seconds, seed, told)) for seed in seeds], UPPER)


def angles_apart(a: np.ndarray, b: np.ndarray) -> float:
    """Root mean square angle between rotations."""
    away = quaternion.to_rotation_vector(quaternion.mul(quaternion.inverse(a), b))
    return float(np.sqrt((away * away).sum(axis=-1).mean()))


def errors(model: UpperBodyRegression, unseen: SampledClip) -> tuple[float, float]:
    """Error of the prediction and of the mean pose at an unseen take [rad]."""
    made = model.predict(unseen)
    rows = [UPPER.index(joint) for joint in ARMS]
    rotations = model.rotations(made, np.zeros_like(made))[:, rows]
    real = unseen.rotation[:, ARMS]
    return angles_apart(rotations, real), angles_apart(model.reference[ARMS], real)


def twisted(take: SampledClip, degrees: float) -> SampledClip:
    """The same places of knees, from thighs and shins whose bones are twisted: a recording with another convention."""
    half = np.radians(degrees) / 2.0
    turn = np.array((np.cos(half), 0.0, np.sin(half), 0.0))
    rotation = take.rotation.copy()
    for thigh, shin in (("leftUpperLeg", "leftLowerLeg"), ("rightUpperLeg", "rightLowerLeg")):
        rotation[:, SKELETON.index(thigh)] = quaternion.mul(rotation[:, SKELETON.index(thigh)], turn)
        rotation[:, SKELETON.index(shin)] = quaternion.mul(quaternion.inverse(turn), rotation[:, SKELETON.index(shin)])
    return replace(take, rotation=rotation)


def test_places_do_not_depend_on_how_bones_are_twisted() -> None:
    take = sample_clip(improvisation(4.0, 5))
    other = twisted(take, 25.0)
    reference = mean_rotation(take.rotation)
    for drivers in DRIVER_SETS:
        one, two = (driver_signals(each, drivers, reference) for each in (take, other))
        if drivers.measured == ROTATIONS:
            assert np.abs(one - two).max() > 0.3
        else:
            assert one == pytest.approx(two, abs=2e-3)


@pytest.mark.long
def test_known_coupling_is_recovered_at_unseen_take() -> None:
    model = learn(1.0)
    error, mean = errors(model, sample_clip(improvisation(20.0, 99)))
    assert error < 0.4 * mean
    told = model.told_shares()
    assert min(told["upper arms"], told["lower arms"]) > 0.8
    assert told["head"] == 0.0
    for part in model.groups:
        if part.name == "upper arms":
            assert part.gains[1:5].max(initial=0.0) > 0.8 or part.part == "pose"


@pytest.mark.long
def test_mean_pose_where_legs_tell_nothing() -> None:
    ratios = []
    for first in (0, 10):
        model = learn(0.0, range(first, first + 4))
        error, mean = errors(model, sample_clip(improvisation(20.0, first + 99, 0.0)))
        ratios.append(error / mean)
        assert all(part.error <= part.mean_error for part in model.groups)
    assert np.mean(ratios) < 1.02
    assert max(ratios) < 1.05


@pytest.mark.long
def test_expected_error_with_variation_stays_below_mean_poses() -> None:
    model = learn(0.6)
    for share in (0.0, 0.25, 1.0):
        variation = model.variation(share).reshape(-1, len(UPPER), 3)
        for name in ("upper arms", "lower arms"):
            parts = [part for part in model.groups if part.name == name]
            rows = [UPPER.index(joint) for joint in parts[0].joints]
            added = 3.0 * float((variation[:, rows] ** 2).mean())
            gained = sum(part.mean_error - part.error for part in parts)
            assert added <= share * gained + 1e-12
            assert added > 0.0 or share == 0.0
    unseen = improvisation(20.0, 98, 0.6)
    corpus = make_corpus([improvisation(20.0, seed, 0.6) for seed in range(4)], [sample_clip(unseen)])
    made = texture_sketch(without_arms(unseen), corpus, TextureSettings(texture=(), learnt=True, spread=1.0))[0].clip
    middle = mean_rotation(np.concatenate([clip.rotation for clip in corpus.clips]))[ARMS]
    real = unseen.rotation[:, ARMS].astype(np.float64)
    assert angles_apart(made.rotation[:, ARMS].astype(np.float64), real) < angles_apart(middle, real)


@pytest.mark.long
def test_variation_has_no_rhythm_that_legs_do_not_tell() -> None:
    """In no group may it move more than half of what each band of the prediction moves, together (share 0.25)."""
    model = learn(0.7)
    moved, still = (sample_clip(clip) for clip in (improvisation(10.0, 97), standing(10.0)))
    told = model.predict(moved)
    added = model.variation(0.25, told)
    assert np.sqrt((added**2).mean()) > 0.01
    for group in model.groups:
        if group.part == "movement":
            rows = [UPPER.index(joint) for joint in group.joints]
            bands = split_bands(told.reshape(-1, len(UPPER), 3)[:, rows], 6)
            most = 0.5 * sum(np.sqrt((band**2).mean()) for band in bands[1:5])
            assert np.sqrt((added.reshape(-1, len(UPPER), 3)[:, rows] ** 2).mean()) <= most + 1e-9
    assert np.abs(model.variation(0.25, model.predict(still))).max() < 0.02 * np.abs(added).max()


@pytest.mark.long
def test_copies_do_not_make_an_independent_arm_look_told() -> None:
    take = sample_clip(improvisation(20.0, 1, 0.0))
    others = [sample_clip(improvisation(20.0, seed, 0.0)) for seed in (2, 3)]
    model = learn_upper_body([take, take, *others], UPPER)
    assert model.dances.count == 3
    assert max(model.told_shares().values()) < 0.05
    alone = learn_upper_body([take, take, take], UPPER)
    assert alone.dances.count == 1
    assert alone.report(0.25)["left_out"] == "parts of the only choreography"
    assert max(alone.told_shares().values()) < 0.05


@pytest.mark.long
def test_learning_is_deterministic() -> None:
    one, two = (learn(0.5, range(2), 8.0) for _ in range(2))
    unseen = sample_clip(improvisation(5.0, 50))
    assert np.array_equal(one.predict(unseen), two.predict(unseen))


def standing(seconds: float) -> Clip:
    clip = improvisation(seconds, 7)
    return replace(clip, rotation=np.broadcast_to(clip.rotation[:1], clip.rotation.shape).copy())


@mostly_long(
    "clips",
    [
        [improvisation(12.0, 1)],
        [improvisation(1.2, 1)],
        [standing(6.0)],
        [standing(6.0), standing(3.0)],
        [standing(6.0), improvisation(6.0, 3)],
        [improvisation(1.0, 1), improvisation(30.0, 2, 0.0)],
    ],
    quick=[1],
    ids=["one take", "a second", "one stands", "both stand", "one of two stands", "short and mixed"],
)
def test_poor_data_gives_finite_motion_near_the_mean(clips: list[Clip]) -> None:
    for sketch in (without_arms(improvisation(4.0, 9)), standing(4.0)):
        model = learn_upper_body([sample_clip(clip) for clip in clips], UPPER)
        made = model.predict(sample_clip(sketch))
        assert np.isfinite(made).all()
        assert np.abs(made).max() < np.pi
        rotations = model.rotations(made, np.zeros_like(made))
        assert np.abs(np.linalg.norm(rotations, axis=-1) - 1.0).max() < 1e-9
    if len(clips) == 1 and clips[0].name == "improvisation 7":
        assert np.abs(made).max() < 1e-6


def test_damped_bands_are_the_signal_at_gain_one_and_nothing_at_zero() -> None:
    signal = np.random.default_rng(1).normal(size=(100, 3)).cumsum(axis=0)
    assert damp_bands(signal, np.ones(7)) == pytest.approx(signal)
    assert not damp_bands(signal, np.zeros(7)).any()
