"""Recorded: a patch that is danced with recordings has their metre and all their steps; edits of it stay so."""

from live.show.loader import adapt_edited_patch, adapt_to_recordings, with_connected_steps
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.made_steps import made_steps
from tests.show.made_show import GRAPH, PATCH


def test_the_metre_is_that_of_most_clips_and_blends_take_a_beat():
    clips = made_steps()
    patch = adapt_to_recordings(parse_patch(PATCH, "test.toml"), clips)
    metres = [clip.beats_per_measure for clip in clips]
    assert metres.count(patch.clock.beats_per_measure) >= max(metres.count(metre) for metre in metres)
    assert patch.locomotion.transition_beats == 1.0


def test_groups_draw_from_all_steps_that_connect():
    patch = with_connected_steps(parse_patch(PATCH, "test.toml"), GRAPH)
    for group in patch.group:
        if not group.like:
            assert group.choose == "random"
            assert {entry.rsplit(" ", 1)[0] for entry in group.steps} <= set(GRAPH.library.steps)


def test_an_edited_patch_keeps_what_recordings_made_of_it():
    edited = parse_patch(PATCH, "test.toml")
    running = adapt_to_recordings(edited, made_steps())
    assert adapt_edited_patch(edited, GRAPH, running, recordings=False) is edited
    found = adapt_edited_patch(edited, GRAPH, running, recordings=True)
    assert found.locomotion.transition_beats == running.locomotion.transition_beats
    assert found.clock.beats_per_measure == running.clock.beats_per_measure
    assert found.group == with_connected_steps(edited, GRAPH).group


def test_what_is_heard_or_played_calls_no_step_that_the_recordings_do_not_have():
    """A show of sketches is danced with recordings: it starts, and what it cannot call it does not."""
    extra = "".join(
        f'[[react]]\non = "drop"\ncall = "/dance/{call}"\nvalues = ["{step}"]\n'
        for call, step in (("step", "moonwalk"), ("step", "spin"), ("sequence", "spin, moonwalk"), ("spread", ""))
    ).replace('values = [""]\n', "")
    keys = "".join(
        f'[[midi.map]]\nnote = {note}\ncontrol = "/dance/step"\nvalues = {{name = "{step}"}}\n'
        for note, step in enumerate(("moonwalk", "spin"))
    )
    patch = with_connected_steps(parse_patch(PATCH + extra + keys, "test.toml"), GRAPH)
    assert [(reaction.call, reaction.values) for reaction in patch.react] == [
        ("/dance/step", ("spin",)),
        ("/dance/spread", ()),
    ]
    assert [line.note for line in patch.midi.map] == [1]
