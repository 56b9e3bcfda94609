"""BarPointer: what has been heard so far, frame by frame, as tempo, phase, beat and metre (forward filter)."""

from typing import Final

import numpy as np

from live.clock.bar_pointer.bar_pointer_kernels import advance, fence, leap, observe, refine, rescale, search, tally
from live.clock.bar_pointer.beat_regression import PassedBeats, Place
from live.clock.bar_pointer.observation_model import Whereabouts, likelihoods
from live.clock.bar_pointer.state_space import Model, States
from live.clock.bar_pointer.transition_model import Hand, interval_of

_SIDE_BINS: Final = 2

SURVEY: Final = 3
"""Frames from one look at all states to the next; in between only those near the grid are looked at."""


class BarPointer:
    """Filters activations forward; `step` takes a frame, the attributes say what is believed after it.

    It follows one grid (interval, phase) through the posterior and leaves it only for another one that has clearly
    more of the states: what is chosen stays put.
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
        """Forget everything that was heard; what was set by hand stays."""
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
        """The share of all states near this grid, 0 to 1."""
        self.rival = 0.0
        """The share of those near the strongest place of all."""
        self.slot_share = 0.0
        """The share of the grid's states that agree on metre and beat."""
        self.jumps = 0
        """How often the grid was left for another one."""

    @property
    def period(self) -> float:
        """Frames from beat to beat by the line through the last ones, finer than `interval`."""
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
        """Beats of a measure."""
        return self._place.metre

    @property
    def beat(self) -> int:
        """Which beat of its measure the last beat was, from 0."""
        return self._place.beat(past=self._place.since(self.interval, self.model.centre) >= 0.0)

    def step(self, beat: float, downbeat: float, listening: bool = True) -> None:
        """One frame: the chance of a beat, and of a downbeat (never more), 0 to 1.

        While not `listening` (silence) the grid and all states run on, each at its tempo, and nothing else changes.
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
        """The tempo was tapped: it is this, and its level is kept. ValueError for one that is not looked for."""
        self._hand.tap(interval_of(bpm, self.model))
        self._set_anew()

    def one(self, age: float) -> None:
        """A measure began `age` frames before the last frame (negative: it will begin)."""
        self._hand.one(age)
        self._set_anew()

    def beat_pressed(self, age: float) -> None:
        """A beat, whichever of its measure, lay `age` frames before the last frame."""
        self._hand.beat(age)
        self._set_anew()

    def scale(self, factor: float) -> None:
        """The beats are `factor` (2 or 0.5) times as fast as believed; the level is kept from now on.

        A tempo that is not looked for changes nothing. Raises ValueError for another factor.
        """
        if factor not in (0.5, 2.0):
            raise ValueError(f"the tempo times {factor}: 2 or 0.5 expected")
        place = self._place
        if self.interval > 0.0 and self._hand.scale(factor, self.interval, place.into * self.interval, place.slot):
            self._set_anew()

    def hold(self, age: float) -> None:
        """The music ended `age` frames ago: the grid is again what it was then, and runs on from there.

        What was made of the missing beats since, and of the last sounds, is taken back.
        """
        kept = self._passed.before(age)
        if kept is None or self.interval <= 0.0:
            return
        since, self.interval, slot, shares = kept
        self._place.begin(slot, shares, (since + self.model.centre) / self.interval)

    def resume(self, doubt: float) -> None:
        """After a long silence: the grid as it ran on is believed, but for a share `doubt` of all that is possible.

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
        """How likely the next beat is right, 0 to 1: of beats with confidence c about a share c are."""
        return self._whereabouts.confidence(self.share, self._hand.keeps_level)

    def set_metre(self, beats: int) -> None:
        """The measure has 2, 3, 4 or 6 beats; 0: as heard. ValueError for another number."""
        self._hand.set_metre(beats)
        self._set_anew()

    def let_go(self) -> None:
        """Nothing is set by hand any more."""
        self._hand.let_go()

    def obey(self, former: "BarPointer") -> None:
        """Keep tempo and metre that another pointer was told by hand; where its measures began is nothing to this."""
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
        """Bring all states to the sum 1, and look where most of them are. True if the grid is left for that place."""
        states, model, found = self._states, self.model, self._found
        self._until_survey = SURVEY - 1
        anew, self._anew = self._anew or self.interval == 0.0, False
        if self._hand.keeps_phase and not anew and not self._whereabouts.left:
            fence(states.share, states.head, states.offset, states.length, self.interval, self._place.into)
        total = tally(states.share, states.head, states.offset, states.length, states.histogram)
        if total <= 0.0:  # all that was believed is given up
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
        """Move the grid onto the mean of the states near it, and take the beat of the measure that most of them say."""
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
