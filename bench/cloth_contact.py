"""Skirts, hair and sleeves in the fastest steps at 180 bpm: what of them is in the body, stretched, or through itself.

With `--shared` on recorded takes, too, that nothing was tuned with.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from bench._cloth_depth import SkinDepth, between
from live.base.arrays import Float32, Float64
from live.cli.bench import Row
from live.clock.ticks import TICK
from live.library.motion_file import read_motion
from live.motion.cloth.fabric import fabric_of
from live.motion.cloth.garment_batch import GarmentBatch
from live.motion.cloth.garment_catalogue import PATTERNS
from live.motion.cloth.pattern import compile_pattern
from live.motion.forward_kinematics import forward_kinematics
from live.motion.retarget.retarget import retarget
from live.render.body.body_limbs import body_sections
from live.show.dancers.garments import SUBSTEPS
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH

BPM: Final = 180.0
FASTEST: Final = 2
"""Dancers of each patch: those whose joints are fastest."""
SETTLE: Final = 64
DEEP: Final = 0.005
"""What is so deep in the body [m] counts."""
BODY: Final = "dancer"
_GARMENTS: Final = ("skirt", "long skirt", "left sleeve", "long hair", "ponytail")
_SOME: Final = ("hiphop", "release", "house", "ballet")
"""Patches with the fastest steps."""
_TAKES: Final = (
    "salsa/60_05.bvh", "salsa/60_07.bvh", "salsa/61_05.bvh", "salsa/61_07.bvh", "solo/modern05/*.bvh",
    "solo/rokoko_jesse_dance.bvh", "solo/indian94/*.bvh",
)  # fmt: skip
_SEGMENT: Final = 400
_SEGMENTS: Final = 32
_Dance = tuple[Float32, Float32]


def run(full: bool, shared: Path | None) -> list[Row]:
    """All patches with `full`, else those with the fastest steps."""
    skin, rows = SkinDepth(BODY), []
    takes = _takes(shared / "mocap") if shared is not None else None
    for name in _GARMENTS:
        if takes is None:
            rows.append(Row(f"recorded takes, {name}", None, "", note="needs --shared"))
        else:
            rows += _measure(f"recorded takes, {name}", name, takes, skin, every=10 if full else 50)
    dance = _fastest_steps(full=full)
    for name in _GARMENTS:
        rows += _measure(f"{BPM:.0f} bpm, {name}", name, dance, skin, every=10 if full else 40)
    return rows


def _measure(title: str, name: str, dance: _Dance, skin: SkinDepth, *, every: int) -> list[Row]:
    """Let all dance; measure every so many ticks, a third of them at a time."""
    position, rotation = dance
    pattern, count = PATTERNS[name], position.shape[1]
    batch = GarmentBatch(compile_pattern(pattern, fabric_of(pattern.kind, "cotton")))
    batch.wear(np.arange(count, dtype=np.int32), [body_sections(BODY)] * count)
    out = np.zeros((count, pattern.count, 3), np.float32)
    particles, sheet, down, along, disorder = [], [], [], [], []
    seen = 0
    for tick in range(len(position)):
        batch.tick(position[tick], rotation[tick], np.zeros(3, np.float32), SUBSTEPS, TICK)
        if tick < SETTLE or tick % every:
            continue
        batch.draw(position[tick], rotation[tick], out, age=0.0, dt=TICK, skinned=False)
        grid = out.reshape(count, pattern.rows, pattern.columns, 3).astype(np.float64)
        edges = np.linalg.norm(np.diff(grid, axis=1), axis=-1)[:, pattern.pinned_rows - 1 :]
        down.append(float(edges.max()) / pattern.spacing - 1.0)
        after = np.roll(grid, -1, axis=2) if pattern.closed else grid[:, :, 1:]
        wide = np.linalg.norm(after - grid[:, :, : after.shape[2]], axis=-1) / np.array(pattern.widths)[None, :, None]
        along.append(wide[:, pattern.pinned_rows :].ravel() - 1.0)
        disorder.append(_disorder(grid))
        for who in range(tick // every % 3, count, 3):
            free = grid[who, pattern.pinned_rows - 1 :]
            points = np.concatenate([free[1:].reshape(-1, 3), between(free, closed=pattern.closed)])
            depth = -skin.distance(points, position[tick, who], rotation[tick, who])
            own = free[1:].shape[0] * free.shape[1]
            particles.append(depth[:own])
            deep = points[:own][depth[:own] > DEEP]
            if len(deep):
                seen += int(np.sum(~skin.is_covered(deep, position[tick, who], rotation[tick, who])))
            sheet.append(depth[own:])
    inside, within, rows = np.concatenate(particles), np.concatenate(sheet), np.concatenate(along)
    found = [
        Row(f"{title}: particles more than 5 mm inside", 100.0 * float(np.mean(inside > DEEP)), "%"),
        Row(f"{title}: … where no other flesh covers the skin", 100.0 * seen / len(inside), "%"),
        Row(f"{title}: particles, 999 of 1000 are less deep than", 1e3 * float(np.percentile(inside, 99.9)), "mm", 5.0),
        Row(f"{title}: the sheet more than 5 mm inside", 100.0 * float(np.mean(within > DEEP)), "%"),
        Row(f"{title}: deepest place of the sheet", 1e3 * float(within.max()), "mm"),
        Row(f"{title}: longest edge down a column", 100.0 * max(down), "% stretch", 5.0),
    ]
    if pattern.kind == "cloth":
        found.append(Row(f"{title}: longest edge along a row", 100.0 * float(rows.max()), "% stretch", 5.0))
        found.append(Row(f"{title}: neighbours in wrong order", 100.0 * float(np.mean(disorder)), "%"))
    return found


def _disorder(grid: Float64) -> float:
    """Return the share of neighbours in rows (n, rows, columns, 3) that lie in the wrong order around their middle."""
    own = grid - grid.mean(axis=2, keepdims=True)
    sectors = np.cross(own, np.roll(own, -1, axis=2))
    return float(np.mean((sectors * sectors.sum(axis=2, keepdims=True)).sum(axis=-1) < 0.0))


def _fastest_steps(*, full: bool) -> _Dance:
    """Joints of the fastest dancers over the ticks, (T, A, J, 3) and (T, A, J, 4)."""
    root = DEFAULT_PATCH.parent
    paths = sorted(root.glob("*/show.toml")) if full else [root / name / "show.toml" for name in _SOME]
    position, rotation = [], []
    for path in [DEFAULT_PATCH, *paths]:
        show = load_show(path).start(tempo=BPM)
        places, turns = [], []
        for tick in range(1, 385 if full else 257):
            show.tick(tick * TICK)
            joints = show.dancers.pose(show.span.fraction(show.timeline.beat_at(tick * TICK)), tick * TICK)
            places.append(joints[0].copy())
            turns.append(joints[1].copy())
        moved = np.linalg.norm(np.diff(np.array(places), axis=0), axis=-1)
        order = np.argsort(-np.percentile(moved.max(axis=-1), 95, axis=0), kind="stable")[:FASTEST]
        position.append(np.array(places)[:, order])
        rotation.append(np.array(turns)[:, order])
    return _joined(position), _joined(rotation)


def _joined(parts: list[Float32]) -> Float32:
    return np.ascontiguousarray(np.concatenate(parts, axis=1))


def _takes(folder: Path) -> _Dance:
    """Segments of recorded takes at their own speed, as `_fastest_steps`."""
    parts = list(_segments(folder))[:_SEGMENTS]
    return np.stack([one[0] for one in parts], axis=1), np.stack([one[1] for one in parts], axis=1)


def _segments(folder: Path) -> Iterator[_Dance]:
    for pattern in _TAKES:
        for path in sorted(folder.glob(pattern))[:3]:
            fps = 60 if path.parent.name == "salsa" else None
            clip = retarget(read_motion(path), name=path.stem, fps=fps, drop_frames=6, sample_rate=1.0 / TICK)
            position, rotation = forward_kinematics(clip.root_position, clip.rotation)
            for begin in range(0, len(position) - _SEGMENT, _SEGMENT):
                part = slice(begin, begin + _SEGMENT)
                yield position[part].astype(np.float32), rotation[part].astype(np.float32)
