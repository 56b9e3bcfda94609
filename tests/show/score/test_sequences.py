"""What the score has for a group's steps: in its measures, back to the group's own, at jumps, and what is refused."""

import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from tests.show.made_show import made_show


def steps_of(show, seconds, group=0, *, does=None):
    """The step that (nearly) all dancers of a group dance in each measure; `does` by tick."""
    library, danced = show.graph.library, []
    for tick in range(1, round(64 * seconds)):
        if does and tick in does:
            show.apply(does[tick](tick * TICK))
        if show.tick(tick * TICK) or tick == 1:
            names = [library.steps[library.node_step[node]] for node in show.dancers.node[show.group == group]]
            danced.append(max(set(names), key=names.count))
    return danced


def test_a_sequence_holds_in_its_measures_and_the_groups_own_steps_go_on_where_they_were():
    show = made_show('[[sequence]]\ngroup = "front"\nmeasure = 3\nsteps = ["spin x2", "phrase"]\n')
    own = ["sway", "glide", "glide", "spin", "phrase", "phrase"]
    assert steps_of(show, 24) == [*own[:2], "spin", "spin", "phrase", "phrase", *own[2:], *own[:2]]


def test_a_sequence_of_a_section_comes_with_each_of_its_passes():
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 2\n[[section]]\nname = "b"\nmeasures = 1\n'
        '[[sequence]]\nsection = "a"\nmeasure = 2\nsteps = ["spin"]\n'
        '[[sequence]]\nsection = "b"\nsteps = ["sway"]\n'
    )
    danced = steps_of(show, 22)
    assert [danced[measure] for measure in (1, 3, 6, 8)] == ["spin"] * 4
    assert [danced[measure] for measure in (4, 9)] == ["sway"] * 2


def test_a_longer_span_dances_its_steps_again_and_again():
    table = '[[sequence]]\nmeasures = 6\nsteps = ["glide", "spin"]\n'
    for group in (0, 1):
        assert steps_of(made_show(table), 12, group)[:6] == ["glide", "spin"] * 3


def test_a_call_comes_before_the_score():
    show = made_show('[[sequence]]\nmeasures = 8\nsteps = ["sway"]\n')
    call = {64: lambda time: events.CallStep(time=time, source="osc", name="spin", measures=2.0)}
    assert steps_of(show, 15, does=call)[:5] == ["sway", "spin", "spin", "sway", "sway"]


SECTIONS = (
    '[[section]]\nname = "a"\nmeasures = 4\n[[section]]\nname = "b"\nmeasures = 4\n'
    '[[sequence]]\nsection = "a"\nmeasures = 4\nsteps = ["sway"]\n'
    '[[sequence]]\nsection = "b"\nsteps = ["spin", "glide", "spin", "glide"]\n'
)


@pytest.mark.parametrize("beat", [4.5, 5.9, 6.3, 6.7])
def test_a_jump_before_the_decision_changes_the_coming_measure(beat):
    """Measure 2 is decided at beat 7; from beat 6.25 on it is being planned, and then planned anew."""
    jump = {round(32 * beat): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    show = made_show(SECTIONS)
    assert steps_of(show, 13, does=jump)[:6] == ["sway", "sway", "spin", "glide", "spin", "glide"]
    assert show.score_runner.facts()["score"]["late_jumps"] == 0


def test_a_jump_after_the_decision_dances_what_was_decided_and_says_so():
    jump = {round(32 * 7.4): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    show = made_show(SECTIONS)
    assert steps_of(show, 13, does=jump)[:6] == ["sway", "sway", "sway", "glide", "spin", "glide"]
    facts = show.score_runner.facts()
    assert facts["score"]["late_jumps"] == 1
    assert "decided already" in facts["score"]["said"]
    assert facts["score"]["said_measure"] == 2


def test_what_was_said_of_a_jump_stays_with_its_measure_and_leaves_the_overlay():
    """Whoever looks a minute later still finds what the count means; the overlay tells news only."""
    late = {round(32 * 7.4): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    held = {32 * 13: lambda time: events.HoldScore(time=time, source="osc", on=False)}
    show = made_show(SECTIONS)
    steps_of(show, 5, does=late)
    assert any("decided already" in line for line in show.score_runner.status_lines())
    show = made_show(SECTIONS)
    steps_of(show, 17, does=late | held)
    facts = show.score_runner.facts()["score"]
    assert "decided already" in facts["said"]
    assert facts["said_measure"] == 2
    assert not any("decided already" in line for line in show.score_runner.status_lines())


def test_planning_anew_for_nothing_changes_nothing():
    """A jump to where the score goes anyway, in the midst of the planning: the same dance, bit by bit."""
    show, plain = made_show(SECTIONS), made_show(SECTIONS)
    again = round(32 * 6.5)
    for tick in range(1, 64 * 9):
        if tick == again:
            show.apply(events.JumpTo(time=tick * TICK, source="osc", section="a", measure=4))
            show.apply(events.JumpTo(time=tick * TICK, source="osc", section="a", measure=3))
        for one in (show, plain):
            one.tick(tick * TICK)
    assert show.state_hash() == plain.state_hash()


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('measures = 3\nsteps = ["phrase"]', "'phrase' has 2 measures, and only 1 of the 3"),
        ('steps = ["moonwalk"]', "no step 'moonwalk'"),
        ('measures = 3\nsteps = ["sway", "phrase", "spin", "phrase"]\nmeasure = 7', None),
        ('measures = 5\nsteps = ["sway", "phrase", "spin", "phrase"]\nmeasure = 7', "measure 7"),
    ],
)
def test_steps_that_do_not_end_with_their_sequence_are_named(table, words):
    if words is None:
        made_show(f"[[sequence]]\n{table}\n")
        return
    with pytest.raises(PersonError) as caught:
        made_show(f"[[sequence]]\n{table}\n")
    assert words in str(caught.value)


@pytest.mark.parametrize("call", ['"/dance/step"\nvalues = ["spin", 1]', '"/dance/sequence"\nvalues = ["spin"]'])
def test_steps_that_the_score_calls_at_a_line_are_danced_from_that_line_on(call):
    danced = steps_of(made_show(f"[[at]]\nmeasure = 4\ncall = {call}\n"), 10)
    assert danced[:3] == ["sway", "glide", "glide"]
    assert danced[3] == "spin"


def test_what_was_given_ahead_is_taken_back_with_a_jump():
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 4\n[[section]]\nname = "b"\nmeasures = 4\n'
        '[[at]]\nsection = "a"\nmeasure = 3\ncall = "/dance/step"\nvalues = ["spin", 4]\n'
        '[[at]]\nsection = "b"\nmeasure = 1\ncall = "/dance/step"\nvalues = ["sway", 2]\n'
    )
    jump = {round(32 * 5.5): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    assert steps_of(show, 9, does=jump)[:4] == ["sway", "glide", "sway", "sway"]
