"""Forms of a recorded step for other tempi: as recorded, at half time, at double time (T039, T055).

A recorded dance looks like itself only near its own tempo. Farther away it is danced at half time, so that one of its
beats takes two beats of the music, or at double time. The limits below are an octave, so for any tempo within two
octaves of the recorded one there is a form. Sketched steps have no tempo of their own and no limits.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.motion import quaternion
from live.motion.clip import Clip, read_clip
from live.motion.editing.facing import heading_of
from live.motion.forward_kinematics import forward_kinematics
from live.motion.mirror import MIRRORED_SUFFIX, mirror_step, unmirrored_name
from live.motion.step_clip import StepClip, measured_direction, measured_distance, moved_shapes

TEMPO_LIMITS: Final = (0.7, 1.4)
"""Least and most tempo of the music, as shares of that of a form."""
HALF_TIME: Final = "half time"
DOUBLE_TIME: Final = "double time"
FORM_FACTORS: Final = (1.0, 2.0, 0.5)
"""Tempo of a step as recorded, at half time and at double time, as a share of the recorded one."""
MAX_REPEAT_DISTANCE: Final = 0.2
"""A step is danced twice only if its joints are this near [m], on average, at its end and its beginning. Poses
of a dance are 0.1 to 0.3 m from that a measure before."""
BLEND_BEATS: Final = 1.0
"""Recorded beats over which the end of a step is blended into its repetition."""
TAIL_SAMPLES: Final = 8
_Y: Final = np.array((0.0, 1.0, 0.0))


class NoTempoForm(ValueError):
    """A step cannot be danced at double time; the message says why."""


def recorded_name(name: str) -> str:
    """Return the name of the clip of which this may be a form; that of a mirror image stays one."""
    plain = unmirrored_name(name)
    return plain.removesuffix(f", at {HALF_TIME}").removesuffix(f", at {DOUBLE_TIME}") + name[len(plain) :]


def _form_name(name: str, form: str) -> str:
    plain = unmirrored_name(name)
    return f"{plain}, at {form}{MIRRORED_SUFFIX if plain != name else ''}"


def half_time(step: StepClip) -> StepClip:
    """Return the step with two beats of the music for each of its own: it takes twice as many measures."""
    clip = replace(step.clip, name=_form_name(step.clip.name, HALF_TIME))
    return _measured(
        replace(
            step, clip=clip, measures=2 * step.measures, samples_per_measure=0.5 * step.samples_per_measure,
            bpm=2.0 * step.bpm, tempo_form=HALF_TIME, hands=moved_shapes(step.hands, scale=2.0),
        )
    )  # fmt: skip


def double_time(step: StepClip) -> StepClip:
    """Return the step with two of its beats for each beat of the music.

    It takes half as many measures. A step with an odd number of measures is danced twice, the second time mirrored if
    its weight ends on the other foot. NoTempoForm if its end does not lead to its beginning.
    """
    whole = step if step.measures % 2 == 0 else danced_twice(step)
    clip = replace(whole.clip, name=_form_name(step.clip.name, DOUBLE_TIME))
    return _measured(
        replace(
            whole, clip=clip, measures=whole.measures // 2, samples_per_measure=2.0 * whole.samples_per_measure,
            bpm=0.5 * step.bpm, tempo_form=DOUBLE_TIME, hands=moved_shapes(whole.hands, scale=0.5),
        )
    )  # fmt: skip


def _measured(step: StepClip) -> StepClip:
    return replace(step, direction=measured_direction(step), distance_m=measured_distance(step))


def danced_twice(step: StepClip) -> StepClip:
    """Return the step followed by itself, blended over its last beat; NoTempoForm if that is impossible."""
    again = mirror_step(step) if step.weight_transfer else step
    if step.end_pose.casefold() != again.begin_pose.casefold() and step.end_pose and again.begin_pose:
        raise NoTempoForm(f"it ends in {step.end_pose!r} and begins in {again.begin_pose!r}")
    length = step.measures * step.samples_per_measure
    end = step.first + length
    blend = min(BLEND_BEATS * step.samples_per_measure / step.beats_per_measure, step.first)
    own = np.arange(math.floor(end) + 1)
    later = np.arange(math.ceil(end - blend), math.ceil(end + length) + TAIL_SAMPLES + 1)
    root, rotation, contact = read_clip(again.clip, later - length)
    last, start = (read_clip(one.clip, np.array([at]))[:2] for one, at in ((step, end), (again, step.first)))
    turn = quaternion.from_axis_angle(_Y, heading_of(last[1][0, 0]) - heading_of(start[1][0, 0]))
    place = (last[0][0] - quaternion.rotate(turn, start[0][0])) * (1.0, 0.0, 1.0)
    apart = _joint_distance(last, _moved(*start, turn, place))
    if apart > MAX_REPEAT_DISTANCE:
        raise NoTempoForm(f"its end is {100.0 * apart:.0f} cm from its beginning")
    root, rotation = _moved(root, rotation, turn, place)
    shared = own[-1] + 1 - later[0]
    weight = np.clip((later[:shared] - (end - blend)) / max(blend, 1e-9), 0.0, 1.0)
    weight = weight**2 * (3.0 - 2.0 * weight)
    before = read_clip(step.clip, later[:shared].astype(np.float64))
    root[:shared] = before[0] * (1.0 - weight)[:, None] + root[:shared] * weight[:, None]
    rotation[:shared] = quaternion.slerp(before[1], rotation[:shared], weight[:, None])
    contact[:shared] = np.where(weight[:, None] < 0.5, before[2], contact[:shared])
    kept = slice(0, int(later[0]))
    clip = Clip(
        step.clip.name,
        np.concatenate([step.clip.root_position[kept], root.astype(np.float32)]),
        np.concatenate([step.clip.rotation[kept], rotation.astype(np.float32)]),
        step.clip.sample_rate,
        np.concatenate([step.clip.contact[kept], contact]),
    )
    return replace(
        step, clip=clip, measures=2 * step.measures, end_pose=again.end_pose, weight_transfer=False,
        hands=step.hands + moved_shapes(again.hands, by=float(step.beats)),
    )  # fmt: skip


def _moved(root: Float, rotation: Float, turn: Float, place: Float) -> tuple[Float, Float]:
    rotation = np.array(rotation, np.float64)
    rotation[:, 0] = quaternion.mul(turn, rotation[:, 0])
    return quaternion.rotate(turn, root) + place, rotation


def _joint_distance(one: tuple[Float, Float], other: tuple[Float, Float]) -> float:
    """Mean distance [m] of the joints of two poses of one sample each."""
    places = [forward_kinematics(*pose)[0][0] for pose in (one, other)]
    return float(np.linalg.norm(places[0] - places[1], axis=-1).mean())


def joined_stream(steps: Sequence[StepClip]) -> list[StepClip]:
    """Return clips with the measures of streams (T037) in pairs: two consecutive ones are one clip of two measures.

    The lead-in of a measure is the measure before it, so the pair is the recording without a seam. A measure without a
    pair stays as it is.
    """
    pairs: list[StepClip] = []
    waiting: dict[tuple[str, bool], StepClip] = {}
    for step in steps:
        if not step.in_stream or step.measures != 1:
            pairs.append(step)
            continue
        key = (step.step, step.mirrored)
        before = waiting.pop(key, None)
        joined = None if before is None else _joined(before, step)
        if joined is not None:
            pairs.append(joined)
            continue
        if before is not None:
            pairs.append(before)
        waiting[key] = step
    return [*pairs, *waiting.values()]


def _joined(one: StepClip, other: StepClip) -> StepClip | None:
    """Return two consecutive measures of a stream as one clip; None if they are not consecutive."""
    lead = round(one.first + one.samples_per_measure - other.first)
    shared = one.clip.sample_count - lead
    if (
        one.samples_per_measure != other.samples_per_measure
        or not 0 < lead < one.clip.sample_count
        or shared > other.clip.sample_count
        or not np.allclose(one.clip.rotation[lead:, 1:], other.clip.rotation[:shared, 1:], atol=1e-5)
    ):
        return None
    turn = quaternion.mul(
        other.clip.rotation[0, 0].astype(np.float64), quaternion.inverse(one.clip.rotation[lead, 0].astype(np.float64))
    )
    place = other.clip.root_position[0] - quaternion.rotate(turn, one.clip.root_position[lead].astype(np.float64))
    root, rotation = _moved(
        one.clip.root_position[:lead].astype(np.float64), one.clip.rotation[:lead], turn, place * (1.0, 0.0, 1.0)
    )
    clip = Clip(
        one.clip.name,
        np.concatenate([root.astype(np.float32), other.clip.root_position]),
        np.concatenate([rotation.astype(np.float32), other.clip.rotation]),
        one.clip.sample_rate,
        np.concatenate([one.clip.contact[:lead], other.clip.contact]),
    )
    return replace(one, clip=clip, measures=2)


@dataclass(frozen=True, slots=True, eq=False)
class TempoForms:
    """The clips of a show in the forms that fit its tempo."""

    clips: list[StepClip]
    refused: Mapping[str, str]
    """By step, why none of its clips can be danced at the show's tempo."""
    notes: tuple[str, ...]
    """A line for each step that is danced at half or double time, and for each clip that is left out."""


def tempo_forms(clips: Sequence[StepClip], span: tuple[float, float]) -> TempoForms:
    """Return clips in the forms that fit a show whose tempo is within `span` [bpm].

    Recorded clips without such a form are left out, and said. Sketched ones stay as they are.
    """
    found: list[StepClip] = []
    reasons: dict[str, str] = {}
    told: dict[str, str] = {}
    left_out: dict[str, str] = {}
    doubled: list[StepClip] = []
    for clip in clips:
        factors = [factor for factor in FORM_FACTORS if fits(clip, factor, span)]
        if len(factors) > 1 and span[1] < span[0] * 1.001:  # exactly on a limit: one form will do
            factors = factors[:1]
        if not factors:
            left_out[clip.clip.name] = reasons[clip.step] = misfit_reason(clip, span)
            continue
        if 1.0 in factors:
            found.append(clip)
        if 2.0 in factors:
            found.append(half_time(clip))
            told.setdefault(clip.step, _form_note(clip, "half", span))
        if 0.5 in factors:
            doubled.append(clip)
    for clip in joined_stream(doubled):
        try:
            found.append(double_time(clip))
            told.setdefault(clip.step, _form_note(clip, "double", span))
        except NoTempoForm as error:
            if not fits(clip, 1.0, span):
                words = f"{misfit_reason(clip, span, slowest=1.0)}; at double time it cannot be danced, because {error}"
                left_out[clip.clip.name] = reasons[clip.step] = words
    danced = {clip.step for clip in found}
    refused = {step: why for step, why in reasons.items() if step not in danced}
    others = [f"left out: {words}" for words in dict.fromkeys(left_out.values())]
    return TempoForms(found, refused, (*told.values(), *others))


def all_forms(clips: Sequence[StepClip]) -> Iterator[StepClip]:
    """Yield clips and all forms of them, for those who know which ones were danced (a replay)."""
    yield from clips
    recorded = [clip for clip in clips if clip.recorded]
    yield from map(half_time, recorded)
    for clip in joined_stream(recorded):
        try:
            yield double_time(clip)
        except NoTempoForm:
            continue


def fits(clip: StepClip, factor: float, span: tuple[float, float]) -> bool:
    """Whether a form of a clip, at `factor` times its tempo, can be danced somewhere within `span` [bpm]."""
    if not clip.recorded:
        return factor == 1.0
    low, high = (limit * factor * clip.bpm for limit in TEMPO_LIMITS)
    return span[0] <= high * (1.0 + 1e-9) and span[1] >= low * (1.0 - 1e-9)


def span_text(span: tuple[float, float]) -> str:
    """Return a tempo span for a message."""
    return f"{span[0]:.4g} bpm" if span[1] - span[0] < 0.05 else f"{span[0]:.4g} to {span[1]:.4g} bpm"


def misfit_reason(clip: StepClip, span: tuple[float, float], *, slowest: float = min(FORM_FACTORS)) -> str:
    """Return why a recorded clip cannot be danced in a show, and what to do.

    `slowest`: tempo of its slowest form, as a share of the recorded one.
    """
    bpm = span[0] if span[0] > clip.bpm else span[1]
    ratio = bpm / clip.bpm
    words = f"{ratio:.2g} times its tempo" if ratio > 1.0 else f"{ratio:.2g} of its tempo"
    least, most = slowest * TEMPO_LIMITS[0] * clip.bpm, max(FORM_FACTORS) * TEMPO_LIMITS[1] * clip.bpm
    return (
        f"step {clip.step!r} ({clip.clip.name}) was recorded at {clip.bpm:.4g} bpm and the show is at "
        f"{span_text(span)}, {words}; correct its bpm and first_beat_s, or play it at {least:.4g} to {most:.4g} bpm"
    )


def _form_note(clip: StepClip, form: str, span: tuple[float, float]) -> str:
    return (
        f"step {clip.step!r}, recorded at {clip.bpm:.4g} bpm, is danced at {form} time where the show is at "
        f"{span_text(span)}"
    )
