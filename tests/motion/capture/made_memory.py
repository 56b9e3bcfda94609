"""Synthetic pose memory and request rows for tests of capture."""

import numpy as np

from live.motion.capture.capture_kernels import BLEND, GAP_BLEND, LAST_TURN, REQUEST_COLUMNS, STAMP, STAMP_COLUMN
from live.motion.skeleton import JOINT_COUNT


def make_memory(size, count, turn=0.0):
    """Memory of `size` with `count` poses, one per second, each 1 m further along x."""
    root, turned = np.zeros((size + 1, 3), np.float32), np.zeros((size + 1, JOINT_COUNT, 4), np.float32)
    turned[..., 0] = 1.0
    stamp = np.full((size, 2), -np.inf)
    for n in range(max(count - size, 0), count):
        root[n % size] = n, 0.9, 0.0
        turned[n % size, 0] = np.cos(turn * n / 2), 0.0, np.sin(turn * n / 2), 0.0
        stamp[n % size] = n, 2.0 * n
    return root, turned, stamp


def request_row(**columns):
    """Request row of one dancer, fully captured by default."""
    row = np.zeros((1, REQUEST_COLUMNS))
    row[0, GAP_BLEND] = 1.0
    for name, value in columns.items():
        row[
            0, {"key": STAMP_COLUMN, "wanted": STAMP, "share": BLEND, "caught": GAP_BLEND, "turned": LAST_TURN}[name]
        ] = value
    return row
