"""Cues: GO at now, beat, measure and section, count-in, bounces, auto, back, panic, hold, replayed bit by bit."""

import pytest

from live.control.events.event_json import event_from_json, event_to_json
from live.control.registry.registry import REGISTRY
from live.show.patch.patch_search_path import PatchError
from tests.show.desk.desk_show import DESK, Hands


@pytest.fixture
def hands():
    return Hands().run(5)


def place(hands):
    playhead = hands.show.playhead
    here = playhead.place(playhead.measure)
    return playhead.sections[here.section].name, here.measure


def test_go_waits_for_its_count_in_and_then_for_the_measure_line(hands):
    assert hands.cues["standby"] == "dim"
    assert hands.cues["text"] == "lights down"
    assert hands.say("/dance/go")
    assert hands.cues["counting_in"] == [{"cue": "dim", "beats": 7.0}]  # 4 beats from beat 5 on, then line 12
    assert hands.cues["standby"] == "solo"
    hands.run(7, -1)
    assert hands.cues["fired"] == 0
    view = hands.show.view()
    hands.show.fill(view, hands.ticks / 64)
    assert view.count_in == pytest.approx(1 / 32, abs=1e-6)
    assert any(line.startswith("GO in 1 beats: dim") for line in hands.desk.status_lines(hands.show.danced_beats))
    hands.run(ticks=1)
    assert hands.cues["fired"] == 1
    assert hands.cues["last"] == "dim"
    hands.run(4)
    assert hands.value("/dance/light/level") == 0.25


def test_a_bounce_is_no_second_go_but_another_source_may_go(hands):
    hands.say("/dance/go")
    hands.run(ticks=15)  # 0.234 s
    assert hands.say("/dance/go")
    assert hands.cues["bounced"] == 1
    assert hands.cues["standby"] == "solo"
    hands.say("/dance/go", source="osc")
    assert hands.cues["standby"] == "up"
    hands.run(ticks=1)
    hands.say("/dance/go")  # 0.25 s after the first press
    assert hands.cues["standby"] == "top"


def test_a_cue_takes_the_score_to_its_section_with_the_line_of_its_scene(hands):
    hands.say("/dance/cue", "solo")
    hands.run(3, -1)
    assert place(hands) == ("verse", 1)
    hands.run(ticks=1)
    assert place(hands) == ("solo", 0)
    assert hands.cues["last"] == "solo"
    hands.run(1)
    view = hands.show.view()
    hands.show.fill(view, hands.ticks / 64)
    assert view.element_count == 1
    assert hands.cues["counting_in"] == [{"cue": "up", "beats": 7.0}]  # by itself, two measures later
    hands.run(7)
    assert hands.cues["last"] == "up"
    hands.run(4 * 1)
    assert place(hands) == ("verse", 0)


def test_beat_and_section(hands):
    hands.run(ticks=7)
    hands.say("/dance/cue", "up")
    assert hands.cues["counting_in"][0]["beats"] == pytest.approx(25 / 32, abs=0.01)
    hands.run(1)
    assert hands.cues["last"] == "up"
    hands.say("/dance/cue", "top")
    hands.run(ticks=1)
    assert hands.cues["counting_in"][0]["beats"] == pytest.approx(16 - hands.show.danced_beats, abs=0.01)
    hands.say("/dance/section", "solo")  # the section begins sooner
    hands.run(2)
    assert hands.cues["last"] == "top"
    assert place(hands) == ("solo", 0)


def test_back_takes_back_what_counts_in_and_its_jump_then_steps_back(hands):
    hands.say("/dance/cue", "solo")
    assert hands.say("/dance/back")
    assert hands.cues["standby"] == "solo"
    assert hands.cues["counting_in"] == []
    hands.run(4)
    assert place(hands) == ("verse", 2)
    assert hands.cues["fired"] == 0
    assert hands.say("/dance/back")
    assert hands.cues["standby"] == "dim"
    assert not hands.say("/dance/back")


def test_cues_are_found_by_name_and_number_and_others_refused(hands):
    assert hands.say("/dance/standby", "2.5")
    assert hands.cues["standby"] == "solo"
    assert hands.say("/dance/standby", " TOP ")
    hands.say("/dance/go")
    assert hands.cues["standby"] is None
    hands.run(1)
    assert not hands.say("/dance/go")
    assert "no cue stands by" in hands.words
    assert not hands.say("/dance/cue", "nowhere")
    assert "dim, solo, up, top" in hands.words
    for _ in range(20):
        hands.say("/dance/cue", "top")
    assert len(hands.cues["counting_in"]) == 16


def test_hold_stops_score_fades_and_cues_and_the_beat_goes_on(hands):
    hands.say("/dance/light/level", 0.0, 1)
    hands.run(2)
    hands.say("/dance/go")
    hands.say("/dance/hold", 1)
    level, where, node = hands.value("/dance/light/level"), place(hands), hands.show.dancers.present.node.copy()
    hands.run(12)
    assert hands.value("/dance/light/level") == level == pytest.approx(0.5)
    assert place(hands) == where
    assert hands.cues["fired"] == 0
    assert hands.show.span.number == 4
    assert (hands.show.dancers.present.node != node).any()
    hands.say("/dance/hold", 0)
    hands.run(1 - 1 / 32)
    assert hands.cues["fired"] == 0  # the line it was to come with has passed: it comes with the next one
    hands.run(1 / 32)
    assert hands.cues["fired"] == 1


def test_panic_calms_everything_and_go_goes_on(hands):
    hands.say("/dance/attract", 1.0, 1.0, 1.0, 100)
    hands.say("/dance/scene", "low", 0)
    hands.say("/dance/step", "spin", 50)
    hands.say("/dance/go")
    hands.run(1)
    tempo, beat = hands.show.timeline.tempo, hands.show.danced_beats
    hands.say("/dance/panic")
    hands.run(4)
    assert hands.value("/dance/light/level") == 1.0
    assert hands.show.variation.settings[0].larger == 0.0
    assert hands.cues["held"]
    assert hands.cues["standby"] == "dim"
    assert hands.cues["counting_in"] == []
    assert hands.show.timeline.tempo == tempo
    assert hands.show.danced_beats == pytest.approx(beat + 4)
    view = hands.show.view()
    hands.show.fill(view, hands.ticks / 64)
    assert view.element_count == 0
    assert any("HELD" in line for line in hands.desk.status_lines(hands.show.danced_beats))
    hands.say("/dance/go")
    assert not hands.cues["held"]
    assert not hands.show.playhead.held


def test_an_edited_score_keeps_the_cue_that_stands_by():
    hands = Hands().run(1)
    hands.say("/dance/standby", "up")
    hands.say("/dance/go")
    fresh = Hands(DESK.replace('name = "dim"', 'name = "new"\n[[cue]]\nname = "dim"', 1))
    hands.desk.cues.apply_patch(fresh.desk.cues)
    assert hands.cues["standby"] == "top"
    hands.run(1)
    assert hands.cues["last"] == "up"
    hands.desk.cues.apply_patch(Hands("").desk.cues)
    assert hands.cues["standby"] is None
    assert hands.cues["last"] is None


def test_cues_are_replayed_bit_by_bit():
    said = [(5, "/dance/go"), (6, "/dance/light/key", 2.0, 3), (9, "/dance/cue", "solo"), (14, "/dance/undo"),
            (20, "/dance/panic"), (24, "/dance/go")]  # fmt: skip
    lines = []
    first = Hands()
    for beat, address, *values in said:
        first.run(beat - first.ticks / 32)
        event = REGISTRY.call(address, values, first.ticks / 64, "key")
        lines.append((first.ticks, event_to_json(event)))
        first.show.apply(event)
    first.run(10)
    second = Hands()
    for tick, line in lines:
        second.run(ticks=tick - second.ticks)
        second.show.apply(event_from_json(line))
    second.run(ticks=first.ticks - second.ticks)
    assert second.show.state_hash() == first.show.state_hash()
    assert second.cues == first.cues
    assert first.cues["fired"] >= 2


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('scene = "nowhere"', "no scene is called 'nowhere'"),
        ('section = "nowhere"', "no section is called 'nowhere'"),
        ('when = "section"', "the patch has no [[section]]"),
        ('when = "later"', "'now', 'beat', 'measure' or 'section'"),
        ('calls = [["/dance/nothing"]]', "unknown address"),
        ('calls = [["/dance/step"]]', "missing argument"),
        ("count_in = -1", "greater than or equal to 0"),
        ("measures = 2", "measures go with scene"),
        ("after = 2", "after goes with then"),
        ('calls = [["/dance/standby", "nowhere"]]', "call /dance/standby: no cue is called 'nowhere'; there are: x"),
        ('number = 2\n[[cue]]\nname = "y"\nnumber = 2', "cues 'x' and 'y' both have number 2"),
    ],
)
def test_a_cue_to_nowhere_is_named_with_its_line(lines, words):
    with pytest.raises(PatchError) as error:
        Hands(f'[[cue]]\nname = "x"\n{lines}\n')
    assert words in str(error.value)
    assert "test.toml, line 2" in str(error.value)


def test_after_a_panic_neither_score_nor_music_calls_anything_until_it_goes_on():
    text = (
        '[[section]]\nname = "a"\nmeasures = 1\nwait = true\n[[at]]\nmeasure = 1\nbeat = 3.0\ncall = "/dance/spread"\n'
    )
    text += (
        '[[signal]]\nname = "hit"\nmeasure = 1\n[[react]]\non = "hit"\ncall = "/dance/attract"\nvalues = [1.0, 1.0]\n'
    )
    hands = Hands(text).run(5)
    hands.say("/dance/panic")
    hands.run(6)
    view = hands.show.view()
    hands.say("/dance/signal", "hit")
    hands.run(5)
    hands.show.fill(view, hands.ticks / 64)
    assert view.element_count == 0
    hands.say("/dance/hold", 0)
    hands.run(8)
    hands.show.fill(view, hands.ticks / 64)
    assert view.element_count >= 1


def test_every_cue_happens_in_the_tick_that_holds_its_beat(hands):
    for name in ("dim", "up", "solo", "top"):
        hands.say("/dance/cue", name)
        hands.run(ticks=37)
    hands.run(30)
    assert hands.cues["fired"] == 5  # one came by itself
    assert hands.cues["late_ticks_max"] == 0
