"""Step sequences of the score: their measures, the return to the group's steps, jumps, and refusals."""

import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import made_show


def steps_of(show, seconds, group=0, *, does=None):
    """The step that most dancers of a group dance in each measure; `does`: events by tick."""
    library, danced = show.graph.library, []
    for tick in range(1, round(64 * seconds)):
        if does and tick in does:
            show.apply(does[tick](tick * TICK))
        if show.tick(tick * TICK) or tick == 1:
            names = [library.steps[library.node_step[node]] for node in show.dancers.node[show.group == group]]
            danced.append(max(set(names), key=names.count))
    return danced


def test_sequence_holds_in_its_measures_and_group_steps_resume():
    show = made_show('[[sequence]]\ngroup = "front"\nmeasure = 3\nsteps = ["spin x2", "phrase"]\n')
    own = ["sway", "glide", "glide", "spin", "phrase", "phrase"]
    assert steps_of(show, 24) == [*own[:2], "spin", "spin", "phrase", "phrase", *own[2:], *own[:2]]


@pytest.mark.long
def test_section_sequence_repeats_in_every_pass():
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 2\n[[section]]\nname = "b"\nmeasures = 1\n'
        '[[sequence]]\nsection = "a"\nmeasure = 2\nsteps = ["spin"]\n'
        '[[sequence]]\nsection = "b"\nsteps = ["sway"]\n'
    )
    danced = steps_of(show, 22)
    assert [danced[measure] for measure in (1, 3, 6, 8)] == ["spin"] * 4
    assert [danced[measure] for measure in (4, 9)] == ["sway"] * 2


@pytest.mark.long
def test_longer_span_repeats_its_steps():
    table = '[[sequence]]\nmeasures = 6\nsteps = ["glide", "spin"]\n'
    for group in (0, 1):
        assert steps_of(made_show(table), 12, group)[:6] == ["glide", "spin"] * 3


def test_called_step_overrides_the_score():
    show = made_show('[[sequence]]\nmeasures = 8\nsteps = ["sway"]\n')
    call = {64: lambda time: events.CallStep(time=time, source="osc", name="spin", measures=2.0)}
    assert steps_of(show, 15, does=call)[:5] == ["sway", "spin", "spin", "sway", "sway"]


SECTIONS = (
    '[[section]]\nname = "a"\nmeasures = 4\n[[section]]\nname = "b"\nmeasures = 4\n'
    '[[sequence]]\nsection = "a"\nmeasures = 4\nsteps = ["sway"]\n'
    '[[sequence]]\nsection = "b"\nsteps = ["spin", "glide", "spin", "glide"]\n'
)


@mostly_long("beat", [4.5, 5.9, 6.3, 6.7], quick=[3])
def test_a_jump_before_the_decision_changes_the_coming_measure(beat):
    """Measure 2 is decided at beat 7; its planning starts at beat 6.25 and is then restarted."""
    jump = {round(32 * beat): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    show = made_show(SECTIONS)
    assert steps_of(show, 13, does=jump)[:6] == ["sway", "sway", "spin", "glide", "spin", "glide"]
    assert show.score_runner.facts()["score"]["late_jumps"] == 0


@pytest.mark.long
def test_jump_after_decision_keeps_decided_step_and_reports_it():
    jump = {round(32 * 7.4): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    show = made_show(SECTIONS)
    assert steps_of(show, 13, does=jump)[:6] == ["sway", "sway", "sway", "glide", "spin", "glide"]
    facts = show.score_runner.facts()
    assert facts["score"]["late_jumps"] == 1
    assert "decided already" in facts["score"]["said"]
    assert facts["score"]["said_measure"] == 2


@pytest.mark.long
def test_late_jump_report_stays_in_facts_and_leaves_overlay():
    """The facts still explain the count later; the overlay shows only recent messages."""
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


@pytest.mark.long
def test_replanning_for_same_target_changes_nothing():
    """A jump to the next position anyway, during planning, leaves bit-identical states."""
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
def test_step_longer_than_rest_of_sequence_is_refused(table, words):
    if words is None:
        made_show(f"[[sequence]]\n{table}\n")
        return
    with pytest.raises(PersonError) as caught:
        made_show(f"[[sequence]]\n{table}\n")
    assert words in str(caught.value)


@mostly_long("call", ['"/dance/step"\nvalues = ["spin", 1]', '"/dance/sequence"\nvalues = ["spin"]'], quick=[1])
def test_step_called_by_score_is_danced_from_its_measure(call):
    danced = steps_of(made_show(f"[[at]]\nmeasure = 4\ncall = {call}\n"), 10)
    assert danced[:3] == ["sway", "glide", "glide"]
    assert danced[3] == "spin"


def test_jump_cancels_step_calls_given_ahead():
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 4\n[[section]]\nname = "b"\nmeasures = 4\n'
        '[[at]]\nsection = "a"\nmeasure = 3\ncall = "/dance/step"\nvalues = ["spin", 4]\n'
        '[[at]]\nsection = "b"\nmeasure = 1\ncall = "/dance/step"\nvalues = ["sway", 2]\n'
    )
    jump = {round(32 * 5.5): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    assert steps_of(show, 9, does=jump)[:4] == ["sway", "glide", "sway", "sway"]
