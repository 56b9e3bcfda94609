"""`live partner --path`: a drawn path as the leader of a walk (H019)."""

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.errors import PersonError
from live.library.pairs_file import Recorded
from live.motion.clip import Clip
from live.motion.partner.cloud import Cloud
from live.motion.partner.frenet import frenet_cloud
from live.motion.retarget.retarget import SAMPLE_RATE
from live.motion.skeleton import JOINT_COUNT, SKELETON

Float64 = npt.NDArray[np.float64]

MAX_BYTES: Final = 50_000_000
LONGEST: Final = 3600.0
"""Seconds of a path at most."""
FARTHEST: Final = 1000.0
"""Metres from the origin at most."""
RUNNING: Final = 3.0
"""Faster than this [m/s] nobody walks."""


@dataclass(frozen=True, slots=True, eq=False)
class Led:
    """A leader on the engine's skeleton."""

    recorded: Recorded
    dropped: int
    """Leading frames that were left out."""


def led_by_path(path: Path, smooth: float) -> tuple[Led, Cloud]:
    """The path as a leader: somebody who glides along it, and her control cloud."""
    time, place = read_path(path)
    cloud = frenet_cloud(time, place, SAMPLE_RATE, smooth=smooth)
    middle = cloud.floor.mean(axis=1)
    speed = np.abs(np.diff(middle)) * SAMPLE_RATE
    if speed.size and float(np.percentile(speed, 90)) > RUNNING:
        raise PersonError(
            f"{path}: {np.percentile(speed, 90):.1f} m/s; nobody walks faster than {RUNNING:g} m/s",
            "perform the path at the speed of a walk; times are in s, places in m",
        )
    root = np.zeros((cloud.count, 3), np.float32)
    root[:, 0], root[:, 1], root[:, 2] = middle.imag, SKELETON.rest_positions()[0, 1], middle.real
    rotation = np.zeros((cloud.count, JOINT_COUNT, 4), np.float32)
    across = (cloud.floor[:, 0] - cloud.floor[:, 1]) / 1j
    rotation[..., 0] = 1.0
    half = 0.5 * np.angle(across)
    rotation[:, 0, 0], rotation[:, 0, 2] = np.cos(half), np.sin(half)
    clip = Clip("path", root, rotation, SAMPLE_RATE, np.zeros((cloud.count, 2), np.bool_))
    return Led(Recorded(clip, cloud.count, SAMPLE_RATE, SAMPLE_RATE), 0), cloud


def read_path(path: Path) -> tuple[Float64, Float64]:
    """Times (n,) [s] and places (n, 2), x and z [m], of a CSV file with the columns time_s, x, z; PersonError."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{path}: more than {MAX_BYTES} bytes")
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except OSError as error:
        raise PersonError(f"cannot read the path {path}: {error.strerror}", "--path PATH.csv") from None
    except UnicodeDecodeError:
        raise PersonError(f"{path}: not a text in UTF-8") from None
    rows: list[tuple[float, float, float]] = []
    for number, row in enumerate(csv.reader(lines), 1):
        if not row or row[0].lstrip().startswith("#"):
            continue
        try:
            time, x, z = (float(value) for value in row)
        except ValueError:
            if not rows and number == 1:
                continue  # a heading
            raise PersonError(f"{path}, line {number}: three numbers expected: time_s, x, z") from None
        if not (np.isfinite([time, x, z]).all() and max(abs(x), abs(z)) <= FARTHEST):
            raise PersonError(f"{path}, line {number}: places within {FARTHEST:g} m expected")
        if rows and time <= rows[-1][0]:
            raise PersonError(f"{path}, line {number}: time {time:g} s after {rows[-1][0]:g} s; times ascend")
        rows.append((time, x, z))
    if len(rows) < 2 or rows[-1][0] - rows[0][0] > LONGEST:
        raise PersonError(f"{path}: {len(rows)} points; two at least, over {LONGEST:g} s at most, expected")
    values = np.array(rows)
    return values[:, 0], values[:, 1:]
