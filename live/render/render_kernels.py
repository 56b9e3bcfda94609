"""Kernels of the renderer: pose texels, limb tips, culling, level-of-detail lists and their skins."""

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

VISIBLE = 1
"""Visibility bits of a dancer: may be in the picture, …"""
MIRRORED = 2
"""… the mirror image in the floor may be, …"""
CASTING = 4
"""… the shadow may be, …"""
NEAR = 8
"""… the dancer gets the near body, or the far one, …"""
FAR = 16
PRESENT = 32
"""… the dancer is on the stage, …"""
CLOSE = 64
"""… the dancer gets the body for close-ups."""

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]
Uint8 = npt.NDArray[np.uint8]


@kernel("void(f4[:,:,::1], f4[:,:,::1], f4[:,::1], i4[::1], f4[:,:,::1])", fastmath={"contract"})
def pose_texels(position: Float32, rotation: Float32, rest: Float32, anchor: Int32, out: Float32) -> None:
    """Compute dual quaternions that transform the rest pose to each dancer's pose (Kavan et al. 2007).

    position (A, J, 3), rotation (A, J, 4) wxyz, rest (J, 3), anchor (D,): the joint with which each detail joint
    moves; out (H, B*2(J+D), 4): dancer a is in row a mod H from texel (a // H)*2(J+D) on; a joint takes two texels,
    the rotation (x, y, z, w) and the dual part (x, y, z, w). All is single precision: a plain 2.0 would make it
    double.
    """
    height = out.shape[0]
    joints = rest.shape[0]
    drawn = joints + anchor.shape[0]
    two = np.float32(2.0)
    half = np.float32(0.5)
    for a in range(position.shape[0]):
        first = (a // height) * 2 * drawn
        to = out[a % height, first : first + 2 * drawn].reshape(drawn, 8)
        turn = rotation[a]
        place = position[a]
        for j in range(joints):
            w = turn[j, 0]
            x = turn[j, 1]
            y = turn[j, 2]
            z = turn[j, 3]
            rx = rest[j, 0]
            ry = rest[j, 1]
            rz = rest[j, 2]
            # translation = position - rotation(rest); v + 2w(u x v) + 2u x (u x v)
            cx = y * rz - z * ry
            cy = z * rx - x * rz
            cz = x * ry - y * rx
            tx = place[j, 0] - (rx + two * (w * cx + y * cz - z * cy))
            ty = place[j, 1] - (ry + two * (w * cy + z * cx - x * cz))
            tz = place[j, 2] - (rz + two * (w * cz + x * cy - y * cx))
            to[j, 0] = x
            to[j, 1] = y
            to[j, 2] = z
            to[j, 3] = w
            to[j, 4] = half * (tx * w + ty * z - tz * y)
            to[j, 5] = half * (ty * w + tz * x - tx * z)
            to[j, 6] = half * (tz * w + tx * y - ty * x)
            to[j, 7] = -half * (tx * x + ty * y + tz * z)
        for d in range(anchor.shape[0]):
            to[joints + d] = to[anchor[d]]


@kernel("void(f4[:,:,::1], f4[:,:,::1], b1[::1], i4[::1], f4[:,::1], f4[:,:,::1])")
def limb_tips(position: Float32, rotation: Float32, present: Bool, joint: Int32, offset: Float32, out: Float32) -> None:
    """Compute points attached to joints: `offset` (L, 3) from `joint` (L,) in the rest pose's axes.

    position (A, J, 3), rotation (A, J, 4) wxyz, present (A,); out (A or more, L, 4): point, and 1 if present, else 0.
    """
    for a in range(position.shape[0]):
        for k in range(joint.shape[0]):
            j = joint[k]
            w = rotation[a, j, 0]
            x = rotation[a, j, 1]
            y = rotation[a, j, 2]
            z = rotation[a, j, 3]
            ox = offset[k, 0]
            oy = offset[k, 1]
            oz = offset[k, 2]
            cx = y * oz - z * oy
            cy = z * ox - x * oz
            cz = x * oy - y * ox
            out[a, k, 0] = position[a, j, 0] + ox + 2.0 * (w * cx + y * cz - z * cy)
            out[a, k, 1] = position[a, j, 1] + oy + 2.0 * (w * cy + z * cx - x * cz)
            out[a, k, 2] = position[a, j, 2] + oz + 2.0 * (w * cz + x * cy - y * cx)
            out[a, k, 3] = 1.0 if present[a] else 0.0


@kernel("void(f4[:,:,::1], b1[::1], f4[:,::1], f4[::1], f4, u1[::1])")
def cull_dancers(position: Float32, present: Bool, planes: Float32, light: Float32, radius: float, out: Uint8) -> None:
    """Frustum culling of dancers, their mirror images and their shadows, with a sphere around each dancer's hips.

    position (A, J, 3), present (A,); planes (P, 4): a visible point p has n . p + d >= 0 for all of them, n unit
    vectors; light (3,): from the stage to the key light; `radius` of the sphere [m]. out (A,): bits of SEEN, MIRRORED,
    CASTING, PRESENT. The test is conservative (Assarsson and Möller 2000: planes alone never cull a visible object).
    """
    wide = radius / light[1]
    for a in range(position.shape[0]):
        if not present[a]:
            out[a] = 0
            continue
        x = position[a, 0, 0]
        y = position[a, 0, 1]
        z = position[a, 0, 2]
        # the shadow on the floor starts below the light's projection of the hips and is stretched by a low light
        drop = max(y, np.float32(0.0)) / light[1]
        sx = x - light[0] * drop
        sz = z - light[2] * drop
        seen = True
        mirrored = True
        shadowing = True
        for p in range(planes.shape[0]):
            level = planes[p, 0] * x + planes[p, 2] * z + planes[p, 3]
            seen = seen and level + planes[p, 1] * y >= -radius
            mirrored = mirrored and level - planes[p, 1] * y >= -radius
            shadowing = shadowing and planes[p, 0] * sx + planes[p, 2] * sz + planes[p, 3] >= -wide
        out[a] = PRESENT | (VISIBLE if seen else 0) | (MIRRORED if mirrored else 0) | (CASTING if shadowing else 0)


@inline_kernel
def _nth_smallest(values: Float32, count: int, at: int) -> np.float32:
    """Return the value at index `at` of the first `count` in sorted order; reorders them (Hoare 1961, FIND)."""
    low = 0
    high = count - 1
    while low < high:
        pivot = values[(low + high) // 2]
        i = low
        j = high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                kept = values[i]
                values[i] = values[j]
                values[j] = kept
                i += 1
                j -= 1
        if at <= j:
            high = j
        elif at >= i:
            low = i
        else:
            break
    found: np.float32 = values[at]
    return found


@inline_kernel
def _nearest_limit(scratch: Float32, count: int, wanted: int) -> np.float32:
    """Return a limit below which the `wanted` smallest of the first `count` values lie; reorders them."""
    limit = np.float32(np.inf)
    if wanted <= 0:
        limit = np.float32(-np.inf)
    elif wanted < count:
        limit = np.nextafter(_nth_smallest(scratch, count, wanted - 1), np.float32(np.inf))
    return limit


@kernel("void(f4[:,:,::1], f4[::1], f4, i8, f4, i8, u1[::1], f4[::1])")
def choose_detail(
    position: Float32,
    forward: Float32,
    near_to: float,
    near_count: int,
    close_to: float,
    close_count: int,
    visibility: Uint8,
    scratch: Float32,
) -> None:
    """Choose the body of each dancer: for close-ups, near, or far (bits CLOSE, NEAR and FAR of `visibility`).

    Near are the `near_count` nearest along `forward` (3,), and all whose distance along it is less than `near_to` [m].
    Close are those of the `close_count` nearest whose distance is less than `close_to` [m].
    position (A, J, 3), sight (A,), scratch (A or more,).
    """
    count = 0
    for a in range(position.shape[0]):
        if visibility[a] & VISIBLE:
            way = position[a, 0, 0] * forward[0] + position[a, 0, 1] * forward[1] + position[a, 0, 2] * forward[2]
            scratch[count] = way
            count += 1
    limit = max(np.float32(near_to), _nearest_limit(scratch, count, near_count))
    closest = min(np.float32(close_to), _nearest_limit(scratch, count, close_count))
    for a in range(position.shape[0]):
        way = position[a, 0, 0] * forward[0] + position[a, 0, 1] * forward[1] + position[a, 0, 2] * forward[2]
        visibility[a] |= CLOSE if way < closest else NEAR if way < limit else FAR


@inline_kernel
def _count_skins(lists: int, piece: Int32, skin_bits: Int32, vertices: Int32, places: Int32) -> None:
    """Count a dancer in the skins of all kinds of their pieces."""
    for s in range(vertices.shape[0]):
        if lists & skin_bits[s]:
            for p in range(piece.shape[0]):
                if piece[p] >= 0 and vertices[s, piece[p]] > 0:
                    places[s, piece[p], 0] += 1


@inline_kernel
def _lay_out_skins(first_vertex: Int32, vertices: Int32, width: int, places: Int32, rows: Int32) -> int:
    """Replace the numbers in `places` by the first texel and the first place in the list of each skin; return rows."""
    row = 0
    listed = 0
    for s in range(vertices.shape[0]):
        for k in range(vertices.shape[1]):
            number = places[s, k, 0]
            places[s, k, 0] = row * width
            places[s, k, 1] = listed
            used = -(-number * vertices[s, k] // width)
            for r in range(used):
                rows[row + r, 0] = first_vertex[s, k]
                rows[row + r, 1] = vertices[s, k]
                rows[row + r, 2] = r * width
                rows[row + r, 3] = listed
            row += used
            listed += number
    return row


@inline_kernel
def _list_piece(
    dancer: int, kind: int, lists: int, skin_of: Int32, vertices: Int32, places: Int32, out: Int32, counts: Int32
) -> None:
    """Put a dancer's piece on all lists that draw it."""
    for at in range(skin_of.shape[0]):
        s = skin_of[at]
        if lists >> at & 1 and (s < 0 or vertices[s, kind] > 0):
            out[at, kind, counts[at, kind], 0] = dancer
            out[at, kind, counts[at, kind], 1] = places[s, kind, 0] if s >= 0 else 0
            counts[at, kind] += 1


@inline_kernel
def _list_skin(
    dancer: int, kind: int, lists: int, skin_bits: Int32, vertices: Int32, places: Int32, skinned: Int32
) -> None:
    """Put a dancer's piece into all of its skins."""
    for s in range(skin_bits.shape[0]):
        if lists & skin_bits[s] and vertices[s, kind] > 0:
            places[s, kind, 0] += vertices[s, kind]
            skinned[places[s, kind, 1]] = dancer
            places[s, kind, 1] += 1


@kernel(
    "i8(u1[::1], i4[::1], i4[:,::1], i4[::1], i4[::1], i4[::1], i4[::1], i4[:,::1], i4[:,::1], i8, i4[:,:,:,::1],"
    " i4[:,::1], i4[::1], i4[:,:,::1], i4[::1], i4[:,::1])"
)
def fill_lists(
    visibility: Uint8,
    group: Int32,
    piece: Int32,
    list_bits: Int32,
    allowed: Int32,
    skin_of: Int32,
    skin_bits: Int32,
    first_vertex: Int32,
    vertices: Int32,
    width: int,
    out: Int32,
    counts: Int32,
    lists: Int32,
    places: Int32,
    skinned: Int32,
    rows: Int32,
) -> int:
    """Fill the lists of dancers to draw, by piece, and lay out the texture of their skinned vertices; return its rows.

    A dancer is drawn in pieces (body, head, hair), each of some kind. A piece has a *skin* for each level of detail in
    which any list draws it, once for all of those lists.

    visibility (A,): bits; group (A or more,); piece (A or more, P): kinds of each dancer's pieces, -1: none; list_bits
    (G,): bit l is set if a group's dancers are on list l; allowed (128,): for each visibility the bits of the lists
    that it allows; skin_of (L,): skin that list l draws, -1: none; skin_bits (S,): bits of the lists that draw skin s;
    first_vertex, vertices (S, K): place of the first vertex of that skin's mesh of a kind, and their number; width of
    the texture.

    out (L, K, A or more, 2): numbers of dancers, and the texel of the first vertex of their skin; counts (L, K); lists
    (A or more,) and places (S, K, 2) are scratch; skinned (S P A or more,): the dancers of all skins; rows (R, 4): for
    each row of the texture the first vertex in the mesh, the number of vertices, the number of vertices of the same
    skin and kind in earlier rows, and the place of their first dancer in `skinned`.
    """
    places[:] = 0
    counts[:] = 0
    for a in range(visibility.shape[0]):
        lists[a] = list_bits[group[a] % list_bits.shape[0]] & allowed[visibility[a]]
        _count_skins(lists[a], piece[a], skin_bits, vertices, places)
    row = _lay_out_skins(first_vertex, vertices, width, places, rows)
    for a in range(visibility.shape[0]):
        for p in range(piece.shape[1]):
            if piece[a, p] >= 0:
                _list_piece(a, piece[a, p], lists[a], skin_of, vertices, places, out, counts)
                _list_skin(a, piece[a, p], lists[a], skin_bits, vertices, places, skinned)
    return row


@kernel("void(f4[:,:,::1], u1[::1], i8, f4[:,::1])")
def bounding_box(position: Float32, visibility: Uint8, bit: int, out: Float32) -> None:
    """Compute the box around all joints of dancers with a bit of visibility: out (2, 3), lowest and highest x, y, z;
    lowest above highest if there are none. position (A, J, 3), visibility (A,)."""
    x0 = y0 = z0 = np.float32(np.inf)
    x1 = y1 = z1 = np.float32(-np.inf)
    for a in range(visibility.shape[0]):
        if visibility[a] & bit:
            for j in range(position.shape[1]):
                x = position[a, j, 0]
                y = position[a, j, 1]
                z = position[a, j, 2]
                x0 = x if x < x0 else x0
                y0 = y if y < y0 else y0
                z0 = z if z < z0 else z0
                x1 = x if x > x1 else x1
                y1 = y if y > y1 else y1
                z1 = z if z > z1 else z1
    out[0, 0], out[0, 1], out[0, 2] = x0, y0, z0
    out[1, 0], out[1, 1], out[1, 2] = x1, y1, z1
