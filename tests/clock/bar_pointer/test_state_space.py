"""The kernels against a forward filter over a dictionary of states, with a few tempi."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.bar_pointer.metre import METRES, USED, slot_metre
from live.clock.bar_pointer.observation_model import likelihoods
from live.clock.bar_pointer.state_space import REACH, BarPointerModel
from live.clock.bar_pointer.transition_model import FREE_RANGE
from tests.fixtures.mostly_long import mostly_long

WINDOW = 7  # frames in which a beat's activation may lie, the beat in the middle

# How often the beat of a metre (from 0) sounds like a downbeat: half of the measures, divided by the usual groupings.
ACCENTS = {
    (4, 2): 0.5, (6, 3): 0.5, (8, 4): 0.5, (5, 3): 0.25, (5, 2): 0.25, (7, 2): 0.25, (7, 4): 0.25, (7, 3): 0.25,
    (7, 5): 0.25, (9, 2): 0.25, (9, 4): 0.25, (9, 6): 0.5, (9, 3): 0.25,
}  # fmt: skip

State = tuple[int, int, int, int]  # interval, position, metre, beat

FEW = BarPointerModel(fastest_bpm=260.0, slowest_bpm=235.0, octave_change=0.0)


class ReferenceFilter:
    """The forward algorithm, state by state (Rabiner, A tutorial on hidden Markov models, 1989)."""

    def __init__(self, model: BarPointerModel) -> None:
        self.model = model
        self.lengths = [int(length) for length in model.intervals]
        self.tempo = (model.tempo_transitions() * model.tempo_weight()[:, None]).tolist()
        self.metres, self.share = model.metre_transitions().tolist(), model.tempo_share().tolist()
        self.slots = {slot_metre(slot): float(part) for slot, part in enumerate(model.slot_share()[:USED])}
        self.belief: dict[State, float] = {
            (n, p, *place): self.share[k] / n * part
            for k, n in enumerate(self.lengths)
            for p in range(n)
            for place, part in self.slots.items()
        }

    def step(self, other: float, first: float, between: float) -> None:
        """One frame with these likelihoods."""
        after = dict.fromkeys(self.belief, 0.0)
        for (n, p, metre, number), mass in self.belief.items():
            if p + 1 < n:
                after[n, p + 1, metre, number] += mass
            else:
                self._begin_beat(after, n, metre, number, mass)
        for (k, m), (place, part) in product(enumerate(self.lengths), self.slots.items()):
            after[m, 0, *place] += self.model.birth * self.share[k] * part
        for n, p, metre, number in after:
            if p < WINDOW:
                accent = 1.0 if number == 0 else ACCENTS.get((metre, number), 0.0)
                ratio = accent * first + (1.0 - accent) * other
                after[n, p, metre, number] *= 1.0 + self.model.window[p] * (ratio - 1.0)
            away = (p - n // 2) % n
            if away < WINDOW:
                after[n, p, metre, number] *= 1.0 + self.model.window[away] * (between - 1.0)
        total = sum(after.values())
        self.belief = {state: mass / total for state, mass in after.items()}

    def _begin_beat(self, after: dict[State, float], n: int, metre: int, number: int, mass: float) -> None:
        k = self.lengths.index(n)
        change = self.model.line_change
        for j, m in enumerate(self.lengths):
            moved = mass * self.tempo[k][j - k + REACH]
            for place, part in self.slots.items():
                after[m, 0, *place] += change * moved * part
            if number + 1 < metre:
                after[m, 0, metre, number + 1] += (1.0 - change) * moved
                continue
            for to, other in enumerate(METRES):
                after[m, 0, other, 0] += (1.0 - change) * moved * self.metres[METRES.index(metre)][to]


@mostly_long("birth", [0.0, FEW.birth, 1e-3], quick=[2])
def test_kernels_match_the_forward_algorithm(birth: float) -> None:
    model = replace(FEW, birth=birth)
    rng = np.random.default_rng(3)
    frames = [(0.8, 0.5) if t % 21 == 4 else (float(rng.random()) * 0.1, 0.01) for t in range(26)]
    pointer, slow = BarPointer(model), ReferenceFilter(model)
    for beat, downbeat in frames:
        pointer.step(beat, downbeat)
        said = likelihoods(model, beat, downbeat, FREE_RANGE, model.downbeat_sharpness)
        slow.step(*(float(value) for value in said))
    states = pointer._states
    positions = states.positions().astype(int)
    found = {
        (int(n), int(p), *slot_metre(slot)): float(states.share[row, slot])
        for row, (n, p) in enumerate(zip(states.row_interval, positions, strict=True))
        for slot in range(USED)
    }
    total = sum(found.values())
    assert found.keys() == slow.belief.keys()
    for state, mass in slow.belief.items():
        assert found[state] / total == pytest.approx(mass, rel=2e-3, abs=1e-7)


def test_state_probabilities_are_nonnegative_and_sum_to_one() -> None:
    pointer = BarPointer(FEW)
    for frame in range(9):
        pointer.step(0.9 if frame == 4 else 0.02, 0.01)
        if frame % 3 == 0:
            assert float(pointer._states.share.sum()) == pytest.approx(1.0, abs=1e-3)
    assert np.all(pointer._states.share >= 0.0)
    assert 0.0 <= pointer.share <= 1.0 + 1e-6
