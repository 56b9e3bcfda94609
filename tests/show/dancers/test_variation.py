"""Variation: drawn by seed and measure alone, within the papers' limits, back on the beat, never backwards."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from live.clock.ticks import TICK
from live.control.events import events
from live.graph.takes import NO_TAKE
from live.motion.editing.time_warp import measure_warp
from live.motion.skeleton import SKELETON
from live.show.dancers.measure_state import MeasureState
from live.show.dancers.variation import Variation, VariationSettings, settings_of
from live.show.loader import load_from_patch, load_show
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import DEFAULT_PATCH
from tests.show.made_show import GRAPH, PATCH, made_show

COUNT = 60
STAMP = {"time": 0.0, "source": "test"}
APART = 10.0
"""Metres from one group to the next where they must have nothing to do with each other."""
UPPER = [SKELETON.index(name) for name in ("leftHand", "rightHand")]


def varied(seed=1, beats=4, **fields):
    group = np.repeat([0, 1], COUNT // 2).astype(np.int32)
    return Variation(
        [VariationSettings(**fields), VariationSettings()],
        group,
        seed=seed,
        beats_per_measure=beats,
        window=GRAPH.window,
    )


def drawn(variation, measure):
    danced = MeasureState(GRAPH, COUNT)
    danced.node[:] = GRAPH.library.step_index("glide") + np.arange(COUNT) % 3
    variation.draw(measure, danced)
    return danced


def test_draws_depend_on_the_seed_and_the_measure_alone():
    fields = {"warp_beats": 0.3, "amplitude": 0.2, "mix": 0.5, "arms": 0.5}
    one, again = drawn(varied(**fields), 7), drawn(varied(**fields), 7)
    other, seed = drawn(varied(**fields), 8), drawn(varied(seed=2, **fields), 7)
    for name in ("warp", "take", "take_share", "amplitude"):
        assert np.array_equal(getattr(one, name), getattr(again, name))
        assert not np.array_equal(getattr(one, name), getattr(other, name))
        assert not np.array_equal(getattr(one, name), getattr(seed, name))


def test_one_control_changes_no_other_chance():
    few, many = drawn(varied(warp_beats=0.2), 3), drawn(varied(warp_beats=0.2, amplitude=0.3, mix=0.4, arms=1.0), 3)
    assert np.array_equal(few.warp, many.warp)


def test_nothing_varies_where_nothing_is_asked():
    danced = drawn(varied(), 5)
    assert not danced.warp[0].any()
    assert (danced.amplitude == 1.0).all()
    assert not danced.take_share.any()


def test_only_the_group_that_asks_varies():
    danced = drawn(varied(warp_beats=0.3, amplitude=0.2, mix=0.5, arms=1.0), 5)
    assert danced.warp[0, : COUNT // 2].any()
    assert not danced.warp[0, COUNT // 2 :].any()
    assert not danced.take_share[:, COUNT // 2 :].any()


@settings(max_examples=30)
@given(st.integers(-4, 10_000), st.floats(0, 1), st.integers(1, 16))
def test_measure_warps_are_back_on_the_beat_and_never_run_back(measure, beats_ahead, beats):
    variation = varied(beats=beats, warp_beats=beats_ahead)
    danced = drawn(variation, measure)
    x = np.linspace(0, 1, 401)[:, None]
    phase = measure_warp(x, *danced.warp, GRAPH.window)
    assert np.diff(phase, axis=0).min() > 0
    assert phase[[0, -1]] == pytest.approx(np.array([[0.0], [1.0]]) + np.zeros(COUNT), abs=1e-6)
    assert np.abs(phase - x).max() <= beats_ahead / beats + 1e-9
    window = x[:, 0] >= 1.0 - GRAPH.window  # T052: the blend is never warped
    assert phase[window] == pytest.approx(x[window] + np.zeros(COUNT), abs=1e-9)


def test_amplitude_is_one_of_three_for_a_measure():
    """T060 as corrected: 1 - R, 1 or 1 + R, each for about a third of the dancers, the same all through a measure."""
    variation = varied(amplitude=0.2)
    values = np.concatenate([drawn(variation, measure).amplitude[:, : COUNT // 2].T for measure in range(30)])
    assert (values[:, 0] == values[:, 1]).all()
    found, counts = np.unique(values[:, 0].round(9), return_counts=True)
    assert found == pytest.approx([0.8, 1.0, 1.2])
    assert counts.min() > 0.25 * counts.sum()


def test_slow_amplitude_comes_two_by_two():
    """T059: equal for a measure, moving to the next value in the following one, without a step at any line."""
    variation = varied(amplitude=0.2, amplitude_sequence=1.0)
    rows = [drawn(variation, measure).amplitude[:, : COUNT // 2] for measure in range(12)]
    for measure, (one, then) in enumerate(itertools.pairwise(rows)):
        assert np.array_equal(one[1], then[0])
        assert (one[0] == one[1]).all() == (measure % 2 == 0)


def test_arms_and_mixtures_are_of_another_take():
    danced = drawn(varied(mix=0.6, arms=0.5), 2)
    mine = slice(0, COUNT // 2)
    assert (danced.take[mine] != NO_TAKE).all()
    assert 0 < danced.take_share[0, mine].max() <= 0.6
    whole = danced.take_share[1, mine] == 1.0
    assert 0.2 < whole.mean() < 0.8


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31 - 1), st.integers(1, 8))
def test_the_warp_of_the_sequence_is_smooth_and_never_runs_back(seed, beats):
    """T056: position in measures, m + x + w, grows always; no step at the lines; never farther than asked."""
    variation = varied(seed=seed, beats=beats, warp_beats=0.5, warp_sequence=1.0)
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


def test_a_group_has_its_own_section_over_the_patchs():
    text = PATCH.split("[clock]")[0] + "[motion]\nhead = 0.5\nfoot_lock = false\n[clock]" + PATCH.split("[clock]")[1]
    text = text.replace('name = "front"', 'name = "front"\nmotion = {head = 1.0, warp_over = "sequence"}')
    patch = parse_patch(text, "test.toml")
    front, back = (settings_of(patch.motion_of(group)) for group in patch.group)
    assert (front.head, front.lock, front.warp_sequence) == (1.0, 0.0, 1.0)
    assert (back.head, back.lock, back.warp_sequence) == (0.5, 0.0, 0.0)


def hands(show, seconds):
    view, frames = show.view(), []
    for tick in range(1, int(64 * seconds)):
        show.tick(tick * TICK)
        show.fill(view, tick * TICK)
        frames.append(view.joint_position[:, UPPER].copy())
    return np.array(frames)


def groups_apart():
    """The first show on a stage so large that its groups, each ten metres behind the other, never meet."""
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
    """Poses of the first show (F, A, J, 4), eight a second, with one control of its first group set and no other."""
    show = groups_apart()
    for name in VariationSettings.names():
        show.apply(events.SetMotion(parameter=name, value=0.0, **STAMP))
    group = show.patch.group[0].name.upper()
    show.apply(events.SetMotion(parameter=field, value=value, group=group, **STAMP))
    for section, z in zip(show.patch.group, (APART, 0.0, -APART), strict=True):
        show.apply(events.Attract(x=3.0, z=z - 0.75, group=section.name.upper(), **STAMP))
    view, frames = show.view(), []
    for tick in range(1, 64 * 8):
        show.tick(tick * TICK)
        if tick % 8 == 0:
            show.fill(view, tick * TICK)
            frames.append(view.joint_rotation.copy())
    return np.array(frames), show.group == 0


@pytest.fixture(scope="module")
def nothing_set():
    return rotations("head", 0.0)[0]


@pytest.mark.parametrize(
    "field", ["warp_beats", "amplitude", "mix", "arms", "head", "on_support", "face_average", "mirror"]
)
def test_every_control_changes_what_is_danced(field, nothing_set):
    """Through the show itself: the same events but one, and the poses of that group alone differ.

    The groups are far apart: where they meet, a dancer who dances otherwise makes others give way otherwise.
    """
    poses, own = rotations(field, 0.9)
    changed = np.abs(poses - nothing_set).max(axis=(0, 2, 3))
    assert (changed[own] > 1e-3).mean() > 0.5
    assert changed[~own].max() < 1e-5  # the arithmetic of a block rounds


def test_controls_for_what_is_not_there_are_refused_and_counted():
    show = made_show()
    assert not show.apply(events.SetMotion(parameter="head", value=1.0, group="nobody", **STAMP))
    assert not show.apply(events.SetMotion(parameter="seed", value=1.0, **STAMP))
    assert show.refusals.count == 2
    assert show.apply(events.SetMotion(parameter="head", value=1.0, group="*", **STAMP))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_mirror_images_only_or_never(side):
    """T042: the first show's steps all have mirror images; from the second decided measure on only those are danced."""
    show = load_show(DEFAULT_PATCH).start()
    show.apply(events.SetMotion(parameter="mirror", value=side, **STAMP))
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


def test_dancers_who_drift_over_lines_stay_continuous():
    """With a warp over the sequence some are in the next measure and some still in the last: no joint jumps."""
    show = made_show()
    for name, value in (("warp_beats", 0.45), ("warp_sequence", 1.0), ("lock", 0.0)):
        show.apply(events.SetMotion(parameter=name, value=value, **STAMP))
    moved = np.linalg.norm(np.diff(hands(show, 20), axis=0), axis=3) * 64
    assert moved.max() < 5.0
