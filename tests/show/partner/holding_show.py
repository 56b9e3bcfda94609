"""A small show in which a leader's and a follower's hands are near enough to be held: both hold them to the front."""

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
from live.show.partner.partner_sources import ExampleBank, load_example_bank
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch
from live.show.show import Show
from tests.fixtures.made_steps import made_steps
from tests.show.made_show import PATCH

HELD = """
[motion]
warp_beats = 0.0
[[partner]]
name = "duet"
leader = "front & 1"
follower = "back & 6"
hold_distance = 0.4
"""


def arms_in_front(step: StepClip) -> StepClip:
    """The same step with arms to the front, elbows bent, each of the two waving in its own time."""
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
def graph_of() -> MotionGraph:
    """The made steps, arms in front."""
    return build_graph(build_library([arms_in_front(step) for step in made_steps()]), threshold=0.2)


@cache
def held_patch(extra: str = HELD) -> Patch:
    """PATCH with more at its end."""
    return parse_patch(PATCH + extra, "test.toml")


@cache
def held_bank(extra: str = HELD, apart: float = 0.75) -> ExampleBank | None:
    """What its partners answer from, followers `apart` [m] from their leaders."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(sketched_examples, "PARTNER_DISTANCE", apart)
        return load_example_bank(held_patch(extra), Path("test.toml"), graph_of().library)


def holding_show(extra: str = HELD, *, apart: float = 0.75) -> Show:
    """A fresh show in which hands are held."""
    return Show(held_patch(extra), graph_of(), seed=3, answers=held_bank(extra, apart))


def palms(position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
    """Middles of the left and the right palm [m] of poses (..., J, 3) and (..., J, 4), (..., 2, 3)."""
    hands = ARM_JOINTS[[2, 5]]
    tip = np.array(((float(PALM), 0.0, 0.0), (-float(PALM), 0.0, 0.0)))
    return np.asarray(position[..., hands, :] + quaternion.rotate(rotation[..., hands, :].astype(np.float64), tip))
