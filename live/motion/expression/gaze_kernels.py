"""Where dancers look, decided at ticks.

Eyes and head work together as in people: the eyes jump to a target first (a saccade of 25 ms and 2.4 ms for each
degree), the head follows, and while it turns the eyes stay on the target (vestibulo-ocular reflex), because targets are
places on the stage and only the drawn head decides where the eyes stand in it (Lee, Badler & Badler 2002, *Eyes alive*;
Peters & Qureshi 2010, *A head movement propensity model*; Ruhland et al. 2015, *A review of eye gaze*). Which targets
can be looked at is a matter of where the head will be, so eyes leave early for what it will face, as in spotting.
"""

import math

import numpy as np
import numpy.typing as npt

from live.base.jit import inline_kernel, kernel
from live.base.scalar_kernels import angle_wrap
from live.motion.expression.dance_kernels import HEAD_YAW
from live.motion.expression.face_kernels import (
    DRAWS,
    DRAWS_A_TIME,
    EFFORT,
    FIXATION,
    KIND,
    LAST_KIND,
    LAST_OTHER,
    LAST_TARGET,
    LEAD,
    LONG_AGO,
    MOST_DRAWS,
    NEXT_BLINK,
    OTHER,
    SACCADE_AGE,
    SACCADE_S,
    TARGET,
    TURNING,
    chance,
)

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]

AHEAD, PLACE, PUBLIC, DANCER, LEFT_HAND, RIGHT_HAND = range(6)
"""Targets: where the head goes, a place on the way, the public, another dancer's face, the own hands."""
MATE, SOMEONE, HAND = DANCER, 4, 5
"""Entries of the weights of targets besides AHEAD, PLACE and PUBLIC: the partner, another dancer, a hand."""
NEAR_VIEW = math.radians(50.0)
"""A target so far aside of where the head will be can be looked at; ..."""
LOST_VIEW = math.radians(65.0)
"""... beyond this it is lost."""
LARGE_SHIFT = math.radians(40.0)
"""A gaze shift so large may come with a blink."""
LEAST_FIXATION, MOST_FIXATION = 0.2, 5.0
"""A new saccade begins so long [s] after the last one at the earliest; nobody looks at one place longer than that."""
ASIDE, UPWARD = 0.6, 0.2
"""How far eyes are turned aside at most, and up or down with a gaze shift [rad], where only its length matters."""
SACCADE_START_S, SACCADE_S_PER_DEGREE = 0.025, 0.0024
"""Length of a saccade: Lee, Badler & Badler (2002), after Leigh & Zee."""
AUDIENCE_DEPTH = 4.0
"""The public that is looked at begins so far [m] before the stage."""
SHIFT_BLINKS = 0.35
"""Share of the large gaze shifts that come with a blink."""
LOOK_SECONDS = np.array([[0.4, 0.8], [0.5, 0.6], [0.8, 1.6], [0.9, 1.2], [0.5, 0.5], [0.5, 0.6]])
"""Shortest look at each entry of the weights [s], and how much longer it is on average."""


@inline_kernel
def _view(x: float, z: float, heading: float) -> float:
    """Return how far aside of `heading` something is that is x, z [m] away [rad]."""
    return angle_wrap(math.atan2(x, z) - heading)


@inline_kernel
def _eye_turn(kind: int, seen: float, lead: float) -> float:
    """Return about how far the eyes are turned [rad] for a target `seen` aside of where the head will be."""
    turn = seen + lead
    if kind == AHEAD:
        turn = lead
    elif kind >= LEFT_HAND:
        turn = ASIDE if kind == LEFT_HAND else -ASIDE
    return min(max(turn, -ASIDE), ASIDE)


@kernel("i8(i4[::1], f4[::1], f4[:,::1], i4[:,::1], f4[:,::1], f4[:,::1], b1[::1], f8[::1], f8, i8, i8)")
def find_seekers(
    rows: Int32, views: Float32, number: Float32, choice: Int32, measured: Float32, position: Float32, there: Bool,
    gaze: Float64, dt: float, begin: int, end: int,
) -> int:  # fmt: skip
    """Advance the fixations of the dancers begin..end-1 by `dt` [s]; return how many may look elsewhere now.

    Out: their `rows`, and the `views` of what they look at: how far aside of where the head will be [rad]; both at
    least end - begin long. See `choose_targets`.
    """
    found = 0
    for i in range(begin, end):
        number[i, SACCADE_AGE] = min(number[i, SACCADE_AGE] + dt, LONG_AGO)
        number[i, FIXATION] -= dt
        if number[i, SACCADE_AGE] < LEAST_FIXATION:
            continue
        kind, other, lead, seen = choice[i, KIND], choice[i, OTHER], number[i, LEAD], 0.0
        ahead = measured[i, HEAD_YAW] + lead
        if kind in (PLACE, PUBLIC):
            seen = _view(number[i, TARGET] - position[i, 0], number[i, TARGET + 2] - position[i, 1], ahead)
        elif kind == DANCER:
            seen = _view(position[other, 0] - position[i, 0], position[other, 1] - position[i, 1], ahead)
            if not there[other]:
                seen = math.pi
        turns = kind == AHEAD and abs(lead) > TURNING and gaze[i] > 0.0
        if number[i, FIXATION] <= 0.0 or abs(seen) > LOST_VIEW or turns:
            rows[found], views[found] = i, seen
            found += 1
    return found


@kernel(
    "void(f8[::1], f8[::1], i4[::1], f4[:,::1], f4[:,::1], f4[:,::1], b1[::1], i4[::1], i4[::1], f8[:,::1], f8[::1],"
    " f8, i8, i8, i8, i8)"
)
def _weigh_targets(
    weight: Float64, view: Float64, dancer: Int32, number: Float32, position: Float32, velocity: Float32, there: Bool,
    partner: Int32, soloists: Int32, mood: Float64, gaze: Float64, ahead: float, i: int, kind: int, draws: int,
    seed: int,
) -> None:  # fmt: skip
    """Write the weights of the dancer's targets and how far aside of where the head will be they are, (6,); `view` of
    PUBLIC is known. `dancer` (2,): the partner, and another dancer whom one could look at."""
    x, z = position[i, 0], position[i, 1]
    weight[:] = 0.0
    view[AHEAD] = view[HAND] = 0.0
    weight[AHEAD] = 1.0 + (1.5 if abs(number[i, LEAD]) > TURNING else 0.0)
    if abs(view[PUBLIC]) < NEAR_VIEW:
        weight[PUBLIC] = max(3.2 + 3.0 * mood[2, i] + 1.5 * mood[4, i], 0.0) * gaze[i]
    dancer[0] = partner[i]
    if dancer[0] >= 0 and there[dancer[0]]:
        view[MATE] = _view(position[dancer[0], 0] - x, position[dancer[0], 1] - z, ahead)
        weight[MATE] = 3.5 if abs(view[MATE]) < NEAR_VIEW + 0.2 else 0.0
    if len(soloists) and chance(seed, i, draws + 7) < 0.6:
        dancer[1] = soloists[int(chance(seed, i, draws + 8) * len(soloists))]
    else:
        dancer[1] = int(chance(seed, i, draws + 8) * len(there))
    if dancer[1] != i and there[dancer[1]]:
        to_x, to_z = position[dancer[1], 0] - x, position[dancer[1], 1] - z
        view[SOMEONE] = _view(to_x, to_z, ahead)
        if abs(view[SOMEONE]) < NEAR_VIEW and 0.5 < math.hypot(to_x, to_z) < 9.0:
            weight[SOMEONE] = 1.2
    pace = math.hypot(velocity[i, 0], velocity[i, 1])
    if pace > 0.4:
        view[PLACE] = _view(velocity[i, 0], velocity[i, 1], ahead)
        weight[PLACE] = 1.2 * min(pace, 2.0) if abs(view[PLACE]) < NEAR_VIEW else 0.0
    # only slow hands, as in a port de bras
    weight[HAND] = max(1.2 - 3.0 * number[i, EFFORT], 0.0) if kind < LEFT_HAND else 0.0


@kernel(
    "void(i4[::1], f4[::1], i8, f4[:,::1], i4[:,::1], f4[:,::1], f4[:,::1], f4[:,::1], b1[::1], i4[::1], i4[::1],"
    " f8[:,::1], f8[::1], f8, f8, f8[:,::1], i8)"
)
def choose_targets(
    rows: Int32, views: Float32, found: int, number: Float32, choice: Int32, measured: Float32, position: Float32,
    velocity: Float32, there: Bool, partner: Int32, soloists: Int32, mood: Float64, gaze: Float64, half_width: float,
    half_depth: float, seconds: Float64, seed: int,
) -> None:  # fmt: skip
    """Choose new targets for the first `found` of the dancers `rows`, who look `views` aside now [rad].

    In and out: `number` and `choice` of all dancers. In: `measured` (A, 3) of `measure_dance`, hips `position` and
    `velocity` (A, 2) [m, m/s], who is `there` (A,), `partner` (A,) or -1, `soloists` (K,), `mood` (6, A), how often the
    public is looked at, `gaze` (A,), half sizes of the stage [m], and the `seconds` (6, 2) of looks.
    """
    weight, view, dancer = np.zeros(6), np.zeros(6), np.zeros(2, np.int32)
    for n in range(found):
        i, seen = rows[n], views[n]
        draws, lead, old = choice[i, DRAWS], number[i, LEAD], choice[i, KIND]
        ahead = measured[i, HEAD_YAW] + lead
        public_x = half_width * (0.8 * chance(seed, i, draws + 6) - 0.4) + 0.5 * position[i, 0]
        view[PUBLIC] = _view(public_x - position[i, 0], half_depth + AUDIENCE_DEPTH - position[i, 1], ahead)
        arrives = old == AHEAD and abs(lead) > TURNING and abs(view[PUBLIC]) < 0.5 * NEAR_VIEW
        if number[i, FIXATION] > 0.0 and abs(seen) <= LOST_VIEW and not arrives:
            continue
        _weigh_targets(
            weight, view, dancer, number, position, velocity, there, partner, soloists, mood, gaze, ahead, i, old,
            draws, seed,
        )  # fmt: skip
        weight[PUBLIC] *= 20.0 if arrives else 1.0
        drawn, entry = chance(seed, i, draws + 9) * weight.sum(), 0
        while entry < HAND and drawn >= weight[entry]:
            drawn -= weight[entry]
            entry += 1
        kind, other, x, y, z = entry, -1, 0.0, 0.0, 0.0
        if entry in (MATE, SOMEONE):
            kind, other = DANCER, dancer[0 if entry == MATE else 1]
        elif entry == HAND:
            kind = LEFT_HAND if chance(seed, i, draws + 13) < 0.5 else RIGHT_HAND
        elif entry == PUBLIC:
            x, z = public_x, half_depth + AUDIENCE_DEPTH + 4.0 * chance(seed, i, draws + 12)
            y = 0.8 + 1.3 * chance(seed, i, draws + 11) + 1.2 * min(mood[4, i], 0.0)
        elif entry == PLACE:
            x, y, z = position[i, 0] + 2.5 * velocity[i, 0], 1.2, position[i, 1] + 2.5 * velocity[i, 1]
        stays = seconds[entry, 0] - seconds[entry, 1] * math.log(1.0 - chance(seed, i, draws + 10))
        shift = abs(_eye_turn(kind, view[entry], lead) - _eye_turn(old, seen, lead)) + UPWARD
        choice[i, LAST_KIND], choice[i, LAST_OTHER] = old, choice[i, OTHER]
        choice[i, KIND], choice[i, OTHER] = kind, other
        for c in range(3):
            number[i, LAST_TARGET + c] = number[i, TARGET + c]
        number[i, TARGET], number[i, TARGET + 1], number[i, TARGET + 2] = x, y, z
        number[i, SACCADE_AGE], number[i, FIXATION] = 0.0, min(stays, MOST_FIXATION)
        number[i, SACCADE_S] = SACCADE_START_S + SACCADE_S_PER_DEGREE * math.degrees(min(shift, 2.0 * ASIDE))
        if shift > LARGE_SHIFT and chance(seed, i, draws + 14) < SHIFT_BLINKS:
            number[i, NEXT_BLINK] = min(number[i, NEXT_BLINK], 0.1 * chance(seed, i, draws + 15))
        choice[i, DRAWS] = (draws + DRAWS_A_TIME) & MOST_DRAWS
