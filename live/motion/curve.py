"""Monotone curves through keys in musical time, and filters over samples, for sketched motion.

Slopes are monotone (Fritsch and Butland 1984): a curve passes through its keys without overshoot, is flat where a key
is an extreme, and stays constant between two equal keys.
"""

import numpy as np

from live.base.arrays import Float


def smoothstep(share: Float) -> Float:
    """Return an eased share, with level ends; `share` is limited to 0 to 1 first."""
    share = np.clip(share, 0.0, 1.0)
    return np.asarray(share * share * (3.0 - 2.0 * share))


def monotone_slopes(times: Float, values: Float) -> Float:
    """Return slopes (K, ...) of the shape-preserving cubic through `values` (K, ...) at `times` (K,); 0 at both
    ends."""
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


def hermite(times: Float, values: Float, slopes: Float, at_times: Float) -> Float:
    """Evaluate the C1 cubic with `values` and `slopes` (K, ...) at increasing `times` (K,) `at_times` (T,); constant
    outside."""
    if len(times) == 1:
        return np.broadcast_to(values[0], (*at_times.shape, *values.shape[1:])).copy()
    left = np.clip(np.searchsorted(times, at_times, side="right") - 1, 0, len(times) - 2)
    span = times[left + 1] - times[left]
    u = np.clip((at_times - times[left]) / span, 0.0, 1.0)
    shape = (-1, *([1] * (values.ndim - 1)))
    rise = u * u * (3.0 - 2.0 * u)
    leave, arrive = u * (1.0 - u) ** 2 * span, u * u * (u - 1.0) * span
    return np.asarray(
        (1.0 - rise).reshape(shape) * values[left]
        + rise.reshape(shape) * values[left + 1]
        + leave.reshape(shape) * slopes[left]
        + arrive.reshape(shape) * slopes[left + 1]
    )


def interpolate(times: Float, values: Float, at_times: Float) -> Float:
    """Evaluate the monotone curve through `values` (K, ...) at increasing `times` (K,) `at_times` (T,)."""
    return hermite(times, values, monotone_slopes(times, values), at_times)


def repeat_keys(times: Float, values: Float, period: float, drift: float, at_times: Float) -> tuple[Float, Float]:
    """Repeat keys (K,) every `period` so that they cover `at_times` with two cycles to spare at either end.

    Values increase by `drift` per cycle.
    """
    first = int(np.floor((at_times[0] - times[-1]) / period)) - 2
    last = int(np.ceil((at_times[-1] - times[0]) / period)) + 2
    cycles = np.arange(first, last + 1)
    long_times = (times[None] + period * cycles[:, None]).ravel()
    long_values = (values[None] + drift * cycles[:, None]).ravel()
    return long_times, long_values


def filter_samples(samples: Float, weights: Float, lead_count: int) -> Float:
    """Return `samples` (T, ...) averaged along time with `weights` (n,), `lead_count` of them for earlier samples.

    End values are repeated. The filter is time-invariant, so exactly periodic input gives exactly periodic output.
    """
    flat = samples.reshape(len(samples), -1)
    after = len(weights) - 1 - lead_count
    padded = np.concatenate((np.repeat(flat[:1], lead_count, axis=0), flat, np.repeat(flat[-1:], after, axis=0)))
    windows = np.lib.stride_tricks.sliding_window_view(padded, len(weights), axis=0)
    return np.asarray(windows @ weights).reshape(samples.shape)


def gaussian_filter(samples: Float, sigma: float) -> Float:
    """Apply a zero-delay Gaussian low-pass to `samples` (T, ...) along time; `sigma` in samples."""
    half = max(int(np.ceil(3.0 * sigma)), 1)
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / sigma) ** 2)
    return filter_samples(samples, weights / weights.sum(), half)


def spring_response(samples: Float, period: float, damping: float) -> Float:
    """Return the response of a damped spring of natural `period` [samples] that follows `samples` (T, ...).

    The result lags and overshoots.
    """
    count = int(np.ceil(1.5 * period))
    angle = np.arange(count) * (2.0 * np.pi / period)
    response = np.exp(-damping * angle) * np.sin(np.sqrt(1.0 - damping * damping) * angle)
    return filter_samples(samples, (response / response.sum())[::-1], count - 1)


def soft_min(a: Float, b: Float, width: float) -> Float:
    """Return a smooth function never above `a` or `b`, within `width` / 2 of the smaller one."""
    return np.asarray(0.5 * (a + b - np.sqrt((a - b) ** 2 + width * width)))
