"""Kernels of the bar pointer: state transition, observation, and histograms of states by tempo and phase."""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import kernel
from live.clock.bar_pointer.metre import FIRST_SLOT, METRES, NEXT, PREVIOUS, SLOTS, USED

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

_SLOTS, _USED = SLOTS, USED
LEAST = np.float32(1e-30)
"""Smaller values become 0: denormal numbers are slow."""
_FENCE, _FENCE_TEMPO = 0.25, 1.15
"""States further away than this many beats, or this ratio of tempi, belong to another grid."""
_BINS = 24
"""Phase bins of a beat in `histogram`."""
_NEXT, _PREVIOUS = NEXT, PREVIOUS
_FIRST = np.array(FIRST_SLOT)
_LAST = PREVIOUS[_FIRST]
_METRES = len(METRES)


@kernel(
    "f8(f4[:,::1], i4[::1], i4[::1], i4[::1], f4[:,::1], f4[:,::1], f4[::1], f4[::1], f4[:,::1], f4[:,::1], f4, f8)"
)
def advance(
    state: Float32,
    head: Int32,
    offset: Int32,
    length: Int32,
    tempo: Float32,
    metre: Float32,
    births: Float32,
    slot_share: Float32,
    leaving: Float32,
    entering: Float32,
    odds: np.float32,
    sum_before: float,
) -> float:
    """Advance all states by one frame: each position moves on; at the end of a beat another begins, perhaps at another
    tempo.

    `sum_before` is the sum of all states; births are relative to it. Returns the new sum.

    state (N, S): shares of all states, a ring of length[k] rows for interval k from row offset[k] on, position 0 at
    head[k]. tempo (K, 2R+1) and metre (M, M): transitions, see Model; born (K,) new grids that begin in this frame;
    leaving, entering (K, S): scratch. odds: [0, 1) probability that a beat is any other of its metre.
    """
    intervals, reach = length.shape[0], tempo.shape[1] // 2
    zero, one = np.float32(0.0), np.float32(1.0)
    slots = np.zeros(_SLOTS, np.float32)
    scale, gone, begun = np.float32(sum_before), 0.0, 0.0
    for k in range(intervals):
        head[k] = head[k] - 1 if head[k] > 0 else length[k] - 1
        row = offset[k] + head[k]
        for s in range(_SLOTS):
            leaving[k, s] = state[row, s]
            gone += float(state[row, s])
            entering[k, s] = zero
    for k in range(intervals):
        for step in range(2 * reach + 1):
            other = k + step - reach
            share = tempo[k, step]
            if share > zero:
                for s in range(_SLOTS):
                    entering[other, s] += share * leaving[k, s]
    for k in range(intervals):
        row = offset[k] + head[k]
        total = zero
        for s in range(_SLOTS):
            total += entering[k, s]
            slots[s] = entering[k, _PREVIOUS[s]]
        for to in range(_METRES):
            begun_here = zero
            for of in range(_METRES):
                begun_here += entering[k, _LAST[of]] * metre[of, to]
            slots[_FIRST[to]] = begun_here
        for s in range(_SLOTS):  # those not in use stay 0
            state[row, s] = (one - odds) * slots[s] + (odds * total + scale * births[k]) * slot_share[s]
            begun += float(state[row, s])
    return sum_before - gone + begun


@kernel("f8(f4[:,::1], i4[::1], i4[::1], i4[::1], i4[::1], f4[::1], f4[:,::1])")
def change_octave(
    state: Float32, head: Int32, offset: Int32, length: Int32, partner: Int32, slot_share: Float32, odds: Float32
) -> float:
    """Move a share of the beats that begin now to half or double the tempo. Returns the growth of the sum.

    Called after `advance`. partner (2 K,): the interval of half and of double the tempo, -1 if there is none;
    odds (K, 2): the probability of each.
    """
    grown = 0.0
    for k in range(length.shape[0]):
        row = offset[k] + head[k]
        for way in range(2):
            other = partner[2 * k + way]
            if other >= 0 and odds[k, way] > np.float32(0.0):
                total = np.float32(0.0)
                for s in range(_USED):
                    total += state[row, s]
                total *= odds[k, way]
                beside = offset[other] + head[other]
                for s in range(_USED):
                    state[beside, s] += total * slot_share[s]
                grown += float(total)
    return grown


@kernel("f8(f4[:,::1], i4[::1], i4[::1], i4[::1], f4[::1], f4[::1], f4, f4, f4)", fastmath={"reassoc"})
def observe(
    state: Float32,
    head: Int32,
    offset: Int32,
    length: Int32,
    window: Float32,
    accent: Float32,
    beat: np.float32,
    downbeat: np.float32,
    between: np.float32,
) -> float:
    """Multiply the states in whose beat window this frame lies by their likelihoods.

    By `beat`, and as far as a slot is accented by `downbeat`: likelihoods relative to a frame without a beat;
    `between` is that of a frame half way between beats. window (W,): weight of each position; accent (S,): how often
    each slot sounds like a downbeat. Returns the growth of the sum of all states.
    """
    one, grown = np.float32(1.0), 0.0
    width = window.shape[0]
    gain = np.zeros(_SLOTS, np.float32)
    factors = np.zeros(_SLOTS, np.float32)
    for s in range(_SLOTS):
        gain[s] = beat + accent[s] * (downbeat - beat) - one
    for k in range(length.shape[0]):
        for p in range(width):
            at = head[k] + p
            row = offset[k] + (at - length[k] if at >= length[k] else at)
            for s in range(_SLOTS):
                factors[s] = one + window[p] * gain[s]
            before = after = np.float32(0.0)
            for s in range(_SLOTS):
                before += state[row, s]
                state[row, s] *= factors[s]
                after += state[row, s]
            grown += float(after) - float(before)
        if between != one:
            for p in range(width):
                at = head[k] + p + length[k] // 2
                row = offset[k] + (at - length[k] if at >= length[k] else at)
                factor = one + window[p] * (between - one)
                before = np.float32(0.0)
                for s in range(_SLOTS):
                    before += state[row, s]
                    state[row, s] *= factor
                grown += float(before * (factor - one))
    return grown


@kernel("void(f4[:,::1], i4[::1], i4[::1], i4[::1], f8, f8)")
def clear_distant(state: Float32, head: Int32, offset: Int32, length: Int32, interval: float, phase: float) -> None:
    """Set all states to 0 that are further than `_FENCE` beats from a phase, or at tempi not near `interval`."""
    zero = np.float32(0.0)
    for k in range(length.shape[0]):
        n = length[k]
        apart = n > interval * _FENCE_TEMPO or n * _FENCE_TEMPO < interval
        for p in range(n):
            off = p / n - phase
            off -= math.floor(off + 0.5)
            if apart or abs(off) > _FENCE:
                at = head[k] + p
                row = offset[k] + (at - n if at >= n else at)
                for s in range(_SLOTS):
                    state[row, s] = zero


@kernel("void(f4[:,::1], i4[::1], i4[::1], i4[::1], f8, f8, f8, f4[::1])")
def weigh_slots(
    state: Float32, head: Int32, offset: Int32, length: Int32, interval: float, phase: float, width: float,
    factors: Float32,
) -> None:  # fmt: skip
    """Multiply the slots of the states near a grid by `factors`, shape (S,): within `width` (ratio) of `interval`, and
    within `_FENCE` beats of `phase`, which is not so near to the end of the beat."""
    for k in range(length.shape[0]):
        n = length[k]
        if abs(n / interval - 1.0) > width:
            continue
        for p in range(n):
            if abs(p / n - phase) > _FENCE:
                continue
            at = head[k] + p
            row = offset[k] + (at - n if at >= n else at)
            for s in range(_SLOTS):
                state[row, s] *= factors[s]


@kernel("f8(f4[:,::1], i4[::1], i4[::1], i4[::1], f4[:,::1])", fastmath={"reassoc"})
def phase_histogram(state: Float32, head: Int32, offset: Int32, length: Int32, histogram: Float32) -> float:
    """Sum all states by interval and phase of the beat: histogram (K, 24). Returns the total."""
    total = 0.0
    for k in range(length.shape[0]):
        n = length[k]
        row, last = offset[k] + head[k], offset[k] + n
        begin = 0
        for b in range(_BINS):
            end = ((b + 1) * n) // _BINS
            count = np.float32(0.0)
            for _ in range(begin, end):
                row_count = np.float32(0.0)
                for s in range(_SLOTS):
                    row_count += state[row, s]
                count += row_count
                row = row + 1 if row + 1 < last else offset[k]
            begin = end
            histogram[k, b] = count
            total += float(count)
    return total


@kernel("void(f4[:,::1], i4[::1], i4[:,::1], f8[:,::1], f8, f8, f8, i8, f8[::1])")
def search(
    histogram: Float32,
    length: Int32,
    near: Int32,
    boxes: Float64,
    interval: float,
    phase: float,
    width: float,
    side: int,
    found: Float64,
) -> None:
    """Find the strongest grid, and the share of states near the present one.

    The share of a grid covers the intervals near[k, 0] ... near[k, 1] - 1 and ± `side` bins of its phase. found
    gets (interval, phase, share there, share within ± `width` (ratio) and ± `side` bins of (interval, phase)).
    boxes (K + 1, 24): scratch.
    """
    intervals = length.shape[0]
    present = 0.0
    for b in range(_BINS):
        boxes[0, b] = 0.0
    for k in range(intervals):
        for b in range(_BINS):
            share = 0.0
            for c in range(b - side, b + side + 1):
                share += histogram[k, c + _BINS if c < 0 else (c - _BINS if c >= _BINS else c)]
            boxes[k + 1, b] = boxes[k, b] + share
    best, best_k, best_b = -1.0, 0, 0
    for k in range(intervals):
        for b in range(_BINS):
            share = boxes[near[k, 1], b] - boxes[near[k, 0], b]
            if share > best:
                best, best_k, best_b = share, k, b
    if interval > 0.0:
        here = int(phase * _BINS) % _BINS
        for k in range(intervals):
            if abs(length[k] / interval - 1.0) <= width:
                present += boxes[k + 1, here] - boxes[k, here]
    found[0], found[1] = float(length[best_k]), (best_b + 0.5) / _BINS
    found[2], found[3] = best, present


@kernel("void(f4[:,::1], i4[::1], i4[::1], i4[::1], f8, f8, f8, f8, f8[::1], f8[::1])")
def refine(
    state: Float32,
    head: Int32,
    offset: Int32,
    length: Int32,
    interval: float,
    phase: float,
    width: float,
    spread: float,
    found: Float64,
    slots: Float64,
) -> None:
    """Compute means over the states near a grid: found gets (interval, phase correction in beats, share).

    slots (S,): the share of each slot among them.
    """
    total = sum_interval = sum_off = 0.0
    for s in range(_SLOTS):
        slots[s] = 0.0
    for k in range(length.shape[0]):
        n = length[k]
        if abs(n / interval - 1.0) > width:
            continue
        for p in range(n):
            off = p / n - phase
            turn = math.floor(off + 0.5)
            off -= turn
            if abs(off) > spread:
                continue
            at = head[k] + p
            row = offset[k] + (at - n if at >= n else at)
            share = 0.0
            for s in range(_USED):
                share += state[row, s]
            total += share
            sum_interval += share * n
            sum_off += share * off
            # States past the line while the centre is before it (or the other way round) belong to another beat.
            for s in range(_USED):
                slots[_NEXT[s] if turn > 0.0 else (_PREVIOUS[s] if turn < 0.0 else s)] += state[row, s]
    found[2] = total
    if total > 0.0:
        found[0], found[1], found[2] = sum_interval / total, sum_off / total, total
        for s in range(_SLOTS):
            slots[s] /= total
