"""Quality of motion: how feet slide and joints jump in recordings, raw and after each editing tool."""

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench._motion_clips import SALSA, SOLO, WALKS, Material, recordings, sketches
from bench._step_metrics import StepMetrics, pelvis_displacement
from live.cli.bench import Row
from live.motion.clip import read_clip
from live.motion.editing.facing import face_head, heading_of
from live.motion.editing.foot_correction import correct_floor, find_feet
from live.motion.editing.interpolate import interpolate
from live.motion.editing.time_warp import draw_measure_warps, draw_sequence_warp, warp_sequence, warp_step
from live.motion.editing.turn_insertion import find_supports, insert_rotation
from live.motion.editing.variation import combine, draw_factors, draw_sequence_factors, scale_sequence, scale_step
from live.motion.mirror import mirror_step
from live.motion.pose.foot_lock import lock_feet
from live.motion.skeleton import MIRROR
from live.motion.step_clip import StepClip, corresponding_samples

Float64 = npt.NDArray[np.float64]
Tool = Callable[[StepClip, np.random.Generator], StepClip]

QUARTER = math.pi / 2
ALIKE = 0.85
"""Two measures are the same variation where the feet stand alike for this share of the time..."""
SAME_WAY = math.radians(90.0)
"""... and the hips never face farther apart than this."""
GLITCH = 5.0
"""Recordings in which a joint's velocity changes by more than this [m/s] from one sample to the next are glitched there
(T161): what an edit makes of such a jump says nothing about the edit."""
ROUNDING = 1e-5
"""Slide [m/s] that is none: positions are float32."""


def run(full: bool, shared: Path | None) -> list[Row]:
    """On the recordings in `shared`/mocap; where there are none, on the project's own sketches, as the rows say."""
    groups = _material(full, shared)
    rows: list[Row] = []
    for name, material in groups.items():
        rows += _raw(name, material)
    for label, tool in _tools().items():
        rows += _edited(label, tool, groups)
    rows += _rotation(groups)
    rows += _interpolation(groups)
    rows.append(_warp_ends(groups))
    rows += _foot_lock(groups)
    return rows


def _material(full: bool, shared: Path | None) -> dict[str, list[Material]]:
    folder = shared or Path(__file__).resolve().parents[2] / "shared"
    found = {
        "walks": recordings(folder, WALKS),
        "salsa": recordings(folder, SALSA if full else SALSA[:6]),
        "solo": recordings(folder, SOLO if full else SOLO[-3:]),
    }
    found = {name: material for name, material in found.items() if material}
    if found:
        return found
    own = ("walk", "samba", "mambo", "kick", "side_step", "grapevine", "turn", "reach")
    return {"sketches (no recordings here)": sketches(own)}


def _tools() -> dict[str, Tool]:
    """Each tool as it is used, with chance from a seed."""
    return {
        "mirror": lambda step, _: mirror_step(step),
        "rotation insertion 90°": lambda step, chance: insert_rotation(step, QUARTER * chance.choice((-1, 1))),
        "soft rotation insertion 90°": lambda step, chance: insert_rotation(
            step, QUARTER * chance.choice((-1, 1)), softness=0.3
        ),
        "measure warp": lambda step, chance: warp_step(step, draw_measure_warps(chance, step.measures)),
        "sequence warp": lambda step, chance: warp_sequence(step, draw_sequence_warp(chance, step.measures)),
        "amplitude by measure": lambda step, chance: scale_step(step, draw_factors(chance, step.measures)),
        "amplitude by sequence": lambda step, chance: scale_sequence(
            step, *draw_sequence_factors(chance, step.measures)
        ),
        "head facing": lambda step, _: replace(step, clip=face_head(step.clip)),
        "floor correction": lambda step, _: replace(step, clip=correct_floor(step.clip).clip),
    }


def _steps(material: Sequence[Material]) -> Iterator[StepClip]:
    return itertools.chain.from_iterable(each.steps for each in material)


def _mean_slide(figures: Sequence[StepMetrics]) -> float:
    """Over all samples of feet in contact, of all steps together [m/s]."""
    slides = np.concatenate([each.contact_speeds for each in figures])
    return float(slides.mean()) if len(slides) else 0.0


def _raw(group: str, material: Sequence[Material]) -> list[Row]:
    figures = [StepMetrics(step) for step in _steps(material)]
    acceleration = np.concatenate([each.accelerations for each in figures])
    return [
        Row(f"{group}: raw, foot slide", _mean_slide(figures), "m/s"),
        Row(f"{group}: raw, skating ratio", float(np.mean([each.skating for each in figures])), ""),
        Row(f"{group}: raw, largest velocity jump", max(each.velocity_jump for each in figures), "m/s"),
        Row(f"{group}: raw, p99 of accelerations", float(np.percentile(acceleration, 99)), "m/s²"),
        Row(f"{group}: raw, deepest sole below the floor", max(each.below_floor for each in figures), "m"),
    ]


def _edited(label: str, tool: Tool, groups: dict[str, list[Material]]) -> list[Row]:
    """Slide by group; the other figures over all groups, jumps without glitched steps; each beside the raw steps."""
    chance = np.random.default_rng(1)
    rows, before, after = [], [], []
    for group, material in groups.items():
        raw = [StepMetrics(step) for step in _steps(material)]
        edited = [StepMetrics(tool(step, chance)) for step in _steps(material)]
        rows.append(Row(f"{group}: {label}, foot slide", _mean_slide(edited), "m/s", peers={"raw": _mean_slide(raw)}))
        before += raw
        after += edited
    top = np.percentile(np.concatenate([each.accelerations for each in before]), 99, axis=0)
    top = np.maximum(top, top[list(MIRROR)])

    sound = np.array([each.velocity_jump < GLITCH for each in before])

    def added(figure: str, unit: str, of: Callable[[StepMetrics], float]) -> Row:
        raw = np.array([of(each) for each in before])
        more = (np.array([of(each) for each in after]) - raw)[sound]
        peers = {"median added": float(np.median(more)), "raw median": float(np.median(raw))}
        return Row(f"{label}, most {figure} added to a step", float(more.max()), unit, peers=peers)

    skating = [float(np.mean([each.skating for each in figures])) for figures in (after, before)]
    bones = [max(each.bone_error for each in figures) for figures in (after, before)]
    return [
        *rows,
        Row(f"{label}, skating ratio", skating[0], "", peers={"raw": skating[1]}),
        added("velocity jump", "m/s", lambda each: each.velocity_jump),
        added("acceleration, in p99 of raw,", "", lambda each: float((each.accelerations / top).max(initial=0.0))),
        Row(f"{label}, bone length error", bones[0], "m", 1e-5, peers={"raw": bones[1]}),
    ]


def _rotation(groups: dict[str, list[Material]]) -> list[Row]:
    """What 90 degrees add to the slide of walking measures: those in which each foot carries alone at some time."""
    added: list[float] = []
    raw: list[float] = []
    for step in _steps(next(iter(groups.values()))):
        first, stop = round(step.first), round(step.first + step.measures * step.samples_per_measure)
        supports = find_supports(find_feet(step.clip), step.clip.sample_rate, first, stop, contact=step.clip.contact)
        before = StepMetrics(step).mean_slide
        if len({support.foot for support in supports}) < 2 or before is None:
            continue
        raw.append(before)
        for angle in (QUARTER, -QUARTER):
            added.append((StepMetrics(insert_rotation(step, angle)).mean_slide or 0.0) - before)
    name, count = next(iter(groups)), len(raw)
    peers = {"raw slide": float(np.mean(raw)), "mean added": float(np.mean(added))}
    label = f"{name}: rotation insertion 90°, most slide added to one of {count} walking measures"
    return [Row(label, float(np.max(added)), "m/s", 0.02, peers=peers)]


def _interpolation(groups: dict[str, list[Material]]) -> list[Row]:
    """Two measures of one variation, mixed: how much more the result slides than the worse of the two."""
    excess: dict[str, list[float]] = {"plain SLERP": [], "feet held": []}
    upper: list[float] = []
    for a, b in _same_variation(groups):
        slides = [StepMetrics(each).mean_slide for each in (a, b)]
        if slides[0] is None or slides[1] is None:
            continue
        for weight in (0.25, 0.5, 0.75):
            for name, hold in (("plain SLERP", False), ("feet held", True)):
                mixed = StepMetrics(interpolate(a, b, weight, hold_feet=hold))
                excess[name].append((mixed.mean_slide or 0.0) - max(slides[0], slides[1]))
        upper.append((StepMetrics(combine(a, b)).mean_slide or 0.0) - slides[0])
    if not upper:
        return [Row("interpolation: no two measures of one variation here", None, "m/s", ROUNDING)]
    peers = {"mean": float(np.mean(excess["feet held"])), "pairs": float(len(upper))}
    plain = {"mean": float(np.mean(excess["plain SLERP"]))}
    return [
        Row(
            "interpolation, most slide beyond the worse clip's", max(excess["feet held"]), "m/s", ROUNDING, peers=peers
        ),
        Row("interpolation without held feet, the same", max(excess["plain SLERP"]), "m/s", peers=plain),
        Row("combination, most slide added", max(upper), "m/s", ROUNDING),
    ]


def _same_variation(groups: dict[str, list[Material]]) -> Iterator[tuple[StepClip, StepClip]]:
    for material in itertools.chain.from_iterable(groups.values()):
        for a, b in itertools.combinations(material.steps, 2):
            _, rotation, contact = read_clip(b.clip, corresponding_samples(b, a))
            apart = np.exp(1j * heading_of(rotation[:, 0])) / np.exp(1j * heading_of(a.clip.rotation[:, 0]))
            part = slice(round(a.first), round(a.first + a.measures * a.samples_per_measure))
            alike = (contact == a.clip.contact)[part].mean()
            if alike >= ALIKE and np.abs(np.angle(apart[part])).max() <= SAME_WAY:
                yield a, b
    if any(len(each.steps) == 1 for each in next(iter(groups.values()))) and "walks" not in groups:
        for name in ("walk", "samba", "side_step"):
            yield from itertools.combinations(
                [sketches((name,), way)[0].steps[0] for way in ("long forward", "long left", "short right")], 2
            )


def _warp_ends(groups: dict[str, list[Material]]) -> Row:
    """How far a warped measure is from the raw one at its end, over many warps [share of a measure]."""
    warps = draw_measure_warps(np.random.default_rng(2), 10_000)
    ends = np.abs(warps.phase(1.0) - 1.0).max()
    return Row("measure warp, distance from the identity at the measure's end", float(ends), "measures", 1e-6)


def _foot_lock(groups: dict[str, list[Material]]) -> list[Row]:
    """Slide after the feet are locked, and how far the pelvis had to move."""
    rows = []
    for group, material in groups.items():
        raw, locked, moved = [], [], 0.0
        for step in _steps(material):
            after = lock_feet(step.clip)
            raw.append(StepMetrics(step))
            locked.append(StepMetrics(replace(step, clip=after)))
            moved = max(moved, pelvis_displacement(step.clip, after))
        peers = {"raw": _mean_slide(raw)}
        rows.append(Row(f"{group}: foot lock, foot slide", _mean_slide(locked), "m/s", 0.02, peers=peers))
        rows.append(Row(f"{group}: foot lock, pelvis moved", moved, "m", 0.02))
        jumps = [max(each.velocity_jump for each in figures) for figures in (locked, raw)]
        rows.append(Row(f"{group}: foot lock, largest velocity jump", jumps[0], "m/s", peers={"raw": jumps[1]}))
        bones = max(each.bone_error for each in locked)
        rows.append(Row(f"{group}: foot lock, bone length error", bones, "m", 1e-5))
    return rows
