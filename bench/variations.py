"""Made variations of steps: how far they keep balance and momentum, beside the same angles uncorrected, and their cost.

Three variations of every shipped sketch (in its first direction), and of measures of recordings where there are any.
"""

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Final
from unittest.mock import patch

import numpy as np
import numpy.typing as npt

from bench._motion_clips import SALSA, SOLO, recordings
from live.cli.bench import Row
from live.motion import quaternion
from live.motion.editing import momentum_variation
from live.motion.editing.body_mass import angular_momentum, centre_of_mass, rotation_row
from live.motion.editing.interpolate import interpolate
from live.motion.editing.momentum_variation import vary_step
from live.motion.forward_kinematics import forward_kinematics
from live.motion.quality.body_contact import self_contacts
from live.motion.skeleton import SKELETON
from live.motion.sketch.sketch_clips import step_clip
from live.motion.sketch.sketch_file import parse_sketch
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

PATCHES: Final = Path(__file__).resolve().parent.parent / "patches"
COUNT: Final = 3
GRAVITY: Final = 9.81
FIGURES: Final = (
    ("centre of mass", "mm", 1.0), ("angular momentum, of its range", "%", 3.0), ("zero-moment point", "cm", 1.0)
)  # fmt: skip
"""Name, unit and limit of each largest deviation; that of the zero-moment point under half the weight or more."""
_HANDS: Final = [SKELETON.index("leftHand"), SKELETON.index("rightHand")]


def run(full: bool, shared: Path | None) -> list[Row]:
    """With `full` on more recordings."""
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    recorded = recordings(folder, (*SALSA, *SOLO) if full else (*SALSA[:2], SOLO[-1]))
    rows = _rows("sketches", _sketches())
    steps = [step for material in recorded for step in material.steps if step.first >= 1.0]
    return rows + _rows("recordings", steps if full else steps[:24])


def _sketches() -> list[StepClip]:
    files = sorted(PATCHES.glob("**/steps/*.toml"))
    sketches = [parse_sketch(file.read_text(encoding="utf-8"), file.name) for file in files]
    return [step_clip(sketch, sketch.directions[0] if sketch.travels else "in place") for sketch in sketches]


def _rows(name: str, steps: Sequence[StepClip]) -> list[Row]:
    if not steps:
        return [Row(f"{name}: none here", None, "")]
    vary_step(steps[0], COUNT, 1)
    begin = time.process_time()
    varied = [vary_step(step, COUNT, 1) for step in steps]
    cost = 1000.0 * (time.process_time() - begin) / sum(step.measures for step in steps)
    with patch.object(momentum_variation, "projected", lambda body, drawn, rate: drawn):
        noise = [vary_step(step, COUNT, 1) for step in steps]
    whole, plain = (_deviations(steps, each) for each in (varied, noise))
    half = _deviations(
        steps, [[interpolate(s, v, 0.5, hold_feet=False) for v in vs] for s, vs in zip(steps, varied, strict=True)]
    )
    rows = []
    for n, (figure, unit, limit) in enumerate(FIGURES):
        for word, of in (("median step", np.median), ("worst step", np.max)):
            peers = {"uncorrected": float(of(plain[:, n])), "half mixed in": float(of(half[:, n]))}
            rows.append(Row(f"{name}: {figure}, {word}", float(of(whole[:, n])), unit, limit, peers=peers))
    inside = float(max(_inside(v) - _inside(s) for s, vs in zip(steps, varied, strict=True) for v in vs))
    apart = [_hands_apart(s, v) for s, vs in zip(steps, varied, strict=True) for v in vs]
    return [
        *rows,
        Row(f"{name}: hands go otherwise by, mean", float(np.mean(apart)), "cm", 1.5, "at least"),
        Row(f"{name}: more forearms inside the trunk, worst step", inside, "", 0.1),
        Row(f"{name}: CPU for {COUNT} variations of a measure", cost, "ms", 60.0),
    ]


def _deviations(steps: Sequence[StepClip], varied: Sequence[Sequence[StepClip]]) -> Float64:
    """Return the largest deviations of each step's variations in the units of FIGURES, (steps, 3)."""
    found = []
    for step, others in zip(steps, varied, strict=True):
        centre, momentum, point, carried = _physics(step)
        reach = np.ptp(momentum, axis=0).max()
        rows = []
        for other in others:
            its = _physics(other)
            apart = np.linalg.norm(its[0] - centre, axis=1).max(), np.abs(its[1] - momentum).max() / reach
            rows.append((*apart, np.linalg.norm(its[2] - point, axis=1)[carried].max(initial=0.0)))
        found.append(np.max(rows, axis=0) * (1000.0, 100.0, 100.0))
    return np.array(found)


def _physics(step: StepClip) -> tuple[Float64, Float64, Float64, npt.NDArray[np.bool_]]:
    """Return centre of mass, angular momentum and zero-moment point of a step's measures, and when it counts."""
    root, world = _poses(step)
    row, rate = rotation_row(quaternion.to_matrix(world)), step.clip.sample_rate
    centre, momentum = centre_of_mass(root, row), angular_momentum(row, rate)
    push = np.diff(centre, 2, axis=0) * rate**2 + (0.0, GRAVITY, 0.0)
    torque = np.diff(momentum, axis=0) * rate
    up = np.maximum(push[:, 1], 0.1 * GRAVITY)
    middle = centre[1:-1]
    x = middle[:, 0] - (middle[:, 1] * push[:, 0] - torque[:, 2]) / up
    z = middle[:, 2] - (middle[:, 1] * push[:, 2] + torque[:, 0]) / up
    return centre, momentum, np.stack([x, z], axis=1), push[:, 1] > 0.5 * GRAVITY


def _poses(step: StepClip) -> tuple[Float64, Float64]:
    part = slice(round(step.first), round(step.first + step.measures * step.samples_per_measure) + 1)
    root = step.clip.root_position[part].astype(np.float64)
    return root, np.asarray(forward_kinematics(root, step.clip.rotation[part].astype(np.float64))[1])


def _positions(step: StepClip) -> Float64:
    return np.asarray(forward_kinematics(step.clip.root_position, step.clip.rotation)[0], np.float64)


def _inside(step: StepClip) -> float:
    return float(self_contacts(_positions(step)).mean())


def _hands_apart(step: StepClip, other: StepClip) -> float:
    apart = _positions(other)[:, _HANDS] - _positions(step)[:, _HANDS]
    return 100.0 * float(np.linalg.norm(apart, axis=-1).mean())
