"""A small show in which leader and follower hold their arms in front, within reach of each other's hands."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from live.graph.motion_graph import MotionGraph, build_graph
from live.graph.step_library import build_library
from live.motion import quaternion
from live.motion.partner import sketched_examples
from live.motion.pose.hand_hold import ARM_JOINTS
from live.motion.pose.hand_hold_kernels import PALM
from live.motion.skeleton import SKELETON
from live.motion.step_clip import StepClip
from live.show.assembly import assemble
from live.show.partner.example_bank import ExampleBank
from live.show.partner.partner_sources import load_example_bank
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch
from live.show.show import Show
from tests.fixtures.made_steps import made_steps
from tests.show.made_show import PATCH

HELD = """
[motion]
warp_beats = 0.0
arm_clearance = 0.0
[[partner]]
name = "duet"
leader = "front & 1"
follower = "back & 6"
hold_distance = 0.4
"""


def with_arms_in_front(step: StepClip) -> StepClip:
    """The same step with arms in front and elbows bent; each arm waves in its own time."""
    clip = step.clip
    rotation, beats = clip.rotation.astype(np.float64), np.arange(clip.sample_count) / 8.0
    for side, sign in (("left", -1.0), ("right", 1.0)):
        wave = 0.15 * np.sin(np.pi * (beats + (0.5 if side == "left" else 0.0)))
        upper, lower = SKELETON.index(f"{side}UpperArm"), SKELETON.index(f"{side}LowerArm")
        forward = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), sign * (1.1 + wave))
        down = quaternion.from_axis_angle(np.array((0.0, 0.0, 1.0)), np.full(len(beats), sign * 0.6))
        rotation[:, upper] = quaternion.mul(forward, down)
        rotation[:, lower] = quaternion.from_axis_angle(np.array((0.0, 1.0, 0.0)), sign * (0.3 + wave))
    return replace(step, clip=replace(clip, rotation=np.ascontiguousarray(rotation, np.float32)))


@cache
def holding_graph() -> MotionGraph:
    """A graph of the generated steps with arms in front."""
    return build_graph(build_library([with_arms_in_front(step) for step in made_steps()]), threshold=0.2)


@cache
def holding_patch(extra: str = HELD) -> Patch:
    """PATCH with `extra` appended."""
    return parse_patch(PATCH + extra, "test.toml")


@cache
def holding_bank(extra: str = HELD, apart: float = 0.75) -> ExampleBank | None:
    """The example bank of its partners, followers `apart` [m] from their leaders."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sketched_examples, "PARTNER_DISTANCE", apart)
        return load_example_bank(holding_patch(extra), Path("test.toml"), holding_graph().library)


def holding_show(extra: str = HELD, *, apart: float = 0.75) -> Show:
    """A new show in which partners hold hands."""
    return assemble(holding_patch(extra), holding_graph(), seed=3, answers=holding_bank(extra, apart))


def palm_positions(position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Centers of the left and the right palm [m] of poses (..., J, 3) and (..., J, 4), (..., 2, 3)."""
    hands = ARM_JOINTS[[2, 5]]
    tip = np.array(((float(PALM), 0.0, 0.0), (-float(PALM), 0.0, 0.0)))
    return np.asarray(position[..., hands, :] + quaternion.rotate(rotation[..., hands, :].astype(np.float64), tip))
