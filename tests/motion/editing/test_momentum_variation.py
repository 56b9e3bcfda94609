"""Variations of a step keep its balance and momentum, seen by physics of the segments; and they look like the step."""

import re
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest

from live.graph.step_library import build_library
from live.graph.takes import find_takes
from live.motion import quaternion
from live.motion.clip import resample
from live.motion.editing import momentum_variation
from live.motion.editing.interpolate import interpolate
from live.motion.editing.momentum_variation import vary_step, vary_steps
from live.motion.editing.path_bend import path_variants
from live.motion.editing.upper_body_angles import UPPER_BODY
from live.motion.editing.variation import LOWER
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import mirror_clip, mirror_step
from live.motion.quality.body_contact import self_contacts
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import StepClip
from tests.fixtures.mostly_long import mostly_long
from tests.motion.editing.body_physics import GRAVITY, measure_samples, physics_of
from tests.motion.editing.made_steps import sketched_step
from tests.places import ROOT

STEPS = ("walk", "samba", "jump", "arm_wave", "mambo", "turn")
HANDS = [SKELETON.index("leftHand"), SKELETON.index("rightHand")]
ARMS = [[SKELETON.index(side + part) for part in ("UpperArm", "LowerArm", "Hand")] for side in ("left", "right")]


@cache
def variations(name: str, count: int = 3, seed: int = 1) -> list[StepClip]:
    return vary_step(sketched_step(name), count, seed)


def joints(step: StepClip):
    """Joints (T, J, 3) and their world rotations (T, J, 4) in the step's measures."""
    first, last = measure_samples(step)
    clip = step.clip
    return forward_kinematics(
        clip.root_position[first : last + 1].astype(np.float64), clip.rotation[first : last + 1].astype(np.float64)
    )


def deviations(step: StepClip, other: StepClip) -> tuple[float, float, float]:
    """Largest deviation of the centre of mass [m], of the angular momentum as a share of its range, and of the
    zero-moment point while the floor carries at least half the weight [m]."""
    one, two = physics_of(step), physics_of(other)
    momentum = np.abs(two.momentum - one.momentum).max() / np.ptp(one.momentum, axis=0).max()
    stray = np.linalg.norm(two.zero_moment - one.zero_moment, axis=1)[one.carried]
    return float(np.linalg.norm(two.centre - one.centre, axis=1).max()), float(momentum), float(stray.max())


@mostly_long("name", STEPS, quick=[2])
def test_centre_of_mass_momentum_and_zero_moment_point_stay(name):
    for varied in variations(name):
        centre, momentum, stray = deviations(sketched_step(name), varied)
        assert centre < 1e-4
        assert momentum < 0.005
        assert stray < 0.005


@mostly_long("name", STEPS, quick=[3, 5])
def test_half_of_a_variation_stays_near(name):
    """As `[motion] mix` dances it: to first order the half keeps what the whole keeps."""
    for varied in variations(name):
        half = interpolate(sketched_step(name), varied, 0.5, hold_feet=False)  # the legs are those of both
        centre, momentum, stray = deviations(sketched_step(name), half)
        assert centre < 1e-3
        assert momentum < 0.02
        assert stray < 0.01


@mostly_long("name", ["walk", "jump", "arm_wave"], quick=[1])
def test_the_same_noise_without_correction_keeps_nothing_of_it(name, monkeypatch):
    monkeypatch.setattr(momentum_variation, "projected", lambda body, drawn, rate: drawn)
    step = sketched_step(name)
    for noise, varied in zip(vary_step(step, 3, 1), variations(name), strict=True):
        plain, corrected = deviations(step, noise), deviations(step, varied)
        assert plain[0] > 4e-3
        assert all(one > 10.0 * other for one, other in zip(plain, corrected, strict=True))


def test_recorded_step_keeps_them_too():
    """At another rate, with measure lines between samples and a lead-in that is no whole measure."""
    step = sketched_step("samba")
    clip = resample(step.clip, 50.0, first=30.3)
    scale = 50.0 / step.clip.sample_rate
    recorded = replace(
        step, clip=clip, first=(step.first - 30.3) * scale, samples_per_measure=step.samples_per_measure * scale,
        recorded=True,
    )  # fmt: skip
    for varied in vary_step(recorded, 3, 1):
        centre, momentum, stray = deviations(recorded, varied)
        assert centre < 3e-4
        assert momentum < 0.01
        assert stray < 0.01


@pytest.mark.long
def test_arc_of_flight_stays_ballistic():
    """A jump whose hips are moved so that the centre of mass falls freely while both feet are off the floor."""
    step = ballistic_jump()
    flight = ~step.clip.contact[measure_samples(step)[0] + 1 : measure_samples(step)[1]].any(axis=1)
    flight &= np.roll(flight, 3) & np.roll(flight, -3)
    assert flight.sum() > 10
    for varied in vary_step(step, 3, 1):
        assert np.abs(physics_of(varied).pushes[flight]).max() < 0.03 * GRAVITY
        assert np.abs(physics_of(varied).centre - physics_of(step).centre).max() < 1e-4


def ballistic_jump() -> StepClip:
    step = sketched_step("jump")
    first, last = measure_samples(step)
    free = np.flatnonzero(~step.clip.contact[first : last + 1].any(axis=1))
    begin, end = int(free[0]), int(free[-1])
    assert end - begin + 1 == len(free)
    centre = physics_of(step).centre
    part = np.arange(end - begin + 1) / step.clip.sample_rate
    share = (part / part[-1])[:, None]
    arc = centre[begin] * (1.0 - share) + centre[end] * share
    arc[:, 1] += 0.5 * GRAVITY * part * (part[-1] - part)
    root = step.clip.root_position.astype(np.float64)
    root[first + begin : first + end + 1] += arc - centre[begin : end + 1]
    return replace(step, clip=replace(step.clip, root_position=root.astype(np.float32)))


@pytest.mark.parametrize("name", STEPS)
def test_hips_legs_and_contacts_are_those_of_the_step(name):
    step = sketched_step(name)
    for number, varied in enumerate(variations(name), start=1):
        assert np.array_equal(varied.clip.root_position, step.clip.root_position)
        assert np.array_equal(varied.clip.rotation[:, LOWER], step.clip.rotation[:, LOWER])
        assert np.array_equal(varied.clip.contact, step.clip.contact)
        assert varied.variation == number
        same = [field.name for field in fields(StepClip) if field.name not in ("clip", "variation")]
        assert all(getattr(varied, name) == getattr(step, name) for name in same)


@pytest.mark.parametrize("name", STEPS)
def test_arms_are_seen_to_move_otherwise_and_smoothly(name):
    """Hands go otherwise by centimetres, and this changes less than half as fast as the hands themselves move."""
    seen = [hands_from_hips(each) for each in (sketched_step(name), *variations(name))]
    own = np.linalg.norm(seen[0][4:] - seen[0][:-4], axis=-1).max()
    for n, one in enumerate(seen):
        assert all(0.02 < np.linalg.norm(other - one, axis=-1).mean() < 0.25 for other in seen[:n])
        apart = one - seen[0]
        assert np.linalg.norm(apart[4:] - apart[:-4], axis=-1).max() < 0.5 * own


def hands_from_hips(step: StepClip):
    """Wrists in the axes of the hips, (T, 2, 3)."""
    position, world = joints(step)
    return quaternion.rotate(quaternion.inverse(world[:, :1]), position[:, HANDS] - position[:, :1])


@pytest.mark.parametrize("name", STEPS)
def test_joints_stay_within_their_limits(name):
    step = sketched_step(name)
    position, world = joints(step)
    hinge, _ = elbow_hinges(position, world)
    for varied in variations(name):
        moved, turned = joints(varied)
        other, bend = elbow_hinges(moved, turned)
        assert bend.max() < np.radians(155.0)
        assert ((hinge * other).sum(axis=-1) > -1e-3).all()  # no elbow bends to its other side
        head = SKELETON.index("head")
        looks = quaternion.mul(quaternion.inverse(world[:, head]), turned[:, head])
        assert np.linalg.norm(quaternion.to_rotation_vector(looks), axis=-1).max() < np.radians(18.0)
        assert self_contacts(moved).mean() <= self_contacts(position).mean() + 0.01


def elbow_hinges(position, world):
    """Hinge of the left and the right elbow in the axes of the forearm, as long as the sine of the bend, and the bend
    [rad]."""
    shoulder, elbow, wrist = (position[:, [arm[part] for arm in ARMS]] for part in range(3))
    upper, fore = quaternion.unit(elbow - shoulder), quaternion.unit(wrist - elbow)
    across = np.cross(upper, fore)
    bend = np.arctan2(np.linalg.norm(across, axis=-1), (upper * fore).sum(axis=-1))
    return quaternion.rotate(quaternion.inverse(world[:, [arm[1] for arm in ARMS]]), across), bend


def test_hands_that_meet_still_meet():
    path = next(ROOT.glob("patches/*/steps/stamp_and_clap.toml"))
    step = step_clip(parse_sketch(path.read_text(encoding="utf-8"), path.name))
    apart = palms_apart(step)
    clap = apart < 0.15
    assert clap.any()
    for varied in vary_step(step, 3, 1):
        assert np.abs(palms_apart(varied) - apart)[clap].max() < 0.02


def palms_apart(step: StepClip):
    position, world = joints(step)
    palms = position[:, HANDS] + quaternion.rotate(world[:, HANDS], np.array([(0.08, 0.0, 0.0), (-0.08, 0.0, 0.0)]))
    return np.linalg.norm(palms[:, 0] - palms[:, 1], axis=-1)


@pytest.mark.parametrize("name", STEPS)
def test_lines_join(name):
    """What differs from the step is the same at its end as at its beginning, and in its lead-in as at its end."""
    step = sketched_step(name)
    first, last = measure_samples(step)
    for varied in variations(name):
        turn = quaternion.mul(
            quaternion.inverse(step.clip.rotation[:, UPPER_BODY].astype(np.float64)),
            varied.clip.rotation[:, UPPER_BODY],
        )
        differ = quaternion.to_rotation_vector(turn)
        assert np.abs(differ[last] - differ[first]).max() < 0.01
        assert np.abs(differ[first - 20 : first] - differ[last - 20 : last]).max() < 0.01


def test_mirrored_steps_have_the_mirror_images():
    step = sketched_step("samba")
    found = vary_steps([step, mirror_step(step)], 2, 1)
    assert [(each.variation, each.mirrored) for each in found] == [(1, False), (2, False), (1, True), (2, True)]
    for own, other in zip(found[:2], found[2:], strict=True):
        assert np.array_equal(mirror_clip(own.clip).rotation, other.clip.rotation)
        assert other.leading_foot != own.leading_foot or not own.leading_foot
    alone = vary_steps([mirror_step(step)], 2, 1)
    assert all(np.array_equal(a.clip.rotation, b.clip.rotation) for a, b in zip(alone, found[2:], strict=True))
    assert len({each.clip.name for each in found}) == 4


@pytest.mark.long
def test_draws_depend_on_seed_step_and_number_alone():
    again = vary_step(sketched_step("walk"), 3, 1)
    assert all(np.array_equal(a.clip.rotation, b.clip.rotation) for a, b in zip(again, variations("walk"), strict=True))
    fewer = vary_step(sketched_step("walk"), 2, 1)
    assert all(np.abs(a.clip.rotation - b.clip.rotation).max() < 1e-6 for a, b in zip(fewer, again, strict=False))
    others = vary_step(sketched_step("walk"), 3, 2)
    assert all(np.abs(a.clip.rotation - b.clip.rotation).max() > 0.02 for a, b in zip(others, again, strict=True))


def test_measures_of_streams_have_none():
    assert vary_steps([replace(sketched_step("walk"), in_stream=True)], 3, 1) == []


@pytest.mark.long
def test_copies_of_a_recorded_step_on_other_paths_have_its_variations():
    """Shorter copies, whose upper bodies are those of the recording; not copies that turn, whose feet go elsewhere."""
    recorded = replace(sketched_step("walk", "long forward"), recorded=True)
    copies = path_variants(recorded)
    assert len(copies) > 2
    takes = find_takes(build_library([recorded, *copies, *vary_steps([recorded], 2, 1)]))
    nodes = np.arange(len(copies) + 1, dtype=np.int32)
    drawn = {take for chance in np.linspace(0.0, 0.999, 40) for take in takes.draw(nodes, np.full(len(nodes), chance))}
    assert {len(nodes), len(nodes) + 1} <= drawn
    have = [
        {len(nodes), len(nodes) + 1} <= set(takes.node[takes.start[node] : takes.start[node + 1]].tolist())
        for node in nodes
    ]
    assert have == [True, *("turned +0" in copy.clip.name for copy in copies)]
    assert 1 < sum(have) < len(nodes)


@pytest.mark.long
def test_every_variation_is_a_take_of_its_own_step():
    """Of no other direction, though they are takes of each other; and a variation has no takes itself."""
    own = [
        sketched_step(name, way)
        for name, way in (("walk", "in place"), ("walk", "short forward"), ("jump", "in place"))
    ]
    library = build_library(own + vary_steps(own, 3, 1))
    takes = find_takes(library)
    found = [takes.node[takes.start[u] : takes.start[u + 1]].tolist() for u in range(library.node_count)]
    assert found[:3] == [[1, 3, 4, 5], [0, 6, 7, 8], [9, 10, 11]]
    assert found[3:] == [[]] * 9
    drawn = takes.draw(np.repeat(np.arange(3, dtype=np.int32), 30), np.tile(np.linspace(0.0, 0.999, 30), 3))
    assert [sorted(set(row)) for row in drawn.reshape(3, 30).tolist()] == [[3, 4, 5], [6, 7, 8], [9, 10, 11]]
    assert all(re.search(r", variation [123]$", clip.clip.name) for clip in library.clips[3:])
