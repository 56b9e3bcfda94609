"""Tests of the motion quality bench on the project's sketches: every limit is met, and its measures detect faults."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench._step_metrics import StepMetrics
from live.cli.bench import load_bench
from live.motion.step_clip import StepClip
from tests.motion.editing.made_steps import sketched_step


@pytest.mark.long
def test_project_sketches_meet_every_limit(tmp_path: Path) -> None:
    rows = load_bench("motion-quality")(False, tmp_path)
    names = [row.name for row in rows]
    assert len(set(names)) == len(names)
    assert any(name.startswith("sketches") for name in names)
    assert [row.name for row in rows if row.ok is False] == []
    assert [row.name for row in rows if row.value is None] == []
    assert sum(row.ok is True for row in rows) >= 12


def test_pulled_body_has_foot_slide() -> None:
    step = sketched_step("walk")
    assert StepMetrics(step).mean_slide == pytest.approx(0.0, abs=1e-4)
    pulled = [pulled_metrics(step, speed) for speed in (0.3, 0.8)]
    assert [each.mean_slide for each in pulled] == pytest.approx([0.3, 0.8], abs=2e-3)
    assert pulled[0].skating < 0.7 < pulled[1].skating


def pulled_metrics(step: StepClip, speed: float) -> StepMetrics:
    """Metrics of the step moved at `speed` [m/s] in addition."""
    root = step.clip.root_position.copy()
    root[:, 0] += np.arange(len(root), dtype=np.float32) * np.float32(speed / step.clip.sample_rate)
    return StepMetrics(replace(step, clip=replace(step.clip, root_position=root)))


def test_jump_of_one_joint_is_measured() -> None:
    step = sketched_step("samba")
    rotation = step.clip.rotation.copy()
    at = round(step.first) + 30
    rotation[at, 7] = (math.cos(0.5), 0.0, 0.0, math.sin(0.5))
    jumped = StepMetrics(replace(step, clip=replace(step.clip, rotation=rotation)))
    assert jumped.velocity_jump > 5.0 * StepMetrics(step).velocity_jump
    assert jumped.accelerations.max() > 5.0 * StepMetrics(step).accelerations.max()


def test_bone_error_and_floor_depth_are_measured() -> None:
    step = sketched_step("samba")
    assert StepMetrics(step).bone_error < 1e-6
    longer = replace(step, clip=replace(step.clip, rotation=step.clip.rotation * np.float32(1.01)))
    assert StepMetrics(longer).bone_error > 1e-3
    sunk = replace(step.clip, root_position=step.clip.root_position - np.array((0.0, 0.03, 0.0), np.float32))
    assert StepMetrics(replace(step, clip=sunk)).below_floor == pytest.approx(0.03, abs=2e-3)
