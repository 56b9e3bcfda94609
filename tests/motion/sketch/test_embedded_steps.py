"""Tests of the project's own steps: each is read, has all variations and respects the body's limits."""

from pathlib import Path

import numpy as np
import pytest

from live.motion.quality.metrics import skating_frames
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clips
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import DIRECTIONS, StepClip
from tests.motion.sketch.sketch_measure import SIDES, first_and_last, joints, slide, soles
from tests.places import ROOT

FILES = sorted((ROOT / "patches" / "steps").glob("*.toml"))
TRAVELLING = ("walk", "kick", "reach", "samba", "side_step")
"""Steps with nine directions take most of the time."""
NEEDED = {"groove", "side step", "samba", "tap", "turn", "jump", "arm wave", "bow", "walk"}


def read_steps(path: Path) -> list[StepClip]:
    return step_clips(parse_sketch(path.read_text(encoding="utf-8"), str(path)))


@pytest.fixture(scope="module")
def original_steps(steps: list[StepClip]) -> list[StepClip]:
    """The sketched variations; the others are their exact mirror images."""
    return [step for step in steps if not step.mirrored]


@pytest.fixture(
    scope="module",
    params=[pytest.param(path, marks=[pytest.mark.long] * (path.stem in TRAVELLING[1:])) for path in FILES],
    ids=[path.stem for path in FILES],
)
def path(request: pytest.FixtureRequest) -> Path:
    found: Path = request.param
    return found


@pytest.fixture(scope="module")
def steps(path: Path) -> list[StepClip]:
    return read_steps(path)


def test_all_required_steps_exist() -> None:
    names = [parse_sketch(path.read_text(encoding="utf-8"), path.name).name for path in FILES]
    assert set(names) >= NEEDED
    assert len(set(names)) == len(names) >= 10
    assert [path.stem.replace("_", " ") for path in FILES] == names


def test_each_step_has_all_directions(steps: list[StepClip]) -> None:
    directions = [step.direction for step in steps]
    assert directions in ([*DIRECTIONS, *DIRECTIONS], [DIRECTIONS[0]] * 2)


def test_planted_feet_do_not_slide_or_sink(original_steps: list[StepClip]) -> None:
    for step in original_steps:
        assert slide(step) < 0.001, step.clip.name
        for side in SIDES:
            assert min(point[:, 1].min() for point in soles(step, side)) > -0.01, step.clip.name


def test_swinging_feet_clear_floor(original_steps: list[StepClip]) -> None:
    """A ball lower than 5 cm is near its last or next stance, except in steps that brush the floor on purpose."""
    low, near = 0.05, 0.03
    for step in original_steps:
        if step.step in {"tap", "turn"}:
            continue
        for index, side in enumerate(SIDES):
            ball, contact = soles(step, side)[1], step.clip.contact[:, index]
            stands = np.flatnonzero(contact)
            at = np.arange(len(ball))
            after = stands[np.minimum(np.searchsorted(stands, at), len(stands) - 1)]
            before = stands[np.maximum(np.searchsorted(stands, at, side="right") - 1, 0)]
            away = [np.hypot(*(ball[near_by] - ball)[:, (0, 2)].T) for near_by in (before, after)]
            skims = ~contact & (ball[:, 1] < low) & (at > stands[0]) & (at < stands[-1])
            assert np.minimum(*away)[skims].max(initial=0.0) < near, (step.clip.name, side)


@pytest.mark.parametrize("bpm", [70.0, 112.0, 130.0])
def test_steps_do_not_skate(original_steps: list[StepClip], bpm: float) -> None:
    for step in original_steps:
        if step.step in {"tap", "turn"}:
            continue
        rate = step.clip.sample_rate * bpm / step.bpm
        # one frame of a measure at the fastest: samba has a fifth of a beat for 40 cm; all others skate in none
        assert skating_frames(joints(step)[0], rate).mean() <= (0.015 if step.step == "samba" else 0.0), step.clip.name


def test_joints_do_not_flip_between_samples(original_steps: list[StepClip]) -> None:
    """A bone that spins at 25 rad/s or more shows nothing at the samples, but pops between them."""
    for step in original_steps:
        rotation = step.clip.rotation.astype(np.float64)
        cosine = np.clip(np.abs((rotation[1:] * rotation[:-1]).sum(axis=-1)), 0.0, 1.0)
        fastest = (2.0 * np.arccos(cosine) * step.clip.sample_rate).max(axis=0)
        assert fastest.max() < 25.0, (step.clip.name, SKELETON.names[int(fastest.argmax())])


def test_step_ends_in_its_beginning_pose(path: Path, original_steps: list[StepClip]) -> None:
    cyclic = "cyclic = false" not in path.read_text(encoding="utf-8")
    for step in original_steps:
        first, last = first_and_last(step)
        position, _ = joints(step)
        velocity = np.diff(position, axis=0) * step.clip.sample_rate
        moved = (position[last, 0] - position[first, 0]) * (1.0, 0.0, 1.0)
        assert np.allclose(position[last] - moved, position[first], atol=1e-4 if cyclic else 0.012), step.clip.name
        assert np.allclose(velocity[last], velocity[first], atol=5e-3 if cyclic else 0.4), step.clip.name


def test_body_speeds_and_joint_bends_are_plausible(original_steps: list[StepClip]) -> None:
    for step in original_steps:
        position, _ = joints(step)
        velocity = np.diff(position, axis=0) * step.clip.sample_rate
        acceleration = np.diff(velocity, axis=0) * step.clip.sample_rate
        assert np.linalg.norm(velocity, axis=2).max() < 7.0, step.clip.name
        assert np.linalg.norm(acceleration, axis=2).max() < 150.0, step.clip.name
        for side in SIDES:
            for upper, middle, lower in (("UpperLeg", "LowerLeg", "Foot"), ("UpperArm", "LowerArm", "Hand")):
                a, b, c = (position[:, SKELETON.index(side + name)] for name in (upper, middle, lower))
                bend = np.sum((b - a) * (c - b), axis=1)
                bend /= np.linalg.norm(b - a, axis=1) * np.linalg.norm(c - b, axis=1)
                assert bend.max() < 0.9999, f"{step.clip.name}: {side}{middle} is straight as a rod"


def test_legs_do_not_intersect(original_steps: list[StepClip]) -> None:
    for step in original_steps:
        position, _ = joints(step)
        for name in ("LowerLeg", "Foot"):
            left, right = (position[:, SKELETON.index(side + name)] for side in SIDES)
            assert np.linalg.norm(left - right, axis=1).min() > 0.12, step.clip.name


@pytest.mark.long
def test_hip_heights_at_measure_lines_are_similar() -> None:
    hips = []
    for path in FILES:
        step = read_steps(path)[0]
        position, _ = joints(step)
        hips.append(position[round(step.first), 0, 1])
    assert np.ptp(hips) < 0.12


@pytest.mark.long
def test_readme_example_is_valid_step() -> None:
    text = (FILES[0].parent / "README.md").read_text(encoding="utf-8")
    example = text.split("```toml\n")[1].split("```")[0]
    steps = step_clips(parse_sketch(example, "README.md"))
    assert len(steps) == 2 * len(DIRECTIONS)
    assert len([line for line in example.splitlines() if line.strip()]) <= 20
