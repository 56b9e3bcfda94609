"""Bar pointer: forward filter over tempo, phase, beat and metre, frame by frame."""

from typing import Final

import numpy as np

from live.clock.bar_pointer.bar_pointer_kernels import advance, fence, leap, observe, refine, rescale, search, tally
from live.clock.bar_pointer.beat_regression import PassedBeats, Place
from live.clock.bar_pointer.observation_model import Whereabouts, likelihoods
from live.clock.bar_pointer.state_space import Model, States
from live.clock.bar_pointer.transition_model import Hand, interval_of

_SIDE_BINS: Final = 2

SURVEY: Final = 3
"""Number of frames between searches over all states; in between only states near the grid are evaluated."""


class BarPointer:
    """Filters activations forward; `step` processes a frame, the attributes hold the result.

    It follows one grid (interval, phase) through the posterior and leaves it only for another grid with a clearly
    larger
    share of the states.
    """

    def __init__(self, model: Model | None = None) -> None:
        self.model = Model() if model is None else model
        self._states = States(self.model)
        self._hand = Hand(self._states)
        self._window = np.array(self.model.window, np.float32)
        self._no_births = np.zeros(self._states.count, np.float32)
        self._found = np.zeros(4)
        self.clear()

    def clear(self) -> None:
        """Reset all states; manual settings stay."""
        self._states.fill()
        self._until_survey = 0
        self._challenged = 0
        self._anew = True
        self._whole = 1.0  # the sum of all states
        self._passed = PassedBeats()
        self._whereabouts = Whereabouts()
        self._place = Place()
        self.interval = 0.0
        """Frames from beat to beat; 0 before the first frame."""
        self.share = 0.0
        """Share of all states near this grid, 0 to 1."""
        self.rival = 0.0
        """Share of the states near the strongest grid of all."""
        self.slot_share = 0.0
        """Share of the grid's states that agree on metre and beat."""
        self.jumps = 0
        """Number of changes to another grid."""

    @property
    def period(self) -> float:
        """Frames from beat to beat by a line through the last beats, finer than `interval`."""
        return self._passed.interval if self._passed.interval > 0.0 else self.interval

    @property
    def tempo(self) -> float:
        """Beats per minute; 0 before the first frame."""
        return 60.0 * self.model.frame_rate / self.interval if self.interval > 0.0 else 0.0

    @property
    def since_beat(self) -> float:
        """Frames from the last beat to the last frame."""
        since = self._place.since(self.interval, self.model.centre)
        return since if since >= 0.0 else since + self.interval

    @property
    def to_next(self) -> float:
        """Frames from the last frame to the next beat."""
        return self.interval - self.since_beat

    @property
    def metre(self) -> int:
        """Beats in a measure."""
        return self._place.metre

    @property
    def beat(self) -> int:
        """Position of the last beat in its measure, from 0."""
        return self._place.beat(past=self._place.since(self.interval, self.model.centre) >= 0.0)

    def step(self, beat: float, downbeat: float, listening: bool = True) -> None:
        """Process one frame: the probability of a beat, and of a downbeat (never more), 0 to 1.

        While not `listening` (silence) the grid and all states advance at their own tempo, and nothing else changes.
        """
        states, hand = self._states, self._hand
        ring = (states.share, states.head, states.offset, states.length)
        if listening:
            births = hand.births(self._whereabouts.left)
            self._whole = advance(
                *ring, hand.tempo, hand.metre, births, states.slot_share, states.leaving, states.entering,
                np.float32(hand.line_change), self._whole,
            )  # fmt: skip
            self._whole += leap(*ring, states.partner, states.slot_share, hand.leap)
            said = likelihoods(self.model, beat, downbeat, hand.downbeat_range, hand.downbeat_sharpness)
            self._whole += observe(*ring, self._window, *said)
        else:
            self._whole = advance(
                *ring, states.still, states.same_metre, self._no_births, states.slot_share, states.leaving,
                states.entering, np.float32(0.0), self._whole,
            )  # fmt: skip
            self._passed.rest()
            self.interval = self._passed.interval
        if self.interval > 0.0:
            self._place.move(1.0 / self.interval)
        if not listening:
            return
        self._whereabouts.step(self.since_beat / self.interval if self.interval > 0.0 else 0.0, beat)
        self._until_survey -= 1
        switch = self._until_survey < 0 and self._survey()
        self._follow(switch)

    def tap(self, bpm: float) -> None:
        """Set a tapped tempo and keep its metrical level. ValueError for a tempo outside the model's range."""
        self._hand.tap(interval_of(bpm, self.model))
        self._set_anew()

    def one(self, age: float) -> None:
        """Start a measure `age` frames before the last frame (negative: in the future)."""
        self._hand.one(age)
        self._set_anew()

    def beat_pressed(self, age: float) -> None:
        """Set a beat, of any position in its measure, `age` frames before the last frame."""
        self._hand.beat(age)
        self._set_anew()

    def scale(self, factor: float) -> None:
        """Multiply the tempo by `factor` (2 or 0.5); the metrical level is kept from now on.

        A tempo outside the model's range changes nothing. Raises ValueError for another factor.
        """
        if factor not in (0.5, 2.0):
            raise ValueError(f"the tempo times {factor}: 2 or 0.5 expected")
        place = self._place
        if self.interval > 0.0 and self._hand.scale(factor, self.interval, place.into * self.interval, place.slot):
            self._set_anew()

    def hold(self, age: float) -> None:
        """Restore the grid of `age` frames ago, when the music ended, and extrapolate it from there.

        Changes due to the missing beats since then, and to the last sounds, are undone.
        """
        kept = self._passed.before(age)
        if kept is None or self.interval <= 0.0:
            return
        since, self.interval, slot, shares = kept
        self._place.begin(slot, shares, (since + self.model.centre) / self.interval)

    def resume(self, doubt: float) -> None:
        """Continue the extrapolated grid after a long silence, with a share `doubt` of the states spread as at the
        start.

        (The states themselves have drifted apart: a frame more or less for each beat.)
        """
        if self.interval > 0.0:
            self._states.gather(self.interval, self._place.into, self._place.kept(), doubt)
        else:
            self._states.fill()
        self._whole = 1.0
        self._until_survey = 0

    @property
    def confidence(self) -> float:
        """Probability that the next beat is right, 0 to 1 (calibrated: of beats with confidence c about a share c are
        right)."""
        return self._whereabouts.confidence(self.share, self._hand.keeps_level)

    def set_metre(self, beats: int) -> None:
        """Set a measure of 2, 3, 4 or 6 beats; 0: as detected. ValueError for another number."""
        self._hand.set_metre(beats)
        self._set_anew()

    def let_go(self) -> None:
        """Remove all manual settings."""
        self._hand.let_go()

    def obey(self, former: "BarPointer") -> None:
        """Copy another pointer's manual tempo and metre; its measure lines do not apply here."""
        told = former._hand
        if told.keeps_level:
            bpm = 60.0 * former.model.frame_rate / told.held_interval
            self.tap(min(max(bpm, self.model.slowest_bpm), self.model.fastest_bpm))
        if told.held_metre:
            self.set_metre(told.held_metre)

    def _set_anew(self) -> None:
        self._whole = 1.0
        self._until_survey = 0
        self._anew = True
        self._whereabouts = Whereabouts()

    def _survey(self) -> bool:
        """Normalise all states and find the strongest grid. Return True if the grid changes to it."""
        states, model, found = self._states, self.model, self._found
        self._until_survey = SURVEY - 1
        anew, self._anew = self._anew or self.interval == 0.0, False
        if self._hand.keeps_phase and not anew and not self._whereabouts.left:
            fence(states.share, states.head, states.offset, states.length, self.interval, self._place.into)
        total = tally(states.share, states.head, states.offset, states.length, states.histogram)
        if total <= 0.0:  # no state has any weight left
            states.fill()
            total = tally(states.share, states.head, states.offset, states.length, states.histogram)
        rescale(states.flat, np.float32(1.0 / total))
        self._whole = 1.0
        search(
            states.histogram, states.length, states.near, states.boxes, self.interval, self._place.into,
            model.near_tempo, _SIDE_BINS, found,
        )  # fmt: skip
        self.rival, near = float(found[2]) / total, float(found[3]) / total
        self._challenged = self._challenged + 1 if self.rival > model.switch_ratio * near else 0
        if not anew and self._challenged <= model.switch_surveys:
            self._hand.drift(self.interval)
            return False
        self.jumps += self.interval > 0.0
        self.interval, self._place.into = float(found[0]), float(found[1])
        self._challenged = 0
        return True

    def _follow(self, switched: bool) -> None:
        """Move the grid to the mean of the states near it, and set the beat of the measure that most of them have."""
        states, model, found, place = self._states, self.model, self._found, self._place
        refine(
            states.share, states.head, states.offset, states.length, self.interval, place.into, model.near_tempo,
            model.near_phase, found, place.shares,
        )  # fmt: skip
        if self._until_survey == SURVEY - 1:
            self.share = float(found[2])
        if found[2] <= 0.0:
            return
        best = int(np.argmax(place.shares))
        if switched or place.shares[best] > model.line_ratio * place.shares[place.slot]:
            place.slot = best
        self.slot_share = float(place.shares[place.slot])
        self.interval = float(found[0])
        place.move(float(found[1]))
        since = place.since(self.interval, model.centre)
        self._passed.step(since, self.interval, place.slot, place.shares, anew=switched)
