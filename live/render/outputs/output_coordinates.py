"""Coordinate transforms between picture and output window: crop, rotation, mirror, mesh and corner pin.

All coordinates are shares, 0 to 1, x to the right and y down.
"""

import numpy as np

from live.base.arrays import Float64
from live.render.outputs.output import Output, Point
from live.render.outputs.output_pass import rotation_matrix
from live.render.outputs.warp import homography, map_points, unwarp_point, warp_grid


def window_to_picture(output: Output, place: Point) -> Point:
    """Return the place of the picture that is shown at a place of the window."""
    back = np.linalg.inv(homography(output.corners)).astype(np.float64)
    x, y = map_points(back, place).tolist()
    part = rotation_matrix(output) @ (*unwarp_point(output.mesh, (x, y)), 1.0)
    left, top, width, height = output.crop
    return float(left + part[0] * width), float(top + part[1] * height)


def picture_to_window(output: Output, place: Point) -> Point:
    """Return the place in the window of a place of the picture; outside the mesh, offset from its border."""
    left, top, width, height = output.crop
    matrix = rotation_matrix(output).astype(np.float64)
    part = np.array([(place[0] - left) / width, (place[1] - top) / height])
    frame: Float64 = np.linalg.solve(matrix[:, :2], part - matrix[:, 2]).astype(np.float64)
    if output.mesh:
        within = np.clip(frame, 0.0, 1.0)
        frame = warp_grid(output.mesh, within[:1], within[1:])[0, 0] + frame - within
    x, y = map_points(homography(output.corners), frame).tolist()
    return x, y
