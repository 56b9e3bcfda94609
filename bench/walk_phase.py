"""Walks by example: whether sharp turns of the path come on the foot on which they were recorded (H018)."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from live.cli.bench import Row
from live.library.partner_pairs import Side, read_side
from live.motion.clip import Clip, clip_part
from live.motion.partner.partner_synthesis import (
    WALK_SEARCH,
    find_partner,
)
from live.motion.partner.path_leader import MAX_DISTANCE, frenet_cloud
from live.motion.partner.point_clouds import Cloud, ends_cloud, path_cloud
from live.motion.partner.step_phase import (
    SWAY_S,
    PhaseAtTurns,
    phase_at_turns,
    phase_difference,
    pooled,
    sharp_turns,
    step_phases,
)
from live.motion.partner.units import Example, Units, cut_units

WALK = "walk/figure8_MS2_8Walk_M.bvh"
LEAST_UNIT_S = 0.3


def run(full: bool, shared: Path | None) -> list[Row]:
    """Each half of a walk in figures of eight, from its path alone, with the strides of the other half."""
    del full  # it takes a second
    file = None if shared is None else shared / "mocap" / WALK
    if file is None or not file.is_file():
        return [Row("walk: spread of the step's phase at sharp turns", None, "cycles", note="needs the recorded walks")]
    clip = read_side(file, Side(file=file.name)).clip
    found = phases(clip)
    recorded = found["recorded"]
    spreads = {name: one.spread for name, one in found.items()}
    chances = {name: one.chance for name, one in found.items()}
    return [
        Row(
            "walk: spread of the step's phase at sharp turns, led by the walk's hips", found["hips"].spread,
            "cycles", 1.5 * recorded.spread, peers=spreads,
        ),
        Row(
            "walk: its mean phase from that of the real walk", phase_difference(found["hips"], recorded), "cycles",
            0.125, peers={"led by a smooth path": phase_difference(found["path"], recorded)},
        ),
        Row("walk: probability of such phases by chance", found["hips"].chance, "", 0.01, peers=chances),
        Row("walk: sharp turns", float(recorded.count), ""),
    ]  # fmt: skip


def phases(clip: Clip) -> dict[str, PhaseAtTurns]:
    """The phases at the turns of both halves of a walk: `recorded`; of answers to the recorded `hips` and to a smooth
    `path` without their sway; and of the `other` half's walk at those times, which knows nothing of them."""
    half = clip.sample_count // 2
    parts = clip_part(clip, 0, half), clip_part(clip, half, clip.sample_count)
    rows: dict[str, list[PhaseAtTurns]] = {"recorded": [], "hips": [], "path": [], "other": []}
    for given, asked in (parts, parts[::-1]):
        units, hips = cut_units([_strides(given)]), path_cloud(asked)
        middle = hips.floor.mean(axis=1)
        time = np.arange(asked.sample_count) / asked.sample_rate
        smooth = frenet_cloud(time, np.stack((middle.imag, middle.real), axis=1), asked.sample_rate, smooth=SWAY_S)
        rows["recorded"].append(phase_at_turns(asked, hips))
        rows["hips"].append(phase_at_turns(_answer(asked, hips, units), hips))
        rows["path"].append(phase_at_turns(_answer(asked, smooth, units), hips))
        turns = sharp_turns(hips)
        phase = step_phases(given, turns.times) + 0.5 * (turns.angles < 0.0)
        rows["other"].append(PhaseAtTurns(np.asarray(phase[np.isfinite(phase)] % 1.0)))
    return {name: pooled(each) for name, each in rows.items()}


def _strides(clip: Clip) -> Example:
    landed = np.flatnonzero((np.diff(clip.contact.astype(np.int8), axis=0) > 0).any(axis=1)) + 1.0
    kept = np.concatenate(([True], np.diff(landed) >= LEAST_UNIT_S * clip.sample_rate))
    return Example(
        clip.name, path_cloud(clip), ends_cloud(clip), clip, np.asarray(landed[kept], np.float64), np.zeros(0)
    )


def _answer(asked: Clip, control: Cloud, units: Units) -> Clip:
    search = replace(WALK_SEARCH, max_path_distance=MAX_DISTANCE)
    return find_partner(asked, control, units, search).clip
