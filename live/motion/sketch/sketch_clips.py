"""Conversion of a sketch to step clips: every direction of T131, also mirrored (T042)."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from live.base.arrays import Float
from live.base.motion_parameters import MOOD_NAMES
from live.motion.clip import Clip
from live.motion.mirror import mirror_step
from live.motion.sketch.foot_plan import delay_departures, find_flights, find_stances, weight_balance
from live.motion.sketch.foot_trajectories import BodyPath, foot_track, place_stances, separate_feet
from live.motion.sketch.phrase_takes import Take
from live.motion.sketch.sketch_file import Sketch
from live.motion.sketch.sketch_pose import pose_body
from live.motion.sketch.upper_body import SAMPLES_PER_BEAT, FootSupport, facing
from live.motion.step_clip import DIRECTIONS, StepClip, measured_distance, moved_shapes

TAIL_SAMPLES: Final = 8
"""Samples after the last measure, so that reading at its end needs no special case."""
_MARGIN_BEATS: Final = 2.0
"""Beats computed and discarded at both ends, in which the filters settle."""
_TOLERANCE: Final = 0.003
_UNIT: Final = {"forward": (0.0, 1.0), "back": (0.0, -1.0), "left": (1.0, 0.0), "right": (-1.0, 0.0)}


def step_clips(sketch: Sketch) -> list[StepClip]:
    """Return all variations of a step: its directions if it travels, each of its takes, each also mirrored (T042).

    Each begins with a whole measure of lead-in. Takes are in file order, directions in the order of DIRECTIONS, and
    mirrored clips follow all others in the same order. Raises SketchError if a leg cannot reach its place.
    """
    directions = sketch.directions if sketch.travels else DIRECTIONS[:1]
    whole = [step_clip(sketch, direction) for direction in directions]
    own = [cut_take(step, take) for take in sketch.takes for step in whole] if sketch.takes else whole
    if not sketch.mirror:
        return own
    mirrored: list[StepClip] = []
    for number in range(0, len(own), len(whole)):
        take = map(mirror_step, own[number : number + len(whole)])
        mirrored += sorted(take, key=lambda step: DIRECTIONS.index(step.direction))
    return own + mirrored


def mood_suffix(mood: Sequence[float]) -> str:
    """Return the words for the mood of an example, with which its clip's name differs from those of others."""
    told = [f"{name} {value:g}" for name, value in zip(MOOD_NAMES, mood, strict=False) if value]
    return f" ({', '.join(told)})" if told else ""


def cut_take(step: StepClip, take: Take) -> StepClip:
    """Return a take as a separate step, with the measure before it as lead-in (T039)."""
    size = round(step.samples_per_measure)
    begin = take.first * size
    part = slice(begin, begin + (1 + take.measures) * size + 1 + TAIL_SAMPLES)
    clip, root = step.clip, step.clip.root_position[part]
    cut = Clip(
        name=f"{clip.name}, measure {take.first + 1}",
        root_position=root - root[size] * np.array((1.0, 0.0, 1.0), np.float32),
        rotation=np.ascontiguousarray(clip.rotation[part]),
        sample_rate=clip.sample_rate,
        contact=np.ascontiguousarray(clip.contact[part]),
    )
    beats = step.beats_per_measure
    shown = [
        each for each in moved_shapes(step.hands, by=-float(take.first * beats)) if each[0] < take.measures * beats
    ]
    own = replace(step, clip=cut, measures=take.measures, **{"hands": tuple(shown), **take.attributes})
    return replace(own, distance_m=measured_distance(own))


def displacement(sketch: Sketch, direction: str) -> tuple[float, float]:
    """Return the displacement of the whole step [m] in x and z; the dancer faces +z, the right side is -x."""
    if direction == "in place":
        return 0.0, 0.0
    length, _, way = direction.partition(" ")
    distance = (sketch.long if length == "long" else sketch.short) * sketch.beats / sketch.beats_per_measure
    return distance * _UNIT[way][0], distance * _UNIT[way][1]


def step_clip(sketch: Sketch, direction: str = "in place") -> StepClip:
    """Return one variation, not mirrored, with `SAMPLES_PER_BEAT` samples per beat."""
    lead = sketch.beats_per_measure
    first = lead * SAMPLES_PER_BEAT
    count = first + sketch.beats * SAMPLES_PER_BEAT + 1 + TAIL_SAMPLES
    margin = int(_MARGIN_BEATS * SAMPLES_PER_BEAT)
    beats = (np.arange(-margin, count + margin) - first) / SAMPLES_PER_BEAT
    x, z = displacement(sketch, direction)
    path = BodyPath(lambda at: facing(sketch, at), (x / sketch.beats, z / sketch.beats))
    own = {side: find_stances(sketch, f"{side}_foot", beats[0], beats[-1]) for side in ("left", "right")}
    own["left"] = delay_departures(own["left"], own["right"])
    own["right"] = delay_departures(own["right"], own["left"])
    world = {side: place_stances(path, own[side], sign) for side, sign in (("left", 1.0), ("right", -1.0))}
    if x != 0.0:
        separate_feet(own["left"], world["left"], own["right"], world["right"])
    leaps = find_flights(own["left"], own["right"])
    tracks = [
        foot_track(path, own[side], world[side], sign, beats, leaps) for side, sign in (("left", 1.0), ("right", -1.0))
    ]
    weight = weight_balance(own["left"], own["right"], beats)
    ground = FootSupport(beats, facing(sketch, beats), weight, tracks[0], tracks[1], leaps)
    root, rotation, short = pose_body(sketch, ground)
    root, rotation = root[margin:-margin], rotation[margin:-margin]
    root = root - root[first] * (1.0, 0.0, 1.0)
    contact = np.stack([foot.contact[margin:-margin] for foot in tracks], axis=1)
    _check_reach(sketch, direction, beats[margin:-margin], short[margin:-margin] * contact)
    clip = Clip(
        name=f"{sketch.name}, {direction}" + mood_suffix(sketch.attributes.get("mood", ())),
        root_position=root.astype(np.float32),
        rotation=np.ascontiguousarray(rotation, np.float32),
        sample_rate=SAMPLES_PER_BEAT * sketch.bpm / 60.0,
        contact=contact,
    )
    step = StepClip(
        step=sketch.name,
        clip=clip,
        first=float(first),
        samples_per_measure=float(sketch.beats_per_measure * SAMPLES_PER_BEAT),
        measures=sketch.beats // sketch.beats_per_measure,
        beats_per_measure=sketch.beats_per_measure,
        bpm=sketch.bpm,
        direction=direction,
        **sketch.attributes,
    )
    return replace(step, distance_m=measured_distance(step))


def _check_reach(sketch: Sketch, direction: str, beats: Float, short: Float) -> None:
    """Raise SketchError if an ankle misses its place; `short` (T, 2) are the distances [m]."""
    sample, foot = np.unravel_index(int(np.argmax(short)), short.shape)
    if short[sample, foot] < _TOLERANCE:
        return
    count = beats[sample] % sketch.beats + 1.0
    part = f"{('left', 'right')[int(foot)]}_foot"
    problem = f"on count {count:.2f} ({direction}) it stands {short[sample, foot] * 100:.0f} cm beyond the leg's reach"
    remedy = "let the feet stand closer together"
    if direction != DIRECTIONS[0]:
        remedy += ", or make short and long smaller"
    raise sketch.error(part, problem, remedy)
