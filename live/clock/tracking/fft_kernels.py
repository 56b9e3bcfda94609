"""Kernel for the fast Fourier transform of a real signal: mixed radix, self-sorting (Stockham), with precomputed
tables."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel

Floats = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]


@inline_kernel
def _pass_of_four(
    re: Floats, im: Floats, to_re: Floats, to_im: Floats, turn_re: Floats, turn_im: Floats, length: int, stride: int
) -> None:
    quarter = length // 4
    for place in range(quarter):
        one_re, one_im = turn_re[place * stride], turn_im[place * stride]
        two_re, two_im = turn_re[2 * place * stride], turn_im[2 * place * stride]
        three_re, three_im = turn_re[3 * place * stride], turn_im[3 * place * stride]
        at, to = place * stride, 4 * place * stride
        step = quarter * stride
        for lane in range(stride):
            a_re, a_im = re[at + lane], im[at + lane]
            b_re, b_im = re[at + lane + step], im[at + lane + step]
            c_re, c_im = re[at + lane + 2 * step], im[at + lane + 2 * step]
            d_re, d_im = re[at + lane + 3 * step], im[at + lane + 3 * step]
            even_re, even_im, odd_re, odd_im = a_re + c_re, a_im + c_im, b_re + d_re, b_im + d_im
            left_re, left_im, right_re, right_im = a_re - c_re, a_im - c_im, b_im - d_im, d_re - b_re
            to_re[to + lane] = even_re + odd_re
            to_im[to + lane] = even_im + odd_im
            x, y = left_re + right_re, left_im + right_im
            to_re[to + lane + stride] = x * one_re - y * one_im
            to_im[to + lane + stride] = x * one_im + y * one_re
            x, y = even_re - odd_re, even_im - odd_im
            to_re[to + lane + 2 * stride] = x * two_re - y * two_im
            to_im[to + lane + 2 * stride] = x * two_im + y * two_re
            x, y = left_re - right_re, left_im - right_im
            to_re[to + lane + 3 * stride] = x * three_re - y * three_im
            to_im[to + lane + 3 * stride] = x * three_im + y * three_re


@inline_kernel
def _pass_of_any(
    re: Floats,
    im: Floats,
    to_re: Floats,
    to_im: Floats,
    turn_re: Floats,
    turn_im: Floats,
    length: int,
    stride: int,
    radix: int,
) -> None:
    share = length // radix
    whole = length * stride
    for place in range(share):
        for out in range(radix):
            to = (radix * place + out) * stride
            for lane in range(stride):
                to_re[to + lane] = np.float32(0.0)
                to_im[to + lane] = np.float32(0.0)
            for index in range(radix):
                turn = (index * out * (whole // radix) + place * out * stride) % whole
                cos, sin = turn_re[turn], turn_im[turn]
                at = (place + share * index) * stride
                for lane in range(stride):
                    to_re[to + lane] += re[at + lane] * cos - im[at + lane] * sin
                    to_im[to + lane] += re[at + lane] * sin + im[at + lane] * cos


@kernel("void(f4[::1],f4[::1],i4[::1],f4[::1],f4[::1],f4[::1],f4[::1],f4[:,::1],f4[::1])")
def magnitudes(
    history: Floats,
    window: Floats,
    radices: Ints,
    turn_re: Floats,
    turn_im: Floats,
    half_re: Floats,
    half_im: Floats,
    work: Floats,
    out: Floats,
) -> None:
    """Compute the magnitudes of the first bins, shape (K,), of the newest W samples of `history` times `window` (W,).

    The signal is padded with zeros to 2 H samples, H the product of `radices`; even and odd samples are the real and
    imaginary parts of H numbers. turn (H,) are the roots e^(-2πi k/H), half (H,) are e^(-πi k/H), work (4, H).
    """
    half = turn_re.shape[0]
    re, im, to_re, to_im = work[0], work[1], work[2], work[3]
    length = window.shape[0]
    first = history.shape[0] - length
    for index in range(length // 2):
        re[index] = history[first + 2 * index] * window[2 * index]
        im[index] = history[first + 2 * index + 1] * window[2 * index + 1]
    for index in range(length // 2, half):
        re[index] = np.float32(0.0)
        im[index] = np.float32(0.0)
    if length % 2 == 1:
        re[length // 2] = history[first + length - 1] * window[length - 1]
    remaining, stride = half, 1
    for radix in radices:
        if radix == 4:
            _pass_of_four(re, im, to_re, to_im, turn_re, turn_im, remaining, stride)
        else:
            _pass_of_any(re, im, to_re, to_im, turn_re, turn_im, remaining, stride, radix)
        re, im, to_re, to_im = to_re, to_im, re, im
        remaining //= radix
        stride *= radix
    for bin_ in range(out.shape[0]):
        here, there = bin_ % half, (half - bin_) % half
        even_re, even_im = re[here] + re[there], im[here] - im[there]
        odd_re, odd_im = im[here] + im[there], re[there] - re[here]
        x = even_re + odd_re * half_re[here] - odd_im * half_im[here]
        y = even_im + odd_re * half_im[here] + odd_im * half_re[here]
        out[bin_] = np.float32(0.5) * math.sqrt(x * x + y * y)
