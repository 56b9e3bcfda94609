"""Recordings: a patch danced with them has their meter and all their steps, also after edits."""

from live.show.loader import adapt_edited_patch, adapt_to_recordings, with_connected_steps
from live.show.patch.patch_reader import parse_patch
from tests.fixtures.made_steps import made_steps
from tests.show.made_show import GRAPH, PATCH


def test_meter_is_that_of_most_clips_and_transitions_take_one_beat():
    clips = made_steps()
    patch = adapt_to_recordings(parse_patch(PATCH, "test.toml"), clips)
    metres = [clip.beats_per_measure for clip in clips]
    assert metres.count(patch.clock.beats_per_measure) >= max(metres.count(metre) for metre in metres)
    assert patch.locomotion.transition_beats == 1.0


def test_groups_draw_from_all_connected_steps():
    patch = with_connected_steps(parse_patch(PATCH, "test.toml"), GRAPH)
    for group in patch.group:
        if not group.like:
            assert group.choose == "random"
            assert {entry.rsplit(" ", 1)[0] for entry in group.steps} <= set(GRAPH.library.steps)


def test_edited_patch_keeps_its_adaptation_to_recordings():
    edited = parse_patch(PATCH, "test.toml")
    running = adapt_to_recordings(edited, made_steps())
    assert adapt_edited_patch(edited, GRAPH, running, recordings=False) is edited
    found = adapt_edited_patch(edited, GRAPH, running, recordings=True)
    assert found.locomotion.transition_beats == running.locomotion.transition_beats
    assert found.clock.beats_per_measure == running.clock.beats_per_measure
    assert found.group == with_connected_steps(edited, GRAPH).group


def test_reactions_and_keys_with_missing_steps_are_dropped():
    """A patch of sketched steps is danced with recordings: it starts without the calls of steps that do not exist."""
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
