"""Bar pointer: forward filter over tempo, phase, beat and metre, frame by frame."""

import math
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.clock.bar_pointer.bar_pointer_kernels import (
    LEAST,
    advance,
    change_octave,
    clear_distant,
    observe,
    phase_histogram,
    refine,
    search,
    weigh_slots,
)
from live.clock.bar_pointer.beat_regression import BeatRegression, MeasurePosition
from live.clock.bar_pointer.line_evidence import LineEvidence
from live.clock.bar_pointer.metre import FIRST_SLOT, PREVIOUS, USED, counted_metre
from live.clock.bar_pointer.observation_model import ActivationPhase, likelihoods
from live.clock.bar_pointer.phase_choice import PhaseChoice
from live.clock.bar_pointer.state_space import BarPointerModel, StateSpace
from live.clock.bar_pointer.transition_model import ManualConstraints, tempo_to_interval

_SIDE_BINS: Final = 2

SEARCH_INTERVAL: Final = 3
"""Number of frames between searches over all states; in between only states near the grid are evaluated."""

SETTLING_S: Final = 12.0
SETTLING_DOUBT: Final = 0.04
SETTLING_SHARPNESS: Final = 0.1
"""After a silence with at least this doubt (of 2 s: slow clicks have shorter rests) the exponent of downbeat
likelihoods grows from this share to the whole in so long [s], unless another grid is found: whatever comes first sounds
like a downbeat, and the network counts on from it."""
SETTLING_RATIO: Final = 20.0
"""... and another line, or half or double the tempo, must be so much more likely than usual, at first."""
SAME_LEVEL_OCTAVES: Final = 0.1
"""Grids whose tempi differ by an octave, to within this, are levels of the same music."""
CUE_SHARPNESS: Final = 1.0
MAX_CUE: Final = 1.5
"""Exponent of the odds by measure cues, and the most that one beat changes the odds of a line (natural logarithm)."""
SURE_BEATS: Final = 0.7
"""Beats of this confidence are sure."""
HAND_ERROR: Final = 0.25
"""A press this near to a beat means that beat [beats]."""
SURE_METRE: Final = 0.9
"""A metre with this share of the grid's states is sure."""


class BarPointer:
    """Filters activations forward; `step` processes a frame, the attributes hold the result.

    It follows one grid (interval, phase) through the posterior and leaves it only for another grid with a clearly
    larger share of the states. Its beats may be those of the grid or, as `PhaseChoice` says, some quarters later.
    """

    def __init__(self, model: BarPointerModel | None = None) -> None:
        self.model = BarPointerModel() if model is None else model
        self._states = StateSpace(self.model)
        self._manual = ManualConstraints(self._states)
        self._window = np.array(self.model.window, np.float32)
        self._accents = self.model.accents()
        self._no_births = np.zeros(self._states.count, np.float32)
        self._found = np.zeros(4)
        self.clear()

    def clear(self) -> None:
        """Reset all states; manual settings stay."""
        self._states.reset()
        self._until_survey = 0
        self._challenged = 0
        self._settling = 0.0  # how much of the time after a silence is left, 1 to 0
        self._restarted = True
        self._total = 1.0  # the sum of all states
        self._regression = BeatRegression()
        self._activation_phase = ActivationPhase()
        self._position = MeasurePosition()
        self._choice = PhaseChoice()
        self.line_evidence = LineEvidence()
        """What the music says about the measure line."""
        self.interval = 0.0
        """Frames from beat to beat; 0 before the first frame."""
        self.share = 0.0
        """Share of all states near this grid, 0 to 1."""
        self.rival_share = 0.0
        """Share of the states near the strongest grid of all."""
        self.slot_share = 0.0
        """Share of the grid's states that agree on metre and beat."""
        self.jumps = 0
        """Number of changes to other beats."""

    @property
    def period(self) -> float:
        """Frames from beat to beat by a line through the last beats, finer than `interval`."""
        return self._regression.interval if self._regression.interval > 0.0 else self.interval

    @property
    def tempo(self) -> float:
        """Beats per minute; 0 before the first frame."""
        return 60.0 * self.model.frame_rate / self.interval if self.interval > 0.0 else 0.0

    @property
    def since_beat(self) -> float:
        """Frames from the last beat to the last frame."""
        since = self._since_beat()
        return since if since >= 0.0 else since + self.interval

    @property
    def to_next(self) -> float:
        """Frames from the last frame to the next beat."""
        return self.interval - self.since_beat

    @property
    def metre(self) -> int:
        """Beats in a measure."""
        return self._position.metre

    @property
    def beat(self) -> int:
        """Position of the last beat in its measure, from 0."""
        return self._position.beat(past=self._since_beat() >= 0.0)

    @property
    def beat_offset(self) -> float:
        """How much later than the grid's the beats are, by phase cues [beats], 0 to 3/4."""
        return self._choice.offset

    @property
    def phase_odds(self) -> float:
        """Log-odds of these beats against others some quarters later, by phase cues; 0 without any."""
        return self._choice.odds

    def _grid_phase(self) -> float:
        """Return the beats from the grid's last beat to the last frame, 0 to 1; 0 before the first frame."""
        if self.interval <= 0.0:
            return 0.0
        return self._position.since(self.interval, self.model.centre) / self.interval % 1.0

    def _since_beat(self) -> float:
        """Return the frames from the beat of the present slot to the last frame, negative before it; at most one
        interval."""
        since = self._position.since(self.interval, self.model.centre)
        return since - self._choice.offset * self.interval

    def step(self, beat: float, downbeat: float, listening: bool = True) -> None:
        """Process one frame: the probability of a beat, and of a downbeat (never more), 0 to 1.

        While not `listening` (silence) the grid and all states advance at their own tempo, and nothing else changes.
        """
        states, hand = self._states, self._manual
        ring = (states.share, states.head, states.offset, states.length)
        if listening:
            births = hand.births(self._activation_phase.grid_is_lost)
            self._total = advance(
                *ring, hand.tempo, hand.metre, births, states.slot_share, states.leaving, states.entering,
                np.float32(hand.line_change), self._total,
            )  # fmt: skip
            self._total += change_octave(*ring, states.partner, states.slot_share, hand.octave_change_odds)
            self._settling = max(self._settling - 1.0 / (SETTLING_S * self.model.frame_rate), 0.0)
            sharpness = hand.downbeat_sharpness * (1.0 - (1.0 - SETTLING_SHARPNESS) * self._settling)
            said = likelihoods(self.model, beat, downbeat, hand.downbeat_range, sharpness)
            self._total += observe(*ring, self._window, self._accents, *said)
        else:
            self._total = advance(
                *ring, states.constant_tempo, states.same_metre, self._no_births, states.slot_share, states.leaving,
                states.entering, np.float32(0.0), self._total,
            )  # fmt: skip
            self._regression.skip_frame()
            self.interval = self._regression.interval
        if self.interval > 0.0:
            self._position.move(1.0 / self.interval)
        if not listening:
            return
        self._activation_phase.step(self._grid_phase(), beat)
        self._until_survey -= 1
        by_hand = self._restarted
        switch = self._until_survey < 0 and self._search_grid()
        self._follow(switch)
        if switch:
            self.line_evidence.clear()
            self._settling = 0.0
            if not by_hand:  # other music
                self._choice.clear()
                self._manual.release_line()
        place = self._position
        in_window = 0.0 <= place.phase * self.interval < len(self._window)
        self.line_evidence.step(in_window, place.metre, place.window_beat, beat, downbeat)

    def add_measure_cue(self, log_odds: float) -> None:
        """Weigh the measure lines of the grid; one that was set by hand stays.

        log_odds: natural logarithm of the odds that the beat before the present one began a measure. Call it in the
        second half of a beat.
        """
        if self.interval <= 0.0 or self._manual.keeps_line:
            return
        place, states = self._position, self._states
        strength = CUE_SHARPNESS * (1.0 - (1.0 - SETTLING_SHARPNESS) * self._settling)
        gain = math.exp(min(max(strength * log_odds, -MAX_CUE), MAX_CUE)) - 1.0
        before = PREVIOUS if self._since_beat() >= 0.0 else PREVIOUS[PREVIOUS]
        factors = 1.0 + self._accents[before] * gain
        usual = float(place.shares @ factors) / max(float(place.shares.sum()), 1e-30)
        weigh_slots(
            states.share, states.head, states.offset, states.length, self.interval, place.phase,
            self.model.near_tempo, (factors / max(usual, 1e-6)).astype(np.float32),
        )  # fmt: skip

    def add_phase_cue(self, scores: Float64) -> int:
        """Judge the beats against those some quarters of a beat later; after a beat by hand they stay.

        scores: natural logarithms of the probabilities of the present beats and of those one, two and three quarters
        later. Returns by how many quarters the beats are later from now on.
        """
        if self.interval <= 0.0 or self._manual.keeps_phase:
            return 0
        shift = self._choice.judge(scores)
        self.jumps += shift > 0
        return shift

    def set_tempo(self, bpm: float) -> None:
        """Set a tapped tempo and keep its metrical level. ValueError for a tempo outside the model's range."""
        interval = tempo_to_interval(bpm, self.model)
        if self.interval <= 0.0 or abs(interval / self.interval - 1.0) > self.model.near_tempo:
            self._choice.clear()
        self._manual.set_tempo(interval)
        self._restart_search()

    def set_downbeat(self, age: float) -> None:
        """Start a measure `age` frames before the last frame (negative: in the future).

        Near a sure beat it is that beat: hands are late by as much. Farther from it the hand is right and the beats are
        wrong, for example on the off-beat. The present metre is kept, too, if it is sure.
        """
        age = self._age_of_grid(age, snapped=self.interval > 0.0 and self.confidence > SURE_BEATS)
        sure = self.interval > 0.0 and self._position.metre_share > SURE_METRE
        self._manual.set_downbeat(age, self._position.metre if sure else 0)
        self.line_evidence.clear()
        self._restart_search()

    def set_beat(self, age: float) -> None:
        """Set a beat, of any position in its measure, `age` frames before the last frame."""
        self._manual.set_beat(self._age_of_grid(age))
        self._restart_search()

    def scale(self, factor: float) -> None:
        """Multiply the tempo by `factor` (2 or 0.5); the metrical level is kept from now on.

        A tempo outside the model's range changes nothing. Raises ValueError for another factor.
        """
        if factor not in (0.5, 2.0):
            raise ValueError(f"the tempo times {factor}: 2 or 0.5 expected")
        place = self._position
        if self.interval > 0.0 and self._manual.scale(factor, self.interval, place.phase * self.interval, place.slot):
            self._choice.scale(factor)
            self._restart_search()

    def _age_of_grid(self, age: float, snapped: bool = False) -> float:
        """Return the age [frames] of the grid's beat that belongs to a beat of this age by hand, or to the beat next to
        it (`snapped`).

        Where the hand finds other beats than those that were chosen, the choice is gone.
        """
        if self.interval <= 0.0:
            return age
        beats = (age - self.since_beat) / self.interval
        if abs(beats - round(beats)) >= HAND_ERROR:
            self._choice.clear()
            return age
        if snapped:
            age = self.since_beat + round(beats) * self.interval
        return age + self._choice.offset * self.interval

    def restore_before(self, age: float) -> None:
        """Restore the grid of `age` frames ago, when the music ended, and extrapolate it from there.

        Changes due to the missing beats since then, and to the last sounds, are undone.
        """
        kept = self._regression.grid_before(age)
        if kept is None or self.interval <= 0.0:
            return
        since, self.interval, slot, shares = kept
        self._position.reset(slot, shares, (since + self.model.centre) / self.interval)

    def resume(self, doubt: float) -> None:
        """Continue the extrapolated grid after a long silence, with a share `doubt` of the states spread as at the
        start.

        (The states themselves have drifted apart: a frame more or less for each beat.)
        """
        if self.interval > 0.0:
            self._states.set_grid(self.interval, self._position.phase, self._position.slot_distribution(), doubt)
            self._settling = float(doubt >= SETTLING_DOUBT)
        else:
            self._states.reset()
        self._total = 1.0
        self._until_survey = 0

    @property
    def confidence(self) -> float:
        """Probability that the next beat is right, 0 to 1: of beats with confidence c about a share c are right, within
        0.07 from 0.65 on."""
        return self._activation_phase.confidence(self.share, self._manual.keeps_level, self.phase_odds)

    def tempo_shares(self) -> tuple[Float64, Float64]:
        """Return the tempi [bpm] and the share of the states at each, at the last search, both (K,)."""
        share = self._states.histogram.sum(axis=1, dtype=np.float64)
        return 60.0 * self.model.frame_rate / self._states.length, share / max(float(share.sum()), 1e-30)

    def metre_shares(self) -> Float64:
        """Return the share of each of METRES among the grid's states, (M,)."""
        share = np.add.reduceat(self._position.shares[:USED], FIRST_SLOT)
        return np.asarray(share / max(float(share.sum()), 1e-30))

    @property
    def phase_strength(self) -> tuple[float, ...]:
        """How strongly the last beats sounded on the beat, a quarter after it, half and three quarters, 0 to 1."""
        return tuple(self._activation_phase.strength)

    def set_metre(self, beats: int) -> None:
        """Set the beats of a measure; 0: as detected. Others than 2 to 9 are counted in parts, see `counted_metre`."""
        self._manual.set_metre(counted_metre(beats, self.model.metres))
        self._restart_search()

    def clear_manual(self) -> None:
        """Remove all manual settings."""
        self._manual.clear()

    def copy_manual(self, former: "BarPointer") -> None:
        """Copy another pointer's manual tempo and metre; its measure lines do not apply here."""
        told = former._manual
        if told.keeps_level:
            bpm = 60.0 * former.model.frame_rate / told.held_interval
            self.set_tempo(min(max(bpm, self.model.slowest_bpm), self.model.fastest_bpm))
        if told.held_metre:
            self.set_metre(told.held_metre)

    def _restart_search(self) -> None:
        self._total = 1.0
        self._until_survey = 0
        self._restarted = True
        self._activation_phase = ActivationPhase()

    def _search_grid(self) -> bool:
        """Normalise all states and find the strongest grid. Return True if the grid changes to it."""
        states, model, found = self._states, self.model, self._found
        self._until_survey = SEARCH_INTERVAL - 1
        anew, self._restarted = self._restarted or self.interval == 0.0, False
        if self._manual.keeps_phase and not anew and not self._activation_phase.grid_is_lost:
            clear_distant(states.share, states.head, states.offset, states.length, self.interval, self._position.phase)
        total = phase_histogram(states.share, states.head, states.offset, states.length, states.histogram)
        if total <= 0.0:  # no state has any weight left
            states.reset()
            total = phase_histogram(states.share, states.head, states.offset, states.length, states.histogram)
        states.flat *= np.float32(1.0 / total)
        states.flat[states.flat < LEAST] = 0.0
        self._total = 1.0
        search(
            states.histogram, states.length, states.near, states.boxes, self.interval, self._position.phase,
            model.near_tempo, _SIDE_BINS, found,
        )  # fmt: skip
        self.rival_share, near = float(found[2]) / total, float(found[3]) / total
        self._challenged = self._challenged + 1 if self.rival_share > self._switch_ratio(found[0]) * near else 0
        if not anew and self._challenged <= model.switch_surveys:
            self._manual.follow_drift(self.interval)
            return False
        self.jumps += self.interval > 0.0
        self.interval, self._position.phase = float(found[0]), float(found[1])
        self._challenged = 0
        return True

    def _switch_ratio(self, rival: float) -> float:
        """Return how much larger the share of another grid of interval `rival` [frames] must be."""
        model = self.model
        if self.interval <= 0.0 or abs(abs(math.log2(rival / self.interval)) - 1.0) > SAME_LEVEL_OCTAVES:
            return model.switch_ratio
        return model.level_ratio * (1.0 + SETTLING_RATIO * self._settling)

    def _follow(self, switched: bool) -> None:
        """Move the grid to the mean of the states near it, and set the beat of the measure that most of them have."""
        states, model, found, place = self._states, self.model, self._found, self._position
        refine(
            states.share, states.head, states.offset, states.length, self.interval, place.phase, model.near_tempo,
            model.near_phase, found, place.shares,
        )  # fmt: skip
        if self._until_survey == SEARCH_INTERVAL - 1:
            self.share = float(found[2])
        if found[2] <= 0.0:
            return
        best = int(np.argmax(place.shares))
        ratio = model.line_ratio * (1.0 + SETTLING_RATIO * self._settling)
        if switched or place.shares[best] > ratio * place.shares[place.slot]:
            place.slot = best
        self.slot_share = float(place.shares[place.slot])
        self.interval = float(found[0])
        place.move(float(found[1]))
        since = place.since(self.interval, model.centre)
        self._regression.step(since, self.interval, place.slot, place.shares, restarted=switched)
