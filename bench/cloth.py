"""Skirts, hair, sleeves and ribbons: time of a tick and of a picture, and what of them is stretched or in the body."""

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Final

import numpy as np

from bench._show import crowd
from live.base.arrays import Float32
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.motion.cloth.contact_kernels import keep_out
from live.motion.cloth.fabric import fabric_of
from live.motion.cloth.garment_batch import GarmentBatch
from live.motion.cloth.garment_catalogue import PATTERNS
from live.motion.cloth.limb_kernels import LANES
from live.motion.cloth.pattern import compile_pattern
from live.render.body.body_limbs import body_sections
from live.show.dancers.garments import BUDGET, FEWEST_SUBSTEPS, SUBSTEPS

DANCERS: Final = 50
SETTLE: Final = 64
"""Ticks before anything is measured."""
OUTFIT: Final = ("skirt", "long hair")
"""What the limit of time is for."""
_NO_WIND: Final = np.zeros(3, np.float32)


def run(full: bool, shared: Path | None) -> list[Row]:
    """A dance of the default show at its tempo; processor time of one thread."""
    position, rotation = _dance(600 if full else 240)
    rows, ticks, pictures = [], {}, {}
    for name in PATTERNS:
        batch = _dressed(name)
        ticks[name], pictures[name], stretched, wide, lengths = _measure(batch, position, rotation)
        rows.append(Row(f"{DANCERS} × {name}: a tick", ticks[name], "ms"))
        rows.append(Row(f"{DANCERS} × {name}: a picture", pictures[name], "ms"))
        rows.append(Row(f"{name}: longest edge down a column", 100.0 * stretched, "% stretch", 5.0))
        if PATTERNS[name].kind == "cloth":
            rows.append(Row(f"{name}: edges along rows, 999 of 1000", 100.0 * wide, "% stretch", 5.0))
        rows.append(Row(f"{name}: edges measured", float(lengths), ""))
    both = sum(ticks[name] for name in OUTFIT)
    rows.insert(0, Row(f"{DANCERS} dancers with {' and '.join(OUTFIT)}: a tick", both, "ms", 2.0))
    seen = sum(pictures[name] for name in OUTFIT)
    rows.insert(1, Row(f"{DANCERS} dancers with {' and '.join(OUTFIT)}: a picture", seen, "ms"))
    poses = _poses(position)
    rows.insert(2, Row("the poses for it: a tick", poses, "ms", peers={"garments [ms]": both}))
    most = BUDGET // (FEWEST_SUBSTEPS * sum(PATTERNS[name].count for name in OUTFIT))
    rows.insert(3, Row(f"dancers with both who are simulated in a crowd, {FEWEST_SUBSTEPS} substeps", float(most), ""))
    rows.append(Row("contact of a particle with a limb", _contact(), "ns"))
    return rows


def _dance(ticks: int) -> tuple[Float32, Float32]:
    """Joints of the dancers over the ticks."""
    show = crowd(DANCERS)
    position, rotation = [], []
    for tick in range(1, ticks + 1):
        show.tick(tick * TICK)
        joints = show.dancers.pose(show.span.fraction(show.timeline.beat_at(tick * TICK)), tick * TICK)
        position.append(joints[0][:DANCERS].copy())
        rotation.append(joints[1][:DANCERS].copy())
    return np.array(position), np.array(rotation)


def _dressed(name: str) -> GarmentBatch:
    pattern = PATTERNS[name]
    batch = GarmentBatch(compile_pattern(pattern, fabric_of(pattern.kind, "cotton")))
    batch.wear(np.arange(DANCERS, dtype=np.int32), [body_sections("dancer")] * DANCERS)
    return batch


def _measure(batch: GarmentBatch, position: Float32, rotation: Float32) -> tuple[float, float, float, float, int]:
    """Return the time of a tick and of a picture [ms], the largest stretch down the columns, the 999th of 1000 along
    the rows, and the number of edges."""
    pattern = batch.compiled.pattern
    out = np.zeros((DANCERS, pattern.count, 3), np.float32)
    ticks, pictures, down, along = [], [], [], []
    for tick in range(len(position)):
        places, turns = position[tick], rotation[tick]
        ticks.append(_time(partial(batch.tick, places, turns, _NO_WIND, SUBSTEPS, TICK)))
        if tick < SETTLE or tick % 4:
            continue
        pictures.append(_time(partial(batch.draw, places, turns, out, age=0.5 * TICK, dt=TICK, skinned=False)))
        batch.draw(places, turns, out, age=0.0, dt=TICK, skinned=False)
        grid = out.reshape(DANCERS, pattern.rows, pattern.columns, 3).astype(np.float64)
        edges = np.linalg.norm(np.diff(grid, axis=1), axis=-1)[:, pattern.pinned_rows - 1 :] / pattern.spacing - 1.0
        down.append(edges.ravel())
        after = np.roll(grid, -1, axis=2) if pattern.closed else grid[:, :, 1:]
        wide = np.linalg.norm(after - grid[:, :, : after.shape[2]], axis=-1)
        along.append((wide / np.array(pattern.widths)[None, :, None] - 1.0)[:, pattern.pinned_rows :].ravel())
    columns, rows = np.concatenate(down), np.concatenate(along)
    return (
        float(np.median(ticks)), float(np.median(pictures)), float(columns.max()), float(np.percentile(rows, 99.9)),
        len(columns) + len(rows),
    )  # fmt: skip


def _time(call: Callable[[], object]) -> float:
    """Processor time of a call [ms]."""
    begin = time.process_time_ns()
    call()
    return (time.process_time_ns() - begin) * 1e-6


def _poses(position: Float32) -> float:
    show = crowd(DANCERS)
    show.tick(TICK)
    return min(_time(lambda: show.dancers.pose(0.3, TICK)) for _ in range(max(len(position) // 4, 20)))


def _contact() -> float:
    """Time of a particle's contact with a limb [ns], where all are near."""
    chance, columns = np.random.default_rng(1), 24
    places = chance.normal(0.0, 0.1, (3, 10 * columns * LANES)).astype(np.float32)
    limbs = _dressed("skirt")._limbs[0]
    contacts = np.array([(row * columns, columns, 0, 0) for row in range(10)], np.int32)
    best = min(_time(lambda: keep_out(places.copy(), contacts, limbs, 0.014)) for _ in range(200))
    return best * 1e6 / (10 * columns * LANES)
