"""Tests of moods (T143): they change posture, size and timing of any step, live and softly, and feet stay."""

import numpy as np
import pytest

from live.base.motion_parameters import MOOD_NAMES, MOODS, MOTION_PREFIX
from live.clock.ticks import TICK
from live.control.events import events
from live.control.registry.registry import REGISTRY
from live.motion.pose.mood_pose import FIRST, LATE_BEATS, MAX_DROP, MoodPose
from live.motion.skeleton import SKELETON
from live.show.dancers.variation import section_values
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.mostly_long import mostly_long
from tests.show.dancers.danced_step import danced_step, shipped
from tests.show.made_show import PATCH, made_show

STAMP = {"time": 0.0, "source": "test"}
HIPS, HEAD, LEFT_HAND = (SKELETON.index(name) for name in ("hips", "head", "leftHand"))
FEET = [SKELETON.index(side + name) for side in ("left", "right") for name in ("Foot", "Toes")]


def danced(ticks=1, **moods):
    """Joints of all dancers at the last `ticks` ticks, (T, A, J, 3) [m], after two seconds in these moods."""
    show, found = made_show(), []
    for name, value in moods.items():
        assert show.apply(events.SetParameter(address=f"{MOTION_PREFIX}mood_{name}", value=(value,), **STAMP))
    for tick in range(160 + ticks):
        show.tick((tick + 1) * TICK)
        if tick >= 160:
            time = (tick + 1) * TICK
            found.append(show.dancers.pose(show.span.fraction(show.clock.beat), time)[0].astype(np.float64).copy())
    return np.array(found)


def over_feet(position):
    """Height of the hips over the lower foot [m], (T, A)."""
    return position[:, :, HIPS, 1] - position[:, :, FEET, 1].min(axis=2)


def test_a_strong_dancer_is_lower_and_keeps_the_feet():
    plain, strong = danced(60), danced(60, weight=1.0)
    sunk = over_feet(plain) - over_feet(strong)
    assert 0.04 < sunk.mean() < MAX_DROP + 0.01
    moved = np.linalg.norm((plain - strong)[:, :, FEET], axis=-1)
    assert np.median(moved) < 0.002
    assert moved.max() < 0.04  # swinging feet


@mostly_long(("mood", "value"), [("confidence", -1.0), ("energy", -1.0)], quick=[])
def test_the_shy_and_the_tired_bow_and_their_opposites_stay_upright(mood, value):
    low, plain, high = (danced(60, **{mood: end}) for end in (value, 0.0, -value))
    height = [(one[:, :, HEAD] - one[:, :, HIPS])[..., 1].mean() for one in (low, plain, high)]
    ahead = [np.linalg.norm((one[:, :, HEAD] - one[:, :, HIPS])[..., ::2], axis=-1).mean() for one in (low, plain)]
    assert height[0] < height[1] - 0.01
    assert ahead[0] > ahead[1] + 0.04
    assert height[2] == pytest.approx(height[1], abs=0.02)


@pytest.mark.long
def test_energy_makes_movements_larger():
    tired, awake = (danced(120, energy=end) for end in (-1.0, 1.0))
    size = [(one[:, :, LEFT_HAND] - one[:, :, HIPS]).std(axis=0).mean() for one in (tired, awake)]
    assert size[1] > 1.15 * size[0]


def test_time_changes_speeds_between_beats_and_nothing_at_them():
    show = made_show()
    plain, sudden, beats = np.zeros(9), np.zeros(9), np.arange(4)
    warp = np.zeros((4, 9))
    variation = show.variation
    for number, mood in ((0, plain), (1, sudden)):
        variation.mood[1] = float(number)
        for beat in beats:
            variation.phases(mood, beat / 4.0, warp)
            assert mood == pytest.approx(beat / 4.0, abs=1e-9)
    at = np.linspace(0.0, 1.0, 401)
    phases = np.array([np.zeros(9) for _ in at])
    for row, fraction in zip(phases, at, strict=True):
        variation.phases(row, fraction, warp)
    speed = np.diff(phases[:, 0]) / np.diff(at)
    assert speed.min() > 0.3
    assert speed[45:55].mean() > 1.4 > 0.6 > speed[98:103].mean()  # in the middle of the first beat, and at the second


def largest_cross_correlation(one, other):
    """Ticks by which the movement `other` (T,) is behind `one` (T,)."""
    one, other = one - one.mean(), other - other.mean()
    lags = range(-20, 21)
    found = [np.dot(one[20:-20], other[20 + lag : len(other) - 20 + lag]) for lag in lags]
    return lags[int(np.argmax(found))]


@pytest.mark.long
def test_hands_of_free_dancers_are_late():
    """A reach sideways comes later, by the lateness at most, and trunk and feet are as without the mood."""
    found = danced_step(shipped("reach"), seconds=8.0, moods=["", "flow = 1.0"])
    plain, free = found[:, 0], found[:, 1]
    away = free[:, [HIPS, *FEET]] - plain[:, [HIPS, *FEET]]
    assert np.ptp(away, axis=0).max() < 1e-4
    ways = [(one[:, LEFT_HAND] - one[:, SKELETON.index("upperChest")])[:, 0] for one in (plain, free)]
    behind = largest_cross_correlation(*ways) * TICK * 112 / 60  # beats
    assert 0.4 * LATE_BEATS < behind < LATE_BEATS


@pytest.mark.long
def test_late_arms_stay_continuous_over_measure_lines():
    found = danced_step(shipped("samba"), seconds=8.0, moods=["", "flow = 1.0"])
    jump = np.linalg.norm(np.diff(found, 2, axis=0), axis=-1).max(axis=(0, 2))
    assert jump[1] < 1.5 * jump[0]


def test_the_awake_and_the_tired_breathe_and_the_bound_hold_their_breath():
    pose, mood = MoodPose(1), np.zeros((6, 1))
    chest = SKELETON.index("upperChest") - FIRST

    def breath():
        found = []
        for second in np.arange(0.0, 20.0, 0.05):
            pose.set(mood, second)
            found.append(pose.bend[0, chest, 0])
        return np.array(found)

    assert np.ptp(breath()) == 0.0
    periods = []
    for energy in (1.0, -1.0):
        mood[5] = energy
        trace = breath()
        assert np.degrees(np.ptp(trace)) > 4.0
        periods.append((np.diff(np.sign(trace - trace.mean())) > 0).sum())
    assert periods[0] > 1.8 * periods[1]  # the awake breathe more often
    mood[3] = -1.0
    assert np.ptp(breath()) == pytest.approx(0.0, abs=1e-7)


def test_moods_are_followed_softly():
    show = made_show()
    for tick in range(100):
        show.tick((tick + 1) * TICK)
    before = show.dancers.pose(show.span.fraction(show.clock.beat), 100 * TICK)[0].copy()
    for row in MOODS:
        show.apply(events.SetParameter(address=row.address, value=(-1.0,), **STAMP))
    largest = 0.0
    for tick in range(100, 200):
        show.tick((tick + 1) * TICK)
        now = show.dancers.pose(show.span.fraction(show.clock.beat), (tick + 1) * TICK)[0].copy()
        largest, before = max(largest, np.linalg.norm(now - before, axis=-1).max()), now
    assert largest < 0.12  # m in a tick: 7.7 m/s, hands of the quickest step
    assert show.variation.mood == pytest.approx(-1.0, abs=0.03)


@mostly_long("end", [-1.0, 1.0], quick=[1])
def test_all_moods_at_once_are_finite_and_over_the_floor(end):
    found = danced(90, **dict.fromkeys(MOOD_NAMES, end))
    assert np.isfinite(found).all()
    assert found[..., 1].min() > -0.02


def test_the_command_sets_one_mood_of_some_dancers():
    event = REGISTRY.call("/dance/mood", ("back", "confidence", -0.5), 0.0, "test")
    assert event == events.SetParameter(
        address=f"{MOTION_PREFIX}mood_confidence", value=(-0.5,), group="back", time=0.0, source="test"
    )
    show = made_show()
    assert show.apply(event)
    wanted = show.variation[MOODS[4]]
    assert (wanted[:5] == 0.0).all()
    assert wanted[5:] == pytest.approx(-0.5)


@pytest.mark.parametrize("words", [("back", "weight", 1.5), ("back", "weight")])
def test_values_beyond_the_ends_are_refused(words):
    assert not isinstance(REGISTRY.call("/dance/mood", words, 0.0, "test"), events.SetParameter)


def test_an_unknown_mood_is_refused_with_those_that_there_are():
    show = made_show()
    assert not show.apply(REGISTRY.call("/dance/mood", ("back", "courage", 0.5), 0.0, "test"))
    assert "mood_courage" in show.refusals.last_reason
    assert "/dance/motion/mood_confidence" in show.refusals.last_reason


def test_a_group_has_its_own_mood_over_the_patchs():
    text = PATCH.replace('name = "back"', 'name = "back"\nmood = { weight = -1.0 }', 1)
    patch = parse_patch(text + "\n[mood]\nweight = 0.5\nenergy = 0.25\n", "test.toml")
    values = np.array([section_values(patch, group) for group in patch.group])
    at = {row.patch: row.first for row in MOODS}
    assert values[:, at["mood.weight"]].tolist() == [0.5, -1.0]
    assert values[:, at["mood.energy"]].tolist() == [0.25, 0.25]


def test_indirect_dancers_roam_each_at_another_time():
    pose, mood = MoodPose(3), np.zeros((6, 3))
    mood[2] = -1.0
    pose.set(mood, 1.0)
    turns = pose.bend[:, SKELETON.index("head") - 1, 1].copy()
    assert len(set(np.round(turns, 3))) == 3
    pose.set(mood, 2.0)
    assert not np.allclose(pose.bend[:, SKELETON.index("head") - 1, 1], turns)
