"""Kernels for BVH: decimal numbers from bytes, and channels to translations and rotations."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel

UInt8 = npt.NDArray[np.uint8]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Int64 = npt.NDArray[np.int64]

_MAX_POWER = 44
"""10^44 = 2^44 · 5^44 is the largest power of ten that two doubles represent exactly."""
_POWERS = np.array([float(10**n) for n in range(_MAX_POWER + 1)])
_POWERS_REST = np.array([float(10**n - int(float(10**n))) for n in range(_MAX_POWER + 1)])
_MAX_EXACT_POWER = 22
"""10^22 is the largest power of ten that one double represents exactly."""
_MAX_EXACT_INTEGER = np.uint64(1 << 53)  # an int would be compared as a double
"""Integers up to this are exact as doubles."""
_SPLIT = 134217729.0  # 2^27 + 1 (Veltkamp)
_MAX_DIGITS = 19
"""This many digits always fit into 64 bits."""
_MANTISSA_LIMIT = np.uint64(10 ** (_MAX_DIGITS - 1))
"""A mantissa below this has room for one more digit."""
_MAX_LENGTH = 1000
"""Maximum characters of a number: reading one takes time quadratic in its length."""
_ZERO, _ONE, _TEN, _ZERO_CHARACTER = np.uint64(0), np.uint64(1), np.uint64(10), np.uint64(48)

COUNT, INVALID, OUT_OF_RANGE, INEXACT, WRONG_COUNT, WRONG_PLACE, WRONG_LAST, WRAPPED = range(8)
"""Entries of the result of `scan_numbers`."""


@kernel("f8(u8, i8)")
def scale_decimal(mantissa: np.uint64, exponent: np.int64) -> float:
    """Return mantissa · 10^exponent as the nearest double, or NaN if this needs more precision than available here.

    Up to 2^53 and 10^22 both factors are exact, so one operation rounds once (Clinger 1990). Beyond that, the quotient
    is corrected by its exact remainder (Dekker), and accepted if the error bound cannot change the rounding (Ziv).
    """
    if mantissa == 0:
        return 0.0
    if exponent < -_MAX_POWER or exponent > _MAX_EXACT_POWER:
        return math.nan
    high = float(mantissa)
    if mantissa <= _MAX_EXACT_INTEGER and exponent >= -_MAX_EXACT_POWER:
        return float(high * _POWERS[exponent] if exponent >= 0 else high / _POWERS[-exponent])
    if exponent >= 0:
        return math.nan
    power = _POWERS[-exponent]
    quotient = high / power
    a = quotient * _SPLIT
    a = a - (a - quotient)
    b = power * _SPLIT
    b = b - (b - power)
    product = quotient * power
    error = ((a * b - product) + a * (power - b) + (quotient - a) * b) + (quotient - a) * (power - b)
    near = np.uint64(high)
    lower = float(mantissa - near) if mantissa >= near else -float(near - mantissa)
    rest = (((high - product) - error) + (lower - quotient * _POWERS_REST[-exponent])) / power
    doubt = 1e-14 * abs(rest) + 1e-29 * quotient
    less, more = quotient + (rest - doubt), quotient + (rest + doubt)
    return float(less) if less == more else math.nan


@kernel("Tuple((u8, u8))(u1[::1], u8, u8)")
def _read_digits(text: UInt8, place: np.uint64, mantissa: np.uint64) -> tuple[np.uint64, np.uint64]:
    """Return the mantissa extended by the digits from `place` on (exact up to 19 digits), and where they end."""
    while text[place] >= 48 and text[place] <= 57:  # a chained comparison takes twice as long
        if mantissa < _MANTISSA_LIMIT:
            mantissa = mantissa * _TEN + (np.uint64(text[place]) - _ZERO_CHARACTER)
        place += _ONE
    return mantissa, place


@kernel("Tuple((f8, u8))(u1[::1], u8)")
def read_word(text: UInt8, begin: np.uint64) -> tuple[float, np.uint64]:
    """Return the number that begins at `begin` and where it ends; NaN if it needs more precision.

    The end equals `begin` if there is no number. The last byte of `text` must be whitespace.
    """
    place = begin
    negative = text[place] == 45
    if negative or text[place] == 43:
        place += _ONE
    mantissa, end = _read_digits(text, place, _ZERO)
    digits, exponent = np.int64(end - place), np.int64(0)
    if text[end] == 46:
        place = end + _ONE
        mantissa, end = _read_digits(text, place, mantissa)
        exponent = -np.int64(end - place)
        digits -= exponent
    hard = bool(digits > _MAX_DIGITS)
    if digits > 0 and (text[end] == 101 or text[end] == 69):
        place = end + _ONE
        minus = text[place] == 45
        if minus or text[place] == 43:
            place += _ONE
        power, end = _read_digits(text, place, _ZERO)
        digits = np.int64(end - place)
        hard = hard or bool(digits > _MAX_DIGITS or power > 1000)
        exponent += -np.int64(power) if minus else np.int64(power)
    if digits == 0 or not (text[end] == 32 or 9 <= text[end] <= 13) or end - begin > _MAX_LENGTH:
        return 0.0, begin
    value = math.nan if hard else scale_decimal(mantissa, exponent)
    return (-value if negative else value), end


@kernel("void(u1[::1], i8, f8[::1], i8[:,::1], i8[::1])")
def scan_numbers(text: UInt8, columns: int, values: Float64, inexact: Int64, result: Int64) -> None:
    """Read the numbers of `text` into `values`, up to its size, and check that lines hold whole frames.

    Lines end with LF, CR or both; `text` ends with a line end. Written to `result`: COUNT of numbers, place of a BAD
    word (-1: none; reading stops there), place of an OUT_OF_RANGE number (not within 1e7), count of INEXACT ones (index
    and place go to `inexact` (n, 2), up to its size); WRONG_COUNT, WRONG_PLACE (of its last word), WRONG_LAST (nothing
    follows) of the first line whose count is no multiple of `columns`; WRAPPED = 1 if each frame still begins a line.
    """
    place, last_word = _ZERO, _ZERO
    count, in_line, in_frame, hards = 0, 0, 0, 0
    result[:] = 0
    result[INVALID] = result[OUT_OF_RANGE] = -1
    result[WRAPPED] = 1
    size = np.uint64(text.size)
    while place < size:
        letter = text[place]
        if letter == 32 or 9 <= letter <= 13:
            place += _ONE
            if letter == 10 or letter == 13:
                if in_line % columns != 0 and result[WRONG_COUNT] == 0:
                    result[WRONG_COUNT], result[WRONG_PLACE], result[WRONG_LAST] = in_line, last_word, 1
                in_line = 0
            continue
        result[WRONG_LAST] = 0
        if in_frame == columns:
            in_frame = 0
            if in_line > 0:
                result[WRAPPED] = 0
        value, end = read_word(text, place)
        if end == place:
            result[INVALID] = place
            break
        if value != value:
            if hards < len(inexact):
                inexact[hards, 0], inexact[hards, 1] = count, place
            hards += 1
        elif abs(value) > 1e7 and result[OUT_OF_RANGE] < 0:
            result[OUT_OF_RANGE] = place
        if count < values.size:
            values[count] = value
        last_word, place = place, end
        count += 1
        in_line += 1
        in_frame += 1
    result[COUNT], result[INEXACT] = count, hards


@kernel('void(Array(f8, 2, "C", True), i4[:,::1], f8[:,::1], f8[:,:,::1], f8[:,:,::1])')
def pose_channels(values: Float64, channels: Int32, base: Float64, translation: Float64, rotation: Float64) -> None:
    """Convert channels of every frame (T, C) to translations (T, J, 3) and unit quaternions (T, J, 4).

    `channels` (C, 2) holds the joint and kind of each: 0-2 a position along x, y, z, added to `base` (J, 3), 3-5 a
    rotation about x, y, z [degrees], applied in file order: R = R1 R2 R3 (T163).
    """
    for frame in range(len(values)):
        for joint in range(len(base)):
            for axis in range(3):
                translation[frame, joint, axis] = base[joint, axis]
                rotation[frame, joint, axis + 1] = 0.0
            rotation[frame, joint, 0] = 1.0
        for channel in range(len(channels)):
            joint, kind = channels[channel, 0], channels[channel, 1]
            value = values[frame, channel]
            if kind < 3:
                translation[frame, joint, kind] = base[joint, kind] + value
                continue
            half = math.radians(value) * 0.5
            c, s = math.cos(half), math.sin(half)
            q = rotation[frame, joint]
            k = kind - 2
            i, j = k % 3 + 1, (k + 1) % 3 + 1
            w, along, first, second = q[0], q[k], q[i], q[j]
            q[0] = w * c - along * s
            q[k] = along * c + w * s
            q[i] = first * c + second * s
            q[j] = second * c - first * s
