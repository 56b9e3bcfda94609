"""Kernels of the camera director: exact framing, the picture's box, legibility of a view, distance from bodies.

A body is an upright cylinder. A view is a bearing around the stage (0 from the public's side, positive towards +x), an
elevation above the horizon, and the tangents of half the lens's angles to the side and up. Positions are (x, z) [m].
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Float64 = npt.NDArray[np.float64]
Bool = npt.NDArray[np.bool_]

RADIUS = 0.35
"""Radius of a body with its arms at rest [m]."""
HEIGHT = 1.74
"""Height of a body [m]."""
COLUMNS = 192
"""Columns of the picture in which bodies hide each other."""
NEAREST = 0.6
"""Depth [m] from which on bodies are in the picture."""


@inline_kernel
def camera_axes(bearing: float, elevation: float) -> tuple[float, ...]:
    """Return the axes of a view: right, up and forward, x, y, z of each."""
    sin, cos, low, high = math.sin(bearing), math.cos(bearing), math.cos(elevation), math.sin(elevation)
    return cos, 0.0, -sin, -sin * high, low, -cos * high, -sin * low, -high, -cos * low


@kernel("b1(f8[:,::1],b1[::1],f8[::1],f8[::1],f8[::1])")
def fit_view(place: Float64, chosen: Bool, body: Float64, view: Float64, out: Float64) -> bool:
    """Find the nearest camera of a direction from which the chosen bodies fill a given part of the picture.

    `place` (n, 2) [m]; `body`: lowest and highest height that has to be seen, and radius [m]; `view`: bearing,
    elevation [rad], tangents to the side and up, shares of the half picture to be filled to the sides, above and below
    the middle, share of free height that lies above, nearest distance [m]. `out` (4): target x, y, z and distance [m].
    False if nobody is chosen.

    With a fixed direction each side of the picture is a plane that slides along the view's axes. So the distance is a
    difference of extremes of linear forms, without a search.
    """
    rx, _, rz, ux, uy, uz, fx, fy, fz = camera_axes(view[0], view[1])
    side, top, bottom = view[2] * view[4], view[3] * view[5], view[3] * view[6]
    reach = body[2] * abs(math.sin(view[1]))  # seen from above a foot before the body is lower in the picture
    left, right, high, low, near, far = -1e18, 1e18, -1e18, 1e18, 1e18, -1e18
    for i in range(len(place)):
        if not chosen[i]:
            continue
        for k in range(2):
            x, y, z = place[i, 0], body[k], place[i, 1]
            a, b, c = x * rx + z * rz, x * ux + y * uy + z * uz, x * fx + y * fy + z * fz
            left = max(left, a + body[2] - side * c)
            right = min(right, a - body[2] + side * c)
            high = max(high, b - top * c)
            low = min(low, b - reach * (1 - k) + bottom * c)
            near, far = min(near, c), max(far, c)
    if near > 1e17:
        return False
    back = min((right - left) / (2.0 * side), (low - high) / (top + bottom), near - view[8])
    across = 0.5 * (left + right)  # both limits move with the distance by the same amount
    lower, upper = high + top * back, low - bottom * back
    along = lower + (upper - lower) * view[7]
    ahead = 0.5 * (near + far) - back
    out[0] = across * rx + along * ux + (back + ahead) * fx
    out[1] = along * uy + (back + ahead) * fy
    out[2] = across * rz + along * uz + (back + ahead) * fz
    out[3] = ahead
    return True


@kernel("void(f8[:,::1],b1[::1],f8[::1],f8[::1],f8[::1],f8[::1])")
def box_in_view(place: Float64, chosen: Bool, body: Float64, view: Float64, camera: Float64, out: Float64) -> None:
    """Find the box of the chosen bodies in a picture: left, right, bottom, top, from -1 to 1.

    `camera` (4): target and distance, `view`: as for `fit_view`. A box of a body behind the camera is (-9, 9, -9, 9).
    """
    rx, _, rz, ux, uy, uz, fx, fy, fz = camera_axes(view[0], view[1])
    ex, ey, ez = camera[0] - camera[3] * fx, camera[1] - camera[3] * fy, camera[2] - camera[3] * fz
    reach = body[2] * abs(math.sin(view[1]))
    out[0], out[1], out[2], out[3] = 9.0, -9.0, 9.0, -9.0
    for i in range(len(place)):
        if not chosen[i]:
            continue
        for k in range(2):
            x, y, z = place[i, 0] - ex, body[k] - ey, place[i, 1] - ez
            depth = x * fx + y * fy + z * fz
            if depth < NEAREST:
                out[0], out[1], out[2], out[3] = -9.0, 9.0, -9.0, 9.0
                return
            a, b = (x * rx + z * rz) / (depth * view[2]), (x * ux + y * uy + z * uz) / (depth * view[3])
            r = body[2] / (depth * view[2])
            out[0], out[1] = min(out[0], a - r), max(out[1], a + r)
            low = reach * (1 - k) / (depth * view[3])
            out[2], out[3] = min(out[2], b - low), max(out[3], b)


@inline_kernel
def depths_of(place: Float64, there: Bool, ex: float, ey: float, ez: float, fx: float, fy: float, fz: float) -> Float64:
    """Return how far the middles of bodies lie before an eye, (n,) [m]; 1e18 for who is not `there`."""
    depth = np.empty(len(place))
    for i in range(len(place)):
        x, y, z = place[i, 0] - ex, 0.5 * HEIGHT - ey, place[i, 1] - ez
        depth[i] = x * fx + y * fy + z * fz if there[i] else 1e18
    return depth


@kernel("void(f8[:,::1],b1[::1],b1[::1],f8[::1],f8[::1],f8[::1],f8[::1])")
def view_legibility(
    place: Float64, there: Bool, chosen: Bool, heading: Float64, view: Float64, camera: Float64, out: Float64
) -> None:
    """Measure how well the `chosen` of the dancers who are `there` (n,) are read in a picture.

    `out` (5): mean visible share of the chosen; that of the least visible one; viewpoint entropy of the chosen's
    visible areas, from 0 to 1 (Vázquez, Feixas, Sbert and Heidrich 2001: the areas of a scene's parts as a
    distribution; 1 if all are equally large); mean cosine between their headings and the way to the camera;
    share of the picture that others take before the nearest of the chosen.

    Bodies are taken from near to far, and each column of the picture keeps the height up to which it is covered, as a
    floating horizon does (Anderson 1982).
    """
    rx, _, rz, ux, uy, uz, fx, fy, fz = camera_axes(view[0], view[1])
    ex, ey, ez = camera[0] - camera[3] * fx, camera[1] - camera[3] * fy, camera[2] - camera[3] * fz
    out[:] = 0.0
    count = len(place)
    depth = depths_of(place, there, ex, ey, ez, fx, fy, fz)
    order = np.argsort(depth, kind="mergesort")
    horizon = np.full(COLUMNS, -1e18)
    seen, least, faces, area, spread, number = 0.0, 1.0, 0.0, 0.0, 0.0, 0
    for index in range(count):
        i = order[index]
        if not there[i] or depth[i] > 1e17:
            break
        if depth[i] < NEAREST:
            continue
        x, z = place[i, 0] - ex, place[i, 1] - ez
        middle = (x * rx + z * rz) / (depth[i] * view[2])
        radius = RADIUS / (depth[i] * view[2])
        bottom_depth = x * fx - ey * fy + z * fz
        top_depth = bottom_depth + HEIGHT * fy
        if bottom_depth < NEAREST or top_depth < NEAREST:
            continue
        bottom = (x * ux - ey * uy + z * uz) / (bottom_depth * view[3])
        top = (x * ux + (HEIGHT - ey) * uy + z * uz) / (top_depth * view[3])
        first = max(math.floor((middle - radius + 1.0) * 0.5 * COLUMNS), 0)
        last = min(math.floor((middle + radius + 1.0) * 0.5 * COLUMNS), COLUMNS - 1)
        whole, visible = 0.0, 0.0
        for column in range(first, last + 1):
            whole += top - bottom
            visible += max(top - max(bottom, horizon[column]), 0.0)
            if number == 0 and not chosen[i]:
                out[4] += max(min(top, 1.0) - max(bottom, horizon[column], -1.0), 0.0) / (2.0 * COLUMNS)
            horizon[column] = max(horizon[column], top)
        if not chosen[i]:
            continue
        number += 1
        share = visible / whole if whole > 0.0 else 0.0
        seen += share
        least = min(least, share)
        away = max(math.hypot(x, z), 1e-9)
        faces -= (math.sin(heading[i]) * x + math.cos(heading[i]) * z) / away
        if visible > 0.0:
            area += visible
            spread += visible * math.log(visible)
    if number == 0:
        return
    out[0], out[1], out[3] = seen / number, least, faces / number
    if number == 1:
        out[2] = out[0]
    elif area > 0.0:
        out[2] = (math.log(area) - spread / area) / math.log(number)


@kernel("f8(f8[::1],f8[:,::1],b1[::1],f8,f8)")
def keep_clear(eye: Float64, place: Float64, there: Bool, least: float, floor: float) -> float:
    """Move an eye (x, y, z) [m] out of all bodies, and above the floor; return how far it has been moved [m].

    Below `HEIGHT` + `least` it keeps `least` [m] from each axis: it is pushed to the side, or above all heads where
    there is no room.
    """
    x, y, z = eye[0], eye[1], eye[2]
    eye[1] = max(eye[1], floor)
    if eye[1] < HEIGHT + least:
        for turn in range(8):
            moved = False
            for i in range(len(place)):
                if not there[i]:
                    continue
                dx, dz = eye[0] - place[i, 0], eye[2] - place[i, 1]
                away = math.hypot(dx, dz)
                if away >= least - 1e-9:
                    continue
                if away < 1e-6:
                    dx, dz, away = 0.0, 1.0, 1.0
                eye[0], eye[2] = place[i, 0] + dx * least / away, place[i, 1] + dz * least / away
                moved = True
            if not moved:
                break
            if turn == 7:
                eye[1] = HEIGHT + least
    return math.sqrt((eye[0] - x) ** 2 + (eye[1] - y) ** 2 + (eye[2] - z) ** 2)


@kernel("void(f8[::1],f8[::1],f8[::1],f8,f8)")
def spring(value: Float64, speed: Float64, goal: Float64, stiffness: float, seconds: float) -> None:
    """Move values and their speeds towards a goal, critically damped: exact for a goal that stands (Lowe 2004)."""
    damp = math.exp(-stiffness * seconds)
    for i in range(len(value)):
        off = value[i] - goal[i]
        pull = (speed[i] + stiffness * off) * seconds
        value[i] = goal[i] + (off + pull) * damp
        speed[i] = (speed[i] - stiffness * pull) * damp
