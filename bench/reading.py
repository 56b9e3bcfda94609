"""Reading BVH files: the whole file parsed, and with all rotations as quaternions; milliseconds, the best of some."""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from bench._peers import absence, installed
from live.cli.bench import Row
from live.library.motion_file import read_motion
from live.motion.formats.bvh_reader import bvh_to_source_motion, parse_bvh

JOINTS, FRAMES = 43, 2000
BAR_MS = 25.0


def run(full: bool, shared: Path | None) -> list[Row]:
    """One core, the file in the system's cache; pybvh reads the same file in the same run."""
    repeats = 25 if full else 9
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "made.bvh"
        made.write_text(_made_up())
        rows = _rows(f"{FRAMES:,} frames of {JOINTS} joints", made, repeats, BAR_MS)
    name = "salsa 60_01, 2,243 frames of 43 joints"
    salsa = shared / "mocap" / "salsa" / "60_01.bvh" if shared is not None else None
    if salsa is None or not salsa.is_file():
        return [*rows, Row(name, None, "ms", note="no recordings here: --shared DIR")]
    return rows + _rows(name, salsa, repeats, BAR_MS * 2243 / FRAMES)


def _rows(name: str, path: Path, repeats: int, bar: float) -> list[Row]:
    ours = _best(lambda: parse_bvh(path.read_bytes(), path.name), repeats)
    turned = _best(lambda: bvh_to_source_motion(parse_bvh(path.read_bytes(), path.name)), repeats)
    whole = _best(lambda: read_motion(path), repeats)
    rows = [
        Row(f"{name}: parsed", ours, "ms", bar),
        Row(f"{name}: and turned into quaternions", turned, "ms"),
        Row(f"{name}: read_motion", whole, "ms", bar),
    ]
    names = f"{name}: pybvh's time / ours, parsed", f"{name}: the same, quaternions"
    if not installed("pybvh"):
        return [*rows, *(Row(each, None, "", 1.0, "at least", note=absence("pybvh")) for each in names)]
    import pybvh

    theirs = _best(lambda: pybvh.read_bvh_file(str(path)), repeats)
    their_turned = _best(lambda: pybvh.read_bvh_file(str(path)).to_quat(), repeats)
    return [
        *rows,
        Row(names[0], theirs / ours, "", 1.0, "at least", {"pybvh, ms": theirs}),
        Row(names[1], their_turned / turned, "", 1.0, "at least", {"pybvh, ms": their_turned}),
    ]


def _best(work: Callable[[], object], repeats: int) -> float:
    best = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return best * 1e3


def _made_up() -> str:
    """A file as capture programs write it: six decimals, six channels at the root and three elsewhere."""
    rng = np.random.default_rng(1)
    turns = "Zrotation Xrotation Yrotation"
    text = f"HIERARCHY\nROOT j0\n{{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition {turns}\n"
    for joint in range(1, JOINTS):
        text += f"JOINT j{joint}\n{{\nOFFSET 0 {joint}.5 0\nCHANNELS 3 {turns}\nEnd Site\n{{\nOFFSET 0 1 0\n}}\n}}\n"
    rows = rng.uniform(-180.0, 180.0, (FRAMES, 3 + 3 * JOINTS)).tolist()
    numbers = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in rows)
    return f"{text}}}\nMOTION\nFrames: {FRAMES}\nFrame Time: 0.016667\n{numbers}\n"
