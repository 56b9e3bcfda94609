"""Kernel for silhouettes: the mask of a turned region as an upright picture."""

from typing import Any

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
UInt8 = npt.NDArray[np.uint8]

SOFT = 2.0 / 3.0
"""Logits from the edge within which the silhouette is grey."""
BLACK, GREY, WHITE = 0, 1, 255


@inline_kernel
def _kind(mask: Any, row: int, column: int) -> int:
    """Return what lies between four neighbours of the mask: only black, only white, or some grey."""
    first, second = mask[row, column], mask[row, column + 1]
    third, fourth = mask[row + 1, column], mask[row + 1, column + 1]
    if first >= SOFT and second >= SOFT and third >= SOFT and fourth >= SOFT:
        return WHITE
    if first <= -SOFT and second <= -SOFT and third <= -SOFT and fourth <= -SOFT:
        return BLACK
    return GREY


@kernel("void(f4[:,::1], f8[::1], u1[:,:,::1])")
def draw_mask(mask: Float32, place: Float64, picture: UInt8) -> None:
    """Draw a mask's silhouette, white on black; only its edge is interpolated, which takes a quarter of the time.

    `mask` (m, n): logits, more than 0 on the body; NaN is black. `place` (6,): column and row of the mask at the
    picture's corner, from the mask's corner, then by how much both change per pixel to the right, and per pixel down
    [pixels of the mask]. `picture` (h, w, 3) is overwritten; beside the mask it is black.
    """
    rows, columns = mask.shape
    height, width = picture.shape[0], picture.shape[1]
    kinds = np.zeros((rows, columns), np.uint8)
    for row in range(rows - 1):
        for column in range(columns - 1):
            kinds[row, column] = _kind(mask, row, column)
    right_u, right_v, down_u, down_v = place[2], place[3], place[4], place[5]
    most_u, most_v = np.float32(columns - 1), np.float32(rows - 1)
    step_u, step_v = np.float32(right_u), np.float32(right_v)
    for y in range(height):
        # from the middle of the mask's first pixel to the middle of this row's first one
        first_u = np.float32(place[0] + 0.5 * right_u + (y + 0.5) * down_u - 0.5)
        first_v = np.float32(place[1] + 0.5 * right_v + (y + 0.5) * down_v - 0.5)
        for x in range(width):
            u, v = first_u + np.float32(x) * step_u, first_v + np.float32(x) * step_v
            grey = np.uint8(BLACK)
            if 0.0 <= u < most_u and 0.0 <= v < most_v:
                left, top = int(u), int(v)
                grey = kinds[top, left]
                if grey == GREY:
                    across, down = u - left, v - top
                    above = mask[top, left] + across * (mask[top, left + 1] - mask[top, left])
                    below = mask[top + 1, left] + across * (mask[top + 1, left + 1] - mask[top + 1, left])
                    level = 0.5 + 0.5 / SOFT * (above + down * (below - above))
                    grey = np.uint8(255.0 * min(level, 1.0)) if level > 0.0 else np.uint8(BLACK)
            picture[y, x, 0] = grey
            picture[y, x, 1] = grey
            picture[y, x, 2] = grey
