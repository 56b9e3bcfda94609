"""Effort, mood, breath and blinks of all dancers' faces, advanced at ticks.

Breath follows exertion, and its phase the measures: in before the line, out through the phrase. Blinks come 15 to 20
times a minute, and with turns of head and gaze (Evinger et al. 1994, *Not looking while leaping: the linkage of
blinking and saccadic gaze shifts*).
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.body.expression import BREATH, MOUTH_OPEN
from live.base.body.expression import BROW as BROW_COLUMN
from live.base.body.expression import EFFORT as EFFORT_COLUMN
from live.base.body.expression import SMILE as SMILE_COLUMN
from live.base.jit import inline_kernel, kernel
from live.base.scalar_kernels import ease
from live.motion.expression.dance_kernels import ENERGY, TURN

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

(
    LEAD, EFFORT, EXERTION, BREATH_PHASE, BREATH_RATE, SACCADE_AGE, SACCADE_S, FIXATION, BLINK_AGE, NEXT_BLINK, SMILE,
    BROW, TARGET,
) = range(13)  # fmt: skip
"""Columns of `number`: the head's coming turn [rad]; effort, and effort over many seconds, 0 to 1; phase of the breath,
0 to 1, and its rate [1/s]; time since the last saccade, its length, and the time left to look there [s]; time since the
last blink and until the next one [s]; smile and brows, -1 to 1; the place looked at (x, y, z) [m] ..."""
LAST_TARGET = TARGET + 3
"""... and the one before."""
NUMBER_COLUMNS = LAST_TARGET + 3
KIND, OTHER, LAST_KIND, LAST_OTHER, DRAWS = range(5)
"""Columns of `choice`: what is looked at (`gaze_kernels`), a dancer, both before the last saccade, and the count of
random numbers used."""
CHOICE_COLUMNS = 5
DRAWS_A_TIME = 16
"""Random numbers that one decision may use."""
MOST_DRAWS = 0x3FFFFFF
LONG_AGO = 60.0
"""Longest time since anything that is counted [s]."""

LEAD_FILTER_S = 0.08
"""Time constant of the head's coming turn [s]: it is measured at every second tick."""
EFFORT_ENERGY = 0.35
"""Kinetic energy [J/kg] at which the effort is 1 - 1/e."""
RISE_S, FALL_S, EXERTION_S = 0.35, 1.1, 14.0
"""Time constants [s]: effort rises and falls; exertion follows it as breath and heart do."""
MOOD_S = 0.4
"""Time constant of smile and brows [s]."""
LEAST_BREATHS, MORE_BREATHS = 0.2, 0.45
"""Breaths per second at rest, and how many more in the hardest dance: 12 to 39 a minute."""
BREATH_S = 0.3
"""Time constant of the breath's rate [s]."""
OUT_SHARE = 0.62
"""Share of a breath that is breathed out."""
TURNING = math.radians(20.0)
"""A head that turns so far in `dance_kernels.LEAD_S` turns fast."""
BLINK_S = 0.24
"""Length of a blink [s]."""
LEAST_BLINK_GAP, MEAN_BLINK_GAP, MOST_BLINK_GAP = 1.3, 3.0, 9.0
"""A spontaneous blink comes so long [s] after the last one at the earliest, on average so much later, and at last."""
TURN_BLINKS, PHRASE_BLINKS = 0.3, 0.3
"""Shares of the dancers who blink when their heads begin to turn fast, and when a phrase ends."""


@inline_kernel
def mixed(value: int) -> int:
    """Return a 32-bit hash of the low 32 bits of `value`."""
    x = value & 0xFFFFFFFF
    x = ((x ^ (x >> 16)) * 0x7FEB352D) & 0xFFFFFFFF
    x = ((x ^ (x >> 15)) * 0x2C1B3C6D) & 0xFFFFFFFF
    x = ((x ^ (x >> 12)) * 0x297A2D39) & 0xFFFFFFFF
    return x ^ (x >> 15)


@inline_kernel
def chance(seed: int, row: int, count: int) -> float:
    """Return the random number `count` of the dancer `row`, 0 to below 1."""
    return mixed(mixed(seed + 0x9E3779B * (row + 1)) + count) * (1.0 / 4294967296.0)


# No array is handed from these loops to an inlined function: counting its references takes longer than all else.


@kernel("void(f4[:,::1], f4[:,::1], f8[:,::1], f8[::1], f8, f8, i8, i8)")
def advance_feelings(
    number: Float32, measured: Float32, mood: Float64, smile: Float64, music: float, dt: float, begin: int, end: int
) -> None:
    """Advance coming turns, effort, exertion, smile and brows of the dancers begin..end-1 by `dt` [s].

    In and out: `number` (A, NUMBER_COLUMNS). In: `measured` (A, 3) of `measure_dance`, `mood` (6, A), `smile` (A,) that
    is asked for, energy of the `music` 0 to 1.
    """
    follow, mild = 1.0 - math.exp(-dt / LEAD_FILTER_S), 1.0 - math.exp(-dt / MOOD_S)
    rise, fall, tire = 1.0 - math.exp(-dt / RISE_S), 1.0 - math.exp(-dt / FALL_S), 1.0 - math.exp(-dt / EXERTION_S)
    for i in range(begin, end):
        number[i, LEAD] += follow * (measured[i, TURN] - number[i, LEAD])
        wanted = 1.0 - math.exp(-max(measured[i, ENERGY], 0.0) / EFFORT_ENERGY)
        effort = number[i, EFFORT]
        effort += (wanted - effort) * (rise if wanted > effort else fall)
        number[i, EFFORT] = effort
        number[i, EXERTION] += (effort - number[i, EXERTION]) * tire
        weight, space, flow, proud, awake = mood[0, i], mood[2, i], mood[3, i], mood[4, i], mood[5, i]
        happy = smile[i] + 0.35 * awake + 0.2 * proud + 0.12 * flow - 0.15 * max(weight, 0.0) + 0.3 * (music - 0.5)
        number[i, SMILE] += mild * (min(max(happy, -1.0), 1.0) - number[i, SMILE])
        raised = 0.3 * awake + 0.2 * proud - 0.35 * max(space, 0.0) - 0.55 * effort * effort * (1.0 + 0.5 * weight)
        number[i, BROW] += mild * (min(max(raised, -1.0), 1.0) - number[i, BROW])


@kernel("void(f4[:,::1], f4[:,::1], f8[::1], f8, f8, f8, i8, f8, i8, i8)")
def advance_breath(
    slow: Float32, number: Float32, strain: Float64, beat: float, measure_beats: float, tempo: float, seed: int,
    dt: float, begin: int, end: int,
) -> None:  # fmt: skip
    """Advance the breath of the dancers begin..end-1 by `dt` [s], and write what changes slowly in faces.

    In and out: `number` (A, NUMBER_COLUMNS). Out: `slow` (A, FACE_SIZE), brows, mouth, smile, breath and effort. In:
    how much effort is seen, `strain` (A,), the danced `beat`, beats of a measure, tempo [bpm].
    """
    follow = 1.0 - math.exp(-dt / BREATH_S)
    for i in range(begin, end):
        exertion = number[i, EXERTION]
        own = LEAST_BREATHS + MORE_BREATHS * exertion
        # a breath takes a power of two of measures, or a half or a quarter, whatever is nearest to the own length
        length = tempo / (60.0 * own * measure_beats)
        beats = measure_beats * 2.0 ** math.floor(math.log2(max(length, 0.25)) + 0.5)
        behind = beat / beats + 0.05 * chance(seed, i, 0) - number[i, BREATH_PHASE]
        locked = tempo / (60.0 * beats) * (1.0 + 0.7 * math.sin(2.0 * math.pi * behind))
        rate = number[i, BREATH_RATE]
        rate += (min(max(locked, 0.5 * own), 1.8 * own) - rate) * follow
        phase = number[i, BREATH_PHASE] + rate * dt
        phase -= math.floor(phase)
        number[i, BREATH_RATE], number[i, BREATH_PHASE] = rate, phase
        if phase < OUT_SHARE:
            breath = math.cos(math.pi * phase / OUT_SHARE)
        else:
            breath = -math.cos(math.pi * (phase - OUT_SHARE) / (1.0 - OUT_SHARE))
        effort, tired = min(strain[i] * number[i, EFFORT], 1.0), min(strain[i] * exertion, 1.0)
        slow[i, BREATH] = (0.4 + 0.6 * exertion) * breath
        slow[i, EFFORT_COLUMN] = effort
        panting = ease((tired - 0.25) / 0.6) * (0.16 + 0.24 * max(-breath, 0.0) + 0.2 * abs(breath))
        slow[i, MOUTH_OPEN] = min(panting + 0.18 * effort * effort, 1.0)
        slow[i, SMILE_COLUMN] = number[i, SMILE] * (1.0 - 0.35 * effort * effort)
        raised = number[i, BROW] * (0.5 + 0.5 * strain[i]) + 0.12 * max(breath, 0.0)
        slow[i, BROW_COLUMN] = min(max(raised, -1.0), 1.0)


@kernel("void(f4[:,::1], i4[:,::1], f4[::1], b1, i8, f8, i8, i8)")
def advance_blinks(
    number: Float32, choice: Int32, lead_before: Float32, phrase_ends: bool, seed: int, dt: float, begin: int, end: int
) -> None:
    """Advance the blinks of the dancers begin..end-1 by `dt` [s].

    In and out: `number`, `choice`. In: the heads' coming turns a tick ago (A,) [rad], and whether a phrase ends now.
    """
    for i in range(begin, end):
        draws, later = choice[i, DRAWS], number[i, NEXT_BLINK] - dt
        number[i, BLINK_AGE] = min(number[i, BLINK_AGE] + dt, LONG_AGO)
        # nobody blinks at the same moment as others
        begins = abs(number[i, LEAD]) > TURNING and abs(lead_before[i]) <= TURNING
        if begins and chance(seed, i, draws + 1) < TURN_BLINKS:
            later = min(later, 0.4 * chance(seed, i, draws + 2))
        if phrase_ends and chance(seed, i, draws + 3) < PHRASE_BLINKS:
            later = min(later, 1.5 * chance(seed, i, draws + 4))
        if later <= 0.0 and number[i, BLINK_AGE] > 0.6:
            number[i, BLINK_AGE] = 0.0
            later = min(LEAST_BLINK_GAP - MEAN_BLINK_GAP * math.log(1.0 - chance(seed, i, draws + 5)), MOST_BLINK_GAP)
            choice[i, DRAWS] = (draws + DRAWS_A_TIME) & MOST_DRAWS
        number[i, NEXT_BLINK] = later
