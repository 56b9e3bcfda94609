"""Sketched walks: examples for who walks along a way, made of a step that goes forward (H017, H019).

A sketched walk goes straight, at a few speeds. Between these, and round bends, it is led here: strides are mixed, ways
are bent, and feet that stand are held where they stand. Ours; the paper has two minutes of a recorded walk.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.clip import Clip
from live.motion.partner.cloud import ends_cloud, path_cloud
from live.motion.partner.enforce import enforce_feet
from live.motion.partner.sketched import PASSES, danced_again
from live.motion.partner.units import Example, Units, cut_units
from live.motion.step_clip import StepClip

Float64 = npt.NDArray[np.float64]

BENDS: Final = (0.0, 0.5, -0.5, 1.0, -1.0)
"""By so much [rad] ways turn in a measure, towards +x."""
STRIDES: Final = 2
"""So many strides are mixed between two that are sketched, the slower one among them."""
LONGER: Final = 1.7
"""The longest stride is so far beyond the one before, where 1 is the longest sketched one."""
SIDEWAYS: Final = 0.1
"""Who goes this far [m] to a side in a measure, or backward, does not walk forward."""


def sketched_walks(clips: Sequence[StepClip], *, unit_beats: int) -> Units:
    """Units of walking forward: of those `clips` that do; ValueError if none does."""
    ahead: dict[str, list[tuple[float, StepClip, Clip]]] = {}
    for step in clips:
        clip = danced_again(step, back=False)
        way = clip.root_position[round(step.measures * step.samples_per_measure)].astype(np.float64)
        if abs(way[0]) < SIDEWAYS * step.measures and way[2] > -SIDEWAYS * step.measures and not step.mirrored:
            ahead.setdefault(step.step, []).append((float(way[2]) / step.measures, step, clip))
    found = [one for name in sorted(ahead) for one in _of_step(name, ahead[name], unit_beats)]
    if not found:
        raise ValueError("no step goes forward")
    return cut_units(found)


def _of_step(name: str, known: list[tuple[float, StepClip, Clip]], unit_beats: int) -> list[Example]:
    """Examples of one step, whose strides are `known` with their lengths [m] a measure."""
    if max(way for way, _, _ in known) < SIDEWAYS:
        return []
    known = sorted(known, key=lambda one: one[0])
    beat = known[0][1].samples_per_measure / known[0][1].beats_per_measure
    cuts = np.asarray(np.arange(PASSES * known[0][1].beats // unit_beats) * beat * unit_beats, np.float64)
    strides = [known[-1][2]]
    for (_, _, one), (_, _, other) in pairwise(known):
        if one.sample_count == other.sample_count:
            strides += [_mixed(one, other, n / STRIDES) for n in range(STRIDES)]
    if len(known) > 1 and known[-2][2].sample_count == known[-1][2].sample_count:
        strides.append(_mixed(known[-2][2], known[-1][2], LONGER))
    bent = [_bent(clip, bend / (beat * known[0][1].beats_per_measure)) for clip in strides for bend in BENDS]
    return [Example(name, path_cloud(clip), ends_cloud(clip), clip, cuts, np.zeros(0)) for clip in bent]


def _mixed(one: Clip, other: Clip, share: float) -> Clip:
    root = (1.0 - share) * one.root_position + share * other.root_position
    rotation = quaternion.slerp(one.rotation, other.rotation, np.full(one.rotation.shape[:2], share))
    return Clip(
        one.name, np.ascontiguousarray(root, np.float32), np.ascontiguousarray(rotation, np.float32), one.sample_rate,
        one.contact & other.contact,
    )  # fmt: skip


def _bent(clip: Clip, turn: float) -> Clip:
    """The clip on a way that turns by `turn` [rad] in every sample; feet that stand are held."""
    if turn == 0.0:
        return clip
    yaw = turn * np.arange(clip.sample_count)
    root = clip.root_position.astype(np.float64)
    steps = np.diff(root[:, 2] + 1j * root[:, 0]) * np.exp(0.5j * (yaw[1:] + yaw[:-1]))
    place = np.concatenate(([0.0], np.cumsum(steps)))
    rotation = clip.rotation.astype(np.float64)
    zero = np.zeros_like(yaw)
    about = np.stack((np.cos(0.5 * yaw), zero, np.sin(0.5 * yaw), zero), axis=-1)
    rotation[:, 0] = quaternion.mul(about, rotation[:, 0])
    bent = Clip(
        clip.name, np.ascontiguousarray(np.stack((place.imag, root[:, 1], place.real), axis=1), np.float32),
        np.ascontiguousarray(rotation, np.float32), clip.sample_rate, clip.contact,
    )  # fmt: skip
    return enforce_feet(bent)
