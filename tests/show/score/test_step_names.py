"""StepProgram: sequences, seeded draws and called steps."""

import itertools

import numpy as np
import pytest

from live.graph.search.sequence_spec import SequenceEntry
from live.show.patch.section_motion import GroupSection, parse_entry
from live.show.score.step_names import UnknownStep, find_step
from live.show.score.step_program import StepProgram
from tests.show.made_show import GRAPH

NO_DANCERS = np.zeros(1, np.int32)


def make_program(steps, seed=1, **options):
    section = GroupSection(name="a", dancers=1, steps=tuple(steps), **options)
    return StepProgram(GRAPH, section, seed=seed, index=0)


def danced_names(programme, count):
    return [GRAPH.library.steps[programme.step_for(m, NO_DANCERS)] for m in range(count)]


@pytest.mark.parametrize(
    ("entry", "parsed"),
    [
        ("groove", ("groove", 1)),
        ("groove x4", ("groove", 4)),
        ("side step x 12", ("side step", 12)),
        (" x2", ("x2", 1)),
    ],
)
def test_step_entries_are_parsed(entry, parsed):
    assert parse_entry(entry) == parsed


def test_sequence_counts_measures_and_repeats():
    programme = make_program(["sway x2", "phrase", "spin"])
    assert danced_names(programme, 10) == ["sway", "sway", "phrase", "phrase", "spin"] * 2


def test_draws_are_seeded_held_and_never_repeated():
    steps = ["sway", "glide", "spin", "phrase"]
    drawn = danced_names(make_program(steps, choose="random"), 400)
    assert drawn == danced_names(make_program(steps, choose="random"), 400)
    assert drawn != danced_names(make_program(steps, seed=2, choose="random"), 400)
    pairs = [drawn[m] for m in range(0, 400, 2)]
    assert pairs == [drawn[m] for m in range(1, 400, 2)]
    assert all(a != b for a, b in itertools.pairwise(pairs))
    counts = [pairs.count(step) for step in steps]
    assert min(counts) > 30


def test_called_step_holds_for_its_measures_then_sequence_resumes():
    programme = make_program(["sway", "glide x2"])
    spin = find_step(GRAPH, "spin")
    assert danced_names(programme, 2) == ["sway", "glide"]
    programme.call(spin, measures=1.5)
    assert [GRAPH.library.steps[programme.step_for(m, NO_DANCERS)] for m in range(2, 6)] == [
        "spin",
        "spin",
        "glide",
        "sway",
    ]
    programme.call(spin, measures=100)
    programme.release()
    assert programme.step_for(6, NO_DANCERS) != spin


def test_repeated_query_returns_the_same_step():
    programme = make_program(["sway", "glide", "spin"])
    twice = [programme.step_for(m, NO_DANCERS) for m in range(6) for _ in range(2)]
    assert twice[::2] == twice[1::2]
    assert [GRAPH.library.steps[s] for s in twice[::2]] == ["sway", "glide", "spin"] * 2


def test_called_step_waits_until_longer_step_ends():
    """In the first measure of the phrase no dancer can follow a call: it is kept, and the phrase starts again later."""
    programme = make_program(["phrase", "sway"])
    phrase = GRAPH.library.steps.index("phrase")
    first, second = np.flatnonzero(GRAPH.library.node_step == phrase).astype(np.int32)
    spin = find_step(GRAPH, "spin")
    assert programme.step_for(0, NO_DANCERS) == phrase
    programme.call(spin, measures=1)
    assert programme.step_for(1, np.array([first])) == phrase
    assert programme.step_for(2, np.array([second])) == spin
    assert GRAPH.library.steps[programme.step_for(3, NO_DANCERS)] == "sway"


def test_first_step_is_danced_before_first_downbeat():
    programme = make_program(["glide", "sway"])
    assert [GRAPH.library.steps[programme.step_for(m, NO_DANCERS)] for m in (-2, -1, 0, 1)] == [
        "glide",
        "glide",
        "glide",
        "sway",
    ]


def test_unknown_step_error_names_nearest_steps():
    with pytest.raises(UnknownStep, match=r"did you mean 'glide'.*sway, glide, spin, phrase"):
        make_program(["glied"])


def live_entries(*steps):
    return [SequenceEntry(find_step(GRAPH, step), 1) for step in steps]


@pytest.mark.parametrize(
    ("change", "danced"),
    [
        (lambda programme: programme.release(), ["sway", "sway"]),
        (lambda programme: programme.set_sequence(live_entries("spin")), ["spin", "spin"]),
        (lambda programme: programme.call(find_step(GRAPH, "spin"), measures=1), ["spin", "glide"]),
        (lambda programme: programme.apply_patch(make_program(["spin"])), ["glide", "glide"]),
    ],
    ids=["release", "dance", "call", "patch"],
)
def test_request_during_planning_survives_undo_of_the_plan(change, danced):
    """`/dance/clear` and `/dance/practice` in one bundle, a beat before the line, once raised an IndexError."""
    programme = make_program(["sway"])
    programme.set_sequence(live_entries("glide", "glide", "glide", "glide", "glide"))
    danced_names(programme, 4)
    change(programme)
    programme.undo(3)
    assert [GRAPH.library.steps[programme.step_for(m, NO_DANCERS)] for m in range(3, 5)] == danced


def test_shorter_patch_sequence_is_applied_during_planning():
    programme = make_program(["sway", "sway", "sway", "glide"])
    danced_names(programme, 4)  # the next one is the first again, and the last one may be taken back
    programme.apply_patch(make_program(["sway", "spin"]))
    programme.undo(3)
    assert [GRAPH.library.steps[programme.step_for(m, NO_DANCERS)] for m in range(3, 6)] == ["sway", "spin", "sway"]
