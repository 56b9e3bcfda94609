"""Curves through keys in musical time, and filters over samples: the softness of a sketch's motion.

Keys are places that are reached, not pulled at: slopes are monotone (Fritsch and Butland 1984), so a curve never
passes beyond its keys, rests flat where a key is an extreme, and holds where two keys are equal.
"""

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.floating]


def monotone_slopes(times: Float, values: Float) -> Float:
    """Slopes at the keys (K, ...) of the shape-preserving cubic through `values` (K, ...) at `times` (K,); ends 0."""
    slopes = np.zeros_like(values)
    if len(times) < 3:
        return slopes
    span = np.diff(times).reshape(-1, *([1] * (values.ndim - 1)))
    rate = np.diff(values, axis=0) / span
    before, after = rate[:-1], rate[1:]
    same = before * after > 0.0
    weight_before, weight_after = 2.0 * span[1:] + span[:-1], span[1:] + 2.0 * span[:-1]
    total = weight_before + weight_after
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        mean = total / (weight_before / before + weight_after / after)
    slopes[1:-1] = np.where(same, mean, 0.0)
    return slopes


def hermite(times: Float, values: Float, slopes: Float, at: Float) -> Float:
    """The C1 cubic with `values` and `slopes` (K, ...) at increasing `times` (K,), read `at` (T,); flat outside."""
    if len(times) == 1:
        return np.broadcast_to(values[0], (*at.shape, *values.shape[1:])).copy()
    left = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    span = times[left + 1] - times[left]
    u = np.clip((at - times[left]) / span, 0.0, 1.0)
    shape = (-1, *([1] * (values.ndim - 1)))
    rise = u * u * (3.0 - 2.0 * u)
    leave, arrive = u * (1.0 - u) ** 2 * span, u * u * (u - 1.0) * span
    return np.asarray(
        (1.0 - rise).reshape(shape) * values[left]
        + rise.reshape(shape) * values[left + 1]
        + leave.reshape(shape) * slopes[left]
        + arrive.reshape(shape) * slopes[left + 1]
    )


def through(times: Float, values: Float, at: Float) -> Float:
    """The monotone curve through `values` (K, ...) at increasing `times` (K,), read `at` (T,)."""
    return hermite(times, values, monotone_slopes(times, values), at)


def repeated(times: Float, values: Float, period: float, drift: float, at: Float) -> tuple[Float, Float]:
    """Keys (K,) copied every `period` so that they cover `at` with two to spare; values rise by `drift` each time."""
    first = int(np.floor((at[0] - times[-1]) / period)) - 2
    last = int(np.ceil((at[-1] - times[0]) / period)) + 2
    cycles = np.arange(first, last + 1)
    long_times = (times[None] + period * cycles[:, None]).ravel()
    long_values = (values[None] + drift * cycles[:, None]).ravel()
    return long_times, long_values


def filtered(samples: Float, weights: Float, before: int) -> Float:
    """`samples` (T, ...) averaged along time with `weights` (n,), of which `before` stand on earlier samples.

    Ends are held. Being the same at every sample, a filter keeps exactly repeating what repeats exactly.
    """
    flat = samples.reshape(len(samples), -1)
    after = len(weights) - 1 - before
    padded = np.concatenate((np.repeat(flat[:1], before, axis=0), flat, np.repeat(flat[-1:], after, axis=0)))
    windows = np.lib.stride_tricks.sliding_window_view(padded, len(weights), axis=0)
    return np.asarray(windows @ weights).reshape(samples.shape)


def smoothed(samples: Float, sigma: float) -> Float:
    """Gaussian low-pass of `samples` (T, ...) along time without delay; `sigma` in samples."""
    half = max(int(np.ceil(3.0 * sigma)), 1)
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / sigma) ** 2)
    return filtered(samples, weights / weights.sum(), half)


def followed(samples: Float, period: float, damping: float) -> Float:
    """What hangs on `samples` (T, ...) by a damped spring of natural `period` [samples]: it lags and swings through."""
    count = int(np.ceil(1.5 * period))
    angle = np.arange(count) * (2.0 * np.pi / period)
    response = np.exp(-damping * angle) * np.sin(np.sqrt(1.0 - damping * damping) * angle)
    return filtered(samples, (response / response.sum())[::-1], count - 1)


def soft_min(a: Float, b: Float, width: float) -> Float:
    """A smooth function that is never above either of `a` and `b`, and differs from the lesser by < `width` / 2."""
    return np.asarray(0.5 * (a + b - np.sqrt((a - b) ** 2 + width * width)))
