import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.editing.foot_correction import find_feet
from live.motion.editing.turn_insertion import (
    BLEND_WINDOW,
    find_supports,
    insert_rotation,
    support_turns,
    turn_about,
)
from live.motion.step_clip import StepClip
from tests.fixtures.mostly_long import mostly_long
from tests.motion.editing.made_steps import random_clip, sketched_step

WALKS = ("walk", "samba", "kick", "turn", "side_step")
ANGLES = st.floats(-2.0 * np.pi, 2.0 * np.pi)


def turn_points(points: npt.NDArray[np.floating], yaw: float) -> npt.NDArray[np.floating]:
    return quaternion.rotate(quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(yaw)), points)


def supports_of(step: StepClip, measure: int = 0) -> list[tuple[int, int, int]]:
    begin = step.first + measure * step.samples_per_measure
    last = int(np.ceil(begin + (1.0 - BLEND_WINDOW) * step.samples_per_measure))
    found = find_supports(
        find_feet(step.clip),
        step.clip.sample_rate,
        int(np.ceil(begin)),
        int(np.ceil(begin + step.samples_per_measure)),
        last=last,
    )
    return [(s.start, s.stop, s.foot) for s in found]


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(st.sampled_from(WALKS), ANGLES)
def test_end_turns_by_angle_and_beginning_stays(name: str, angle: float) -> None:
    step = sketched_step(name, "in place")
    edited = insert_rotation(step, angle)
    first, end = round(step.first), round(step.first + step.samples_per_measure)
    for before, after in (
        (step.clip.root_position, edited.clip.root_position),
        (step.clip.rotation, edited.clip.rotation),
    ):
        assert np.allclose(after[:first], before[:first], atol=1e-6)
    whole = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), np.asarray(angle))
    expected = quaternion.mul(whole, step.clip.rotation[end:, 0])
    assert np.allclose(np.abs(np.sum(expected * edited.clip.rotation[end:, 0], axis=-1)), 1.0, atol=1e-6)
    assert np.array_equal(edited.clip.rotation[:, 1:], step.clip.rotation[:, 1:])
    assert np.array_equal(edited.clip.root_position[:, 1], step.clip.root_position[:, 1])


@pytest.mark.long
@settings(max_examples=20, deadline=None)
@given(st.sampled_from(WALKS), st.sampled_from((0.0, 0.3, 0.5)), ANGLES)
def test_support_foot_stays_in_place(name: str, softness: float, angle: float) -> None:
    step = sketched_step(name)
    before = find_feet(step.clip).ball
    after = find_feet(insert_rotation(step, angle, softness=softness).clip).ball
    for start, stop, foot in supports_of(step):
        way = np.linalg.norm(np.diff(before[start - 1 : stop, foot], axis=0), axis=-1)
        assert np.linalg.norm(np.diff(after[start - 1 : stop, foot], axis=0), axis=-1) == pytest.approx(way, abs=2e-6)


def test_blend_window_and_tail_move_rigidly() -> None:
    step = sketched_step("walk", "long forward")
    edited = insert_rotation(step, 1.3)
    begin = int(np.ceil(step.first + (1.0 - BLEND_WINDOW) * step.samples_per_measure)) - 1
    before = turn_points(step.clip.root_position[begin:].astype(np.float64), 1.3)
    moved = edited.clip.root_position[begin:] - before
    assert np.ptp(moved, axis=0) == pytest.approx([0.0] * 3, abs=2e-6)


def test_selected_samples_share_angle_evenly() -> None:
    step = sketched_step("walk")
    edited = insert_rotation(step, 1.0)
    inverse = quaternion.inverse(step.clip.rotation[:, 0].astype(np.float64))
    added = quaternion.mul(edited.clip.rotation[:, 0].astype(np.float64), inverse)
    yaw = 2.0 * np.arctan2(added[:, 2], added[:, 0])
    rate = np.diff(yaw)
    selected = np.zeros(len(rate), np.bool_)
    for start, stop, _ in supports_of(step):
        selected[start - 1 : stop - 1] = True
    assert rate[selected] == pytest.approx(1.0 / selected.sum(), abs=1e-6)
    assert rate[~selected] == pytest.approx(0.0, abs=1e-6)


def test_turn_about_matches_thesis_loop() -> None:
    clip = random_clip(3)
    chance = np.random.default_rng(5)
    increment = np.where(chance.random(clip.sample_count) < 0.5, chance.uniform(-0.2, 0.2, clip.sample_count), 0.0)
    pivot = chance.uniform(-1, 1, (clip.sample_count, 2))
    root = clip.root_position.astype(np.float64)
    point = np.insert(pivot, 1, 0.0, axis=1)
    for n in range(clip.sample_count):
        foot = point[n].copy()
        root[n:] = turn_points(root[n:], increment[n])
        point[n:] = turn_points(point[n:], increment[n])
        back = foot - point[n]
        root[n:] += back
        point[n:] += back
    assert np.allclose(turn_about(clip, increment, pivot).root_position, root, atol=2e-6)


def hips_by_closed_form(
    step: StepClip, measure: int, angle: float, *, softness: float = 0.0
) -> tuple[Clip, npt.NDArray[np.floating]]:
    """The edited clip and the error of the closed-form hip positions at the samples of the measure, (n, 2)."""
    turns = support_turns(step, measure, softness=softness)
    begin = step.first + measure * step.samples_per_measure
    samples = np.arange(int(np.ceil(begin)), int(begin + step.samples_per_measure) + 1)
    fraction = (samples - begin) / step.samples_per_measure
    hips = step.clip.root_position[samples].astype(np.float64)
    place = [turn_points(p, yaw)[[0, 2]] for p, yaw in zip(hips, angle * turns.share(fraction), strict=True)]
    edited = insert_rotation(step, angle, measure=measure, softness=softness)
    expected = edited.clip.root_position[samples][:, (0, 2)]
    return edited.clip, np.abs(place + turns.displacement(fraction, angle) - expected)


@mostly_long(
    ("name", "measure"), [("walk", 0), ("samba", 0), ("kick", 0), ("grapevine", 1), ("mambo", 0)], quick=[1, 2, 3, 4]
)
@mostly_long("softness", [0.0, 0.4], quick=[1])
def test_closed_form_matches_loop_within_half_sample(name: str, measure: int, softness: float) -> None:
    _, error = hips_by_closed_form(sketched_step(name), measure, 1.5, softness=softness)
    assert error[-1] == pytest.approx([0.0, 0.0], abs=1e-5)
    assert error.max() < 0.012


@pytest.mark.parametrize("name", ["arm_wave", "jump", "groove"])
def test_angle_without_single_support_follows_foot_motion(name: str) -> None:
    step = sketched_step(name)
    turns = support_turns(step, 0)
    assert turns.weight.sum() == pytest.approx(1.0)
    assert (turns.stop <= 1.0 - BLEND_WINDOW + 1e-12).all()
    _, error = hips_by_closed_form(step, 0, -1.0)
    assert error[-1] == pytest.approx([0.0, 0.0], abs=2e-4)
    if name == "jump":
        busiest = int(np.argmax(turns.weight))
        middle = round(step.first + 0.5 * (turns.start[busiest] + turns.stop[busiest]) * step.samples_per_measure)
        assert turns.weight[busiest] > 0.3
        assert not step.clip.contact[middle].any()


def test_two_measure_step_turns_in_one_or_both() -> None:
    step = sketched_step("grapevine")
    line = round(step.first + step.samples_per_measure)
    second = insert_rotation(step, 1.0, measure=1)
    assert np.allclose(second.clip.root_position[:line], step.clip.root_position[:line], atol=1e-6)
    both = insert_rotation(step, 1.0)
    half = quaternion.mul(both.clip.rotation[line, 0], quaternion.inverse(step.clip.rotation[line, 0]))
    assert 0.2 < 2.0 * np.arctan2(half[2], half[0]) < 0.8


@pytest.mark.parametrize(
    "options", [{"measure": 1}, {"measure": -1}, {"window": -0.1}, {"window": 1.0}, {"softness": 0.6}]
)
def test_invalid_options_are_refused(options: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=r"measure|window|softness"):
        insert_rotation(sketched_step("walk"), 1.0, **options)  # type: ignore[arg-type]
