"""Programme: sequences, seeded draws, called steps."""

import itertools

import numpy as np
import pytest

from live.graph.search.sequence_spec import SequenceEntry
from live.show.patch.section_motion import GroupSection, parse_entry
from live.show.score.step_names import UnknownStep, find_step
from live.show.score.step_program import StepProgram
from tests.show.made_show import GRAPH

NOBODY = np.zeros(1, np.int32)


def made(steps, seed=1, **options):
    section = GroupSection(name="a", dancers=1, steps=tuple(steps), **options)
    return StepProgram(GRAPH, section, seed=seed, index=0)


def names(programme, count):
    return [GRAPH.library.steps[programme.step_for(m, NOBODY)] for m in range(count)]


@pytest.mark.parametrize(
    ("entry", "parsed"),
    [
        ("groove", ("groove", 1)),
        ("groove x4", ("groove", 4)),
        ("side step x 12", ("side step", 12)),
        (" x2", ("x2", 1)),
    ],
)
def test_entries(entry, parsed):
    assert parse_entry(entry) == parsed


def test_a_sequence_counts_measures_and_begins_again():
    programme = made(["sway x2", "phrase", "spin"])
    assert names(programme, 10) == ["sway", "sway", "phrase", "phrase", "spin"] * 2


def test_draws_are_seeded_held_and_never_the_same_twice_in_a_row():
    steps = ["sway", "glide", "spin", "phrase"]
    drawn = names(made(steps, choose="random"), 400)
    assert drawn == names(made(steps, choose="random"), 400)
    assert drawn != names(made(steps, seed=2, choose="random"), 400)
    pairs = [drawn[m] for m in range(0, 400, 2)]
    assert pairs == [drawn[m] for m in range(1, 400, 2)]
    assert all(a != b for a, b in itertools.pairwise(pairs))
    counts = [pairs.count(step) for step in steps]
    assert min(counts) > 30


def test_a_call_holds_for_its_measures_and_the_sequence_goes_on_where_it_was():
    programme = made(["sway", "glide x2"])
    spin = find_step(GRAPH, "spin")
    assert names(programme, 2) == ["sway", "glide"]
    programme.call(spin, measures=1.5)
    assert [GRAPH.library.steps[programme.step_for(m, NOBODY)] for m in range(2, 6)] == [
        "spin",
        "spin",
        "glide",
        "sway",
    ]
    programme.call(spin, measures=100)
    programme.release()
    assert programme.step_for(6, NOBODY) != spin


def test_asking_again_changes_nothing():
    programme = made(["sway", "glide", "spin"])
    twice = [programme.step_for(m, NOBODY) for m in range(6) for _ in range(2)]
    assert twice[::2] == twice[1::2]
    assert [GRAPH.library.steps[s] for s in twice[::2]] == ["sway", "glide", "spin"] * 2


def test_a_call_waits_for_dancers_within_a_longer_step():
    """In the first measure of the phrase nobody can follow a call: it is not used up, and the phrase begins anew."""
    programme = made(["phrase", "sway"])
    phrase = GRAPH.library.steps.index("phrase")
    first, second = np.flatnonzero(GRAPH.library.node_step == phrase).astype(np.int32)
    spin = find_step(GRAPH, "spin")
    assert programme.step_for(0, NOBODY) == phrase
    programme.call(spin, measures=1)
    assert programme.step_for(1, np.array([first])) == phrase
    assert programme.step_for(2, np.array([second])) == spin
    assert GRAPH.library.steps[programme.step_for(3, NOBODY)] == "sway"


def test_before_the_first_downbeat_it_is_the_first_step():
    programme = made(["glide", "sway"])
    assert [GRAPH.library.steps[programme.step_for(m, NOBODY)] for m in (-2, -1, 0, 1)] == [
        "glide",
        "glide",
        "glide",
        "sway",
    ]


def test_an_unknown_step_names_its_neighbours():
    with pytest.raises(UnknownStep, match=r"did you mean 'glide'.*sway, glide, spin, phrase"):
        made(["glied"])


def live(*steps):
    return [SequenceEntry(find_step(GRAPH, step), 1) for step in steps]


@pytest.mark.parametrize(
    ("change", "danced"),
    [
        (lambda programme: programme.release(), ["sway", "sway"]),
        (lambda programme: programme.set_sequence(live("spin")), ["spin", "spin"]),
        (lambda programme: programme.call(find_step(GRAPH, "spin"), measures=1), ["spin", "glide"]),
        (lambda programme: programme.apply_patch(made(["spin"])), ["glide", "glide"]),
    ],
    ids=["release", "dance", "call", "patch"],
)
def test_what_is_asked_for_while_a_measure_is_planned_outlives_that_plan(change, danced):
    """`/dance/clear` and `/dance/practice` in one bundle, a beat before the line, ended the show by an IndexError."""
    programme = made(["sway"])
    programme.set_sequence(live("glide", "glide", "glide", "glide", "glide"))
    names(programme, 4)
    change(programme)
    programme.undo(3)
    assert [GRAPH.library.steps[programme.step_for(m, NOBODY)] for m in range(3, 5)] == danced


def test_a_shorter_sequence_of_the_patch_is_taken_while_a_measure_is_planned():
    programme = made(["sway", "sway", "sway", "glide"])
    names(programme, 4)  # the next one is the first again, and the last one may be taken back
    programme.apply_patch(made(["sway", "spin"]))
    programme.undo(3)
    assert [GRAPH.library.steps[programme.step_for(m, NOBODY)] for m in range(3, 6)] == ["sway", "spin", "sway"]
