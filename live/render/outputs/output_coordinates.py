"""Coordinate transforms between picture and output window: crop, rotation, mirror, mesh and corner pin.

All coordinates are shares, 0 to 1, x to the right and y down.
"""

import numpy as np
import numpy.typing as npt

from live.render.outputs.output import Output, Point
from live.render.outputs.output_pass import turned
from live.render.outputs.warp import bent, homography, mapped, unbent

Float64 = npt.NDArray[np.float64]


def picture_place(output: Output, place: Point) -> Point:
    """Return the place of the picture that is shown at a place of the window."""
    back = np.linalg.inv(homography(output.corners)).astype(np.float64)
    x, y = mapped(back, place).tolist()
    part = turned(output) @ (*unbent(output.mesh, (x, y)), 1.0)
    left, top, width, height = output.crop
    return float(left + part[0] * width), float(top + part[1] * height)


def window_place(output: Output, place: Point) -> Point:
    """Return the place in the window of a place of the picture; outside the mesh, offset from its border."""
    left, top, width, height = output.crop
    matrix = turned(output).astype(np.float64)
    part = np.array([(place[0] - left) / width, (place[1] - top) / height])
    frame: Float64 = np.linalg.solve(matrix[:, :2], part - matrix[:, 2]).astype(np.float64)
    if output.mesh:
        within = np.clip(frame, 0.0, 1.0)
        frame = bent(output.mesh, within[:1], within[1:])[0, 0] + frame - within
    x, y = mapped(homography(output.corners), frame).tolist()
    return x, y
