"""Tests of variation: draws by seed and measure, limits of the papers, monotonic warps that end on the beat."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.base.motion_parameters import (
    FOOT_LOCK,
    HEAD,
    MOTION_BY_ADDRESS,
    MOTION_PREFIX,
    MOTION_SIZE,
    OBEDIENCE,
    TURN_ON_SUPPORT,
    WARP_SEQUENCE,
)
from live.clock.ticks import TICK
from live.control.events import events
from live.graph.takes import NO_TAKE
from live.motion.editing.time_warp import measure_warp
from live.motion.skeleton import SKELETON
from live.show.dancers.measure_state import MeasureState
from live.show.dancers.variation import Variation, section_values
from live.show.loader import load_from_patch, load_show
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import DEFAULT_PATCH
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, PATCH, made_show

COUNT = 60
STAMP = {"time": 0.0, "source": "test"}
APART = 10.0
"""Distance between groups that must not affect each other [m]."""
UPPER = [SKELETON.index(name) for name in ("leftHand", "rightHand")]


def group_numbers(fields):
    """The motion parameters of two groups: those of the first by their last name, everything else without effect."""
    numbers = np.zeros((2, MOTION_SIZE))
    numbers[:, [FOOT_LOCK.first, TURN_ON_SUPPORT.first]] = 1.0
    numbers[:, OBEDIENCE.first] = 0.5
    for name, value in fields.items():
        numbers[0, MOTION_BY_ADDRESS[MOTION_PREFIX + name].first] = value
    return numbers


def make_variation(seed=1, beats=4, **fields):
    group = np.repeat([0, 1], COUNT // 2).astype(np.int32)
    return Variation(
        group_numbers(fields),
        group,
        seed=seed,
        beats_per_measure=beats,
        window=GRAPH.window,
    )


def draw_measure(variation, measure):
    danced = MeasureState(GRAPH, COUNT)
    danced.node[:] = GRAPH.library.step_index("glide") + np.arange(COUNT) % 3
    variation.draw(measure, danced)
    return danced


def test_draws_depend_only_on_seed_and_measure():
    fields = {"warp": 0.3, "amplitude": 0.2, "mix": 0.5, "arms": 0.5}
    one, again = draw_measure(make_variation(**fields), 7), draw_measure(make_variation(**fields), 7)
    other, seed = draw_measure(make_variation(**fields), 8), draw_measure(make_variation(seed=2, **fields), 7)
    for name in ("warp", "take", "take_share", "amplitude"):
        assert np.array_equal(getattr(one, name), getattr(again, name))
        assert not np.array_equal(getattr(one, name), getattr(other, name))
        assert not np.array_equal(getattr(one, name), getattr(seed, name))


def test_other_controls_do_not_change_warp_draws():
    few, many = (
        draw_measure(make_variation(warp=0.2), 3),
        draw_measure(make_variation(warp=0.2, amplitude=0.3, mix=0.4, arms=1.0), 3),
    )
    assert np.array_equal(few.warp, many.warp)


def test_default_settings_give_no_variation():
    danced = draw_measure(make_variation(), 5)
    assert not danced.warp[0].any()
    assert (danced.amplitude == 1.0).all()
    assert not danced.take_share.any()


def test_only_group_with_settings_varies():
    danced = draw_measure(make_variation(warp=0.3, amplitude=0.2, mix=0.5, arms=1.0), 5)
    assert danced.warp[0, : COUNT // 2].any()
    assert not danced.warp[0, COUNT // 2 :].any()
    assert not danced.take_share[:, COUNT // 2 :].any()


@pytest.mark.long
@settings(max_examples=30)
@given(st.integers(-4, 10_000), st.floats(0, 1), st.integers(1, 16))
def test_measure_warps_end_on_beat_and_are_monotonic(measure, beats_ahead, beats):
    variation = make_variation(beats=beats, warp=beats_ahead)
    danced = draw_measure(variation, measure)
    x = np.linspace(0, 1, 401)[:, None]
    phase = measure_warp(x, *danced.warp, GRAPH.window)
    assert np.diff(phase, axis=0).min() > 0
    assert phase[[0, -1]] == pytest.approx(np.array([[0.0], [1.0]]) + np.zeros(COUNT), abs=1e-6)
    assert np.abs(phase - x).max() <= beats_ahead / beats + 1e-9
    window = x[:, 0] >= 1.0 - GRAPH.window  # T052: the blend is never warped
    assert phase[window] == pytest.approx(x[window] + np.zeros(COUNT), abs=1e-9)


def test_amplitude_has_three_values_and_is_constant_per_measure():
    """T060 as corrected: 1 - R, 1 or 1 + R, each for about a third of the dancers, constant through a measure."""
    variation = make_variation(amplitude=0.2)
    values = np.concatenate([draw_measure(variation, measure).amplitude[:, : COUNT // 2].T for measure in range(30)])
    assert (values[:, 0] == values[:, 1]).all()
    found, counts = np.unique(values[:, 0].round(9), return_counts=True)
    assert found == pytest.approx([0.8, 1.0, 1.2])
    assert counts.min() > 0.25 * counts.sum()


def test_slow_amplitude_alternates_constant_and_moving_measures():
    """T059: constant for one measure, moving to the next value in the next one, continuous at every measure line."""
    variation = make_variation(amplitude=0.2, amplitude_sequence=1.0)
    rows = [draw_measure(variation, measure).amplitude[:, : COUNT // 2] for measure in range(12)]
    for measure, (one, then) in enumerate(itertools.pairwise(rows)):
        assert np.array_equal(one[1], then[0])
        assert (one[0] == one[1]).all() == (measure % 2 == 0)


def test_arms_and_mixtures_use_another_take():
    danced = draw_measure(make_variation(mix=0.6, arms=0.5), 2)
    mine = slice(0, COUNT // 2)
    assert (danced.take[mine] != NO_TAKE).all()
    assert 0 < danced.take_share[0, mine].max() <= 0.6
    whole = danced.take_share[1, mine] == 1.0
    assert 0.2 < whole.mean() < 0.8


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31 - 1), st.integers(1, 8))
def test_sequence_warp_is_smooth_and_monotonic(seed, beats):
    """T056: position in measures, m + x + w, increases; it is continuous at measure lines and within the limit."""
    variation = make_variation(seed=seed, beats=beats, warp=0.5, warp_sequence=1.0)
    places, x = [], np.linspace(0, 1, 65)[:-1]
    for measure in range(12):
        variation.begin_measure(measure)
        places += [measure + t + variation.sequence_warp(t) for t in x]
    places = np.array(places)
    assert np.diff(places, axis=0).min() > 0
    assert np.abs(np.diff(places, n=2, axis=0)).max() < 2e-3  # a jump of 1 % of a measure would show as 1e-2
    ahead = places - np.arange(len(places))[:, None] / 64
    assert np.abs(ahead).max() <= min(0.5 / beats, 0.12) + 1e-9
    assert np.abs(ahead[:, : COUNT // 2]).max() > 0.01


def test_group_settings_override_patch_settings():
    text = PATCH.split("[clock]")[0] + "[motion]\nhead = 0.5\nfoot_lock = false\n[clock]" + PATCH.split("[clock]")[1]
    text = text.replace('name = "front"', 'name = "front"\nmotion = {head = 1.0, warp_over = "sequence"}')
    patch = parse_patch(text, "test.toml")
    front, back = (np.array(section_values(patch, group)) for group in patch.group)
    rows = [HEAD.first, FOOT_LOCK.first, WARP_SEQUENCE.first]
    assert front[rows].tolist() == [1.0, 0.0, 1.0]
    assert back[rows].tolist() == [0.5, 0.0, 0.0]


def hand_positions(show, seconds):
    view, frames = show.view(), []
    for tick in range(1, int(64 * seconds)):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        frames.append(view.joint_position[:, UPPER].copy())
    return np.array(frames)


def show_with_separate_groups():
    """The first show on a stage large enough that its groups, ten meters apart, never meet."""
    text = DEFAULT_PATCH.read_text(encoding="utf-8")
    for old, new in (
        ("width = 9.6", "width = 24.0"),
        ("depth = 6.0", "depth = 26.0"),
        ("centre = [0.0, 1.75]", f"centre = [0.0, {APART}]"),
        ("centre = [0.0, -1.75]", f"centre = [0.0, -{APART}]"),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    return load_from_patch(parse_patch(text, "test.toml"), DEFAULT_PATCH).start()


def rotations(field, value):
    """Poses of the first show (F, A, J, 4), eight a second, with only one control of its first group set."""
    show = show_with_separate_groups()
    for address in MOTION_BY_ADDRESS:
        show.apply(events.SetParameter(address=address, value=(0.0,), **STAMP))
    group = show.patch.group[0].name.upper()
    show.apply(events.SetParameter(address=MOTION_PREFIX + field, value=(value,), group=group, **STAMP))
    for section, z in zip(show.patch.group, (APART, 0.0, -APART), strict=True):
        show.apply(events.PlaceElement(kind="attract", points=((3.0, z - 0.75),), group=section.name.upper(), **STAMP))
    view, frames = show.view(), []
    for tick in range(1, 64 * 8):
        show.tick(tick * TICK)
        if tick % 8 == 0:
            show.fill(view, tick * TICK)
            frames.append(view.joint_rotation.copy())
    return np.array(frames), show.group == 0


@pytest.fixture(scope="module")
def neutral_rotations():
    return rotations("head", 0.0)[0]


@mostly_long(
    "field",
    [
        *("warp", "arms", "face_average"),
        *(
            pytest.param(one, marks=pytest.mark.long)
            for one in ("amplitude", "mix", "head", "turn_on_support", "mirror")
        ),
    ],
    quick=[],
)
def test_each_control_changes_poses_of_its_group_only(field, neutral_rotations):
    """In the show: the events differ in one control, and only the poses of that group differ.

    The groups are far apart, because dancers that meet change each other's paths.
    """
    row = MOTION_BY_ADDRESS[MOTION_PREFIX + field]
    poses, own = rotations(field, row.high)
    other = rotations(field, row.low)[0] if field == "mirror" else neutral_rotations  # without it some are mirrored
    changed = np.abs(poses - other).max(axis=(0, 2, 3))
    assert (changed[own] > 1e-3).mean() > 0.5
    assert changed[~own].max() < 1e-5  # the arithmetic of a block rounds


def test_unknown_groups_and_controls_are_refused_and_counted():
    show = made_show()
    assert not show.apply(events.SetParameter(address="/dance/motion/head", value=(1.0,), group="nobody", **STAMP))
    assert not show.apply(events.SetParameter(address="/dance/motion/seed", value=(1.0,), **STAMP))
    assert show.refusals.count == 2
    assert show.apply(events.SetParameter(address="/dance/motion/head", value=(1.0,), group="*", **STAMP))


@pytest.mark.long
@pytest.mark.parametrize("side", [-1.0, pytest.param(1.0, marks=pytest.mark.long)])
def test_mirror_extremes_select_one_side_only(side):
    """T042: all steps of the first show have mirror images; from the second decided measure on one side is used."""
    show = load_show(DEFAULT_PATCH).start()
    show.apply(events.SetParameter(address="/dance/motion/mirror", value=(side,), **STAMP))
    library, danced = show.graph.library, []
    for tick in range(1, 64 * 18):
        if show.tick(tick * TICK) and show.span.number > 1:
            steps = {int(node) for node in show.dancers.node}
            has_both = [
                node for node in steps
                if len({int(s) for s in library.node_side[library.node_step == library.node_step[node]]}) == 2
            ]  # fmt: skip
            danced += [int(library.node_side[node]) for node in has_both]
    assert len(danced) > 20
    assert np.mean(np.array(danced) == side) > 0.9  # a wrong side is better than a wrong step


@pytest.mark.long
def test_dancers_drifting_over_measure_lines_stay_continuous():
    """With a sequence warp dancers are in different measures at one time: no joint jumps."""
    show = made_show()
    for name, value in (("warp", 0.45), ("warp_sequence", 1.0), ("foot_lock", 0.0)):
        show.apply(events.SetParameter(address=MOTION_PREFIX + name, value=(value,), **STAMP))
    moved = np.linalg.norm(np.diff(hand_positions(show, 20), axis=0), axis=3) * 64
    assert moved.max() < 5.0
