"""Variations of a step that physics allows: another carriage of trunk, arms and head, with the same momentum (T142).

A variation adds smooth random angles to the joints of the upper body, periodic over the step, and corrected so that the
centre of mass and the angular momentum about it stay those of the step at every moment. Hips, legs and the place on
the floor are not touched. So the forces on the floor, the zero-moment point and arcs of flight remain those that the
step is danced with, which noise does not keep.
"""

import zlib
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.motion.editing.momentum_projection import MomentumProjection
from live.motion.editing.upper_body_angles import ANGLES, UPPER_BODY, UpperBodyAngles
from live.motion.mirror import mirror_step
from live.motion.quality.body_contact import self_contacts
from live.motion.step_clip import StepClip

CYCLES: Final = 1.0
"""Cycles a measure above which drawn angles fade out: a carriage of the body, and a sway or two in a measure."""
MAX_SPREADS: Final = 2.0
"""No angle is drawn larger than so many spreads."""
SHARES: Final = (1.0, 0.7, 0.45, 0.2)
"""Shares of the drawn angles that are tried, until the variation is good."""
MAX_STRAY_M: Final = 3e-4
"""A good variation's centre of mass strays no farther than this [m], ..."""
MAX_STRAY: Final = 0.01
"""... its angular momentum by no larger share of the step's range, ..."""
MAX_CONTACT: Final = 0.005
"""... and its forearms are inside the trunk in no larger share of the samples more than the step's."""
MIN_SAMPLES: Final = 16
"""Shorter steps have no variations."""


def vary_steps(steps: Sequence[StepClip], count: int, seed: int) -> list[StepClip]:
    """Return `count` variations of each step, in order; measures of streams, which have no takes, have none.

    Steps that are mirror images of others have the mirror images of their variations.
    """
    known: dict[tuple[str, str, bytes], list[StepClip]] = {}
    found: list[StepClip] = []
    for step in steps:
        if step.in_stream or _period(step)[1] < MIN_SAMPLES:
            continue
        original = mirror_step(step) if step.mirrored else step
        key = (step.step, original.clip.name, original.clip.rotation.tobytes())
        if key not in known:
            known[key] = vary_step(original, count, seed)
        for one in known[key]:
            clip = mirror_step(one).clip if step.mirrored else one.clip
            found.append(replace(step, clip=clip, variation=one.variation))
    return found


def vary_step(step: StepClip, count: int, seed: int) -> list[StepClip]:
    """Return `count` variations of a step, numbered from 1 (`StepClip.variation`), all else as in the step.

    The draws depend on `seed`, the name of the step and the number: all directions of a step vary alike.
    """
    first, period = _period(step)
    body = UpperBodyAngles.of(step.clip)
    drawn = np.stack([draw_angles(step.step, n, seed, step.measures, period) for n in range(1, count + 1)])
    angles = projected(body.part(first, first + period + 1), drawn, step.clip.sample_rate)
    place = (np.arange(step.clip.sample_count) - first) % period
    turned = body.local_turned(step.clip.rotation.astype(np.float64), angles[:, place])
    return [_with_upper_body(step, one, number) for number, one in enumerate(turned, start=1)]


def projected(body: UpperBodyAngles, drawn: Float64, rate: float) -> Float64:
    """Return the angles `drawn` (n, T, D) with the momentum of `body`, T + 1 poses, `rate` a second.

    They are made smaller where a body strays nevertheless, or where arms come into the trunk that were not.
    """
    projection = MomentumProjection.of(body, rate)
    inside = self_contacts(body.position).mean()
    angles, left = np.empty_like(drawn), np.arange(len(drawn))
    for share in SHARES:
        found, centre, momentum = projection.project(share * drawn[left])
        angles[left] = found
        touch = self_contacts(body.positions(np.concatenate([found, found[:, :1]], axis=1))).mean(axis=1)
        left = left[(centre > MAX_STRAY_M) | (momentum > MAX_STRAY) | (touch > inside + MAX_CONTACT)]
        if not len(left):
            break
    return angles


def _period(step: StepClip) -> tuple[int, int]:
    """Return the sample at which the step begins, and after how many its end is."""
    first = round(step.first)
    return first, min(round(step.measures * step.samples_per_measure), step.clip.sample_count - 1 - first)


def draw_angles(name: str, number: int, seed: int, measures: int, period: int) -> Float64:
    """Return random angles, in spreads, that repeat after a step of so many measures in `period` samples, (T, D)."""
    chance = np.random.default_rng((seed, zlib.crc32(name.casefold().encode()), number))
    cycles = np.arange(3 * measures + 1)
    weight = np.exp(-((cycles / (measures * CYCLES)) ** 2))
    weight *= np.sqrt(3.0 / (weight**2).sum())  # the spread is the root mean square
    drawn = chance.uniform(-1.0, 1.0, (2, len(cycles), ANGLES)) * weight[:, None]
    phase = 2.0 * np.pi / period * np.arange(period)[:, None] * cycles
    curve = np.cos(phase) @ drawn[0] + np.sin(phase) @ drawn[1]
    return np.asarray(MAX_SPREADS * np.tanh(curve / MAX_SPREADS))


def _with_upper_body(step: StepClip, rotation: Float64, number: int) -> StepClip:
    """Return the variation `number` of the step: the upper body with local `rotation` (T, J, 4)."""
    joints = step.clip.rotation.copy()
    joints[:, UPPER_BODY] = rotation[:, UPPER_BODY]
    clip = replace(step.clip, name=f"{step.clip.name}, variation {number}", rotation=joints)
    return replace(step, clip=clip, variation=number)
