"""Tests of cues: GO at now, beat, measure and section, count-in, bounces, auto, back, panic, hold and replay."""

import pytest

from live.base.motion_parameters import LARGER
from live.control.events.event_json import event_from_json, event_to_json
from live.control.registry.registry import REGISTRY
from live.show.patch.patch_search_path import PatchError
from tests.show.desk.desk_show import DESK, DeskSession


@pytest.fixture
def session():
    return DeskSession().run(5)


def score_position(session):
    playhead = session.show.playhead
    here = playhead.place(playhead.measure)
    return playhead.sections[here.section].name, here.measure


def test_go_waits_for_count_in_and_measure_line(session):
    assert session.cues["standby"] == "dim"
    assert session.cues["text"] == "lights down"
    assert session.say("/dance/go")
    assert session.cues["counting_in"] == [{"cue": "dim", "beats": 7.0}]  # 4 beats from beat 5 on, then line 12
    assert session.cues["standby"] == "solo"
    session.run(7, -1)
    assert session.cues["fired"] == 0
    view = session.show.view()
    session.show.fill(view, session.ticks / 64)
    assert view.count_in == pytest.approx(1 / 32, abs=1e-6)
    assert any(line.startswith("GO in 1 beats: dim") for line in session.desk.status_lines(session.show.danced_beats))
    session.run(ticks=1)
    assert session.cues["fired"] == 1
    assert session.cues["last"] == "dim"
    session.run(4)
    assert session.value("/dance/light/level") == 0.25


def test_bounce_is_ignored_but_go_from_another_source_counts(session):
    session.say("/dance/go")
    session.run(ticks=15)  # 0.234 s
    assert session.say("/dance/go")
    assert session.cues["bounced"] == 1
    assert session.cues["standby"] == "solo"
    session.say("/dance/go", source="osc")
    assert session.cues["standby"] == "up"
    session.run(ticks=1)
    session.say("/dance/go")  # 0.25 s after the first press
    assert session.cues["standby"] == "top"


@pytest.mark.long
def test_cue_jumps_to_section_at_measure_line(session):
    session.say("/dance/cue", "solo")
    session.run(3, -1)
    assert score_position(session) == ("verse", 1)
    session.run(ticks=1)
    assert score_position(session) == ("solo", 0)
    assert session.cues["last"] == "solo"
    session.run(1)
    view = session.show.view()
    session.show.fill(view, session.ticks / 64)
    assert view.element_count == 1
    assert session.cues["counting_in"] == [{"cue": "up", "beats": 7.0}]  # by itself, two measures later
    session.run(7)
    assert session.cues["last"] == "up"
    session.run(4 * 1)
    assert score_position(session) == ("verse", 0)


@pytest.mark.long
def test_cues_fire_at_beat_and_at_section_start(session):
    session.run(ticks=7)
    session.say("/dance/cue", "up")
    assert session.cues["counting_in"][0]["beats"] == pytest.approx(25 / 32, abs=0.01)
    session.run(1)
    assert session.cues["last"] == "up"
    session.say("/dance/cue", "top")
    session.run(ticks=1)
    assert session.cues["counting_in"][0]["beats"] == pytest.approx(16 - session.show.danced_beats, abs=0.01)
    session.say("/dance/section", "solo")  # the section begins sooner
    session.run(2)
    assert session.cues["last"] == "top"
    assert score_position(session) == ("solo", 0)


@pytest.mark.long
def test_back_cancels_count_in_and_jump_then_steps_back(session):
    session.say("/dance/cue", "solo")
    assert session.say("/dance/back")
    assert session.cues["standby"] == "solo"
    assert session.cues["counting_in"] == []
    session.run(4)
    assert score_position(session) == ("verse", 2)
    assert session.cues["fired"] == 0
    assert session.say("/dance/back")
    assert session.cues["standby"] == "dim"
    assert not session.say("/dance/back")


def test_cues_are_found_by_name_and_number_and_unknown_refused(session):
    assert session.say("/dance/standby", "2.5")
    assert session.cues["standby"] == "solo"
    assert session.say("/dance/standby", " TOP ")
    session.say("/dance/go")
    assert session.cues["standby"] is None
    session.run(1)
    assert not session.say("/dance/go")
    assert "no cue stands by" in session.words
    assert not session.say("/dance/cue", "nowhere")
    assert "dim, solo, up, top" in session.words
    for _ in range(20):
        session.say("/dance/cue", "top")
    assert len(session.cues["counting_in"]) == 16


@pytest.mark.long
def test_hold_stops_score_fades_and_cues_while_beat_continues(session):
    session.say("/dance/light/level", 0.0, 1)
    session.run(2)
    session.say("/dance/go")
    session.say("/dance/hold", 1)
    level, where, node = (
        session.value("/dance/light/level"),
        score_position(session),
        session.show.dancers.present.node.copy(),
    )
    session.run(12)
    assert session.value("/dance/light/level") == level == pytest.approx(0.5)
    assert score_position(session) == where
    assert session.cues["fired"] == 0
    assert session.show.span.number == 4
    assert (session.show.dancers.present.node != node).any()
    session.say("/dance/hold", 0)
    session.run(1 - 1 / 32)
    assert session.cues["fired"] == 0  # the line it was to come with has passed: it comes with the next one
    session.run(1 / 32)
    assert session.cues["fired"] == 1


def test_panic_resets_show_and_go_resumes(session):
    session.say("/dance/attract", 1.0, 1.0, 1.0, 100)
    session.say("/dance/scene", "low", 0)
    session.say("/dance/step", "spin", 50)
    session.say("/dance/go")
    session.run(1)
    tempo, beat = session.show.timeline.tempo, session.show.danced_beats
    session.say("/dance/panic")
    session.run(4)
    assert session.value("/dance/light/level") == 1.0
    assert session.show.variation.values[0, LARGER.first] == 0.0
    assert session.cues["held"]
    assert session.cues["standby"] == "dim"
    assert session.cues["counting_in"] == []
    assert session.show.timeline.tempo == tempo
    assert session.show.danced_beats == pytest.approx(beat + 4)
    view = session.show.view()
    session.show.fill(view, session.ticks / 64)
    assert view.element_count == 0
    assert any("HELD" in line for line in session.desk.status_lines(session.show.danced_beats))
    session.say("/dance/go")
    assert not session.cues["held"]
    assert not session.show.playhead.held


def test_edited_score_keeps_standby_cue():
    session = DeskSession().run(1)
    session.say("/dance/standby", "up")
    session.say("/dance/go")
    fresh = DeskSession(DESK.replace('name = "dim"', 'name = "new"\n[[cue]]\nname = "dim"', 1))
    session.desk.cues.apply_patch(fresh.desk.cues)
    assert session.cues["standby"] == "top"
    session.run(1)
    assert session.cues["last"] == "up"
    session.desk.cues.apply_patch(DeskSession("").desk.cues)
    assert session.cues["standby"] is None
    assert session.cues["last"] is None


def test_cue_replay_is_bit_identical():
    said = [(5, "/dance/go"), (6, "/dance/light/key", 2.0, 3), (9, "/dance/cue", "solo"), (14, "/dance/undo"),
            (20, "/dance/panic"), (24, "/dance/go")]  # fmt: skip
    lines = []
    first = DeskSession()
    for beat, address, *values in said:
        first.run(beat - first.ticks / 32)
        event = REGISTRY.call(address, values, first.ticks / 64, "key")
        lines.append((first.ticks, event_to_json(event)))
        first.show.apply(event)
    first.run(10)
    second = DeskSession()
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
def test_invalid_cue_is_refused_with_line(lines, words):
    with pytest.raises(PatchError) as error:
        DeskSession(f'[[cue]]\nname = "x"\n{lines}\n')
    assert words in str(error.value)
    assert "test.toml, line 2" in str(error.value)


@pytest.mark.long
def test_panic_blocks_score_and_signal_calls_until_resumed():
    text = (
        '[[section]]\nname = "a"\nmeasures = 1\nwait = true\n[[at]]\nmeasure = 1\nbeat = 3.0\ncall = "/dance/spread"\n'
    )
    text += (
        '[[signal]]\nname = "hit"\nmeasure = 1\n[[react]]\non = "hit"\ncall = "/dance/attract"\nvalues = [1.0, 1.0]\n'
    )
    session = DeskSession(text).run(5)
    session.say("/dance/panic")
    session.run(6)
    view = session.show.view()
    session.say("/dance/signal", "hit")
    session.run(5)
    session.show.fill(view, session.ticks / 64)
    assert view.element_count == 0
    session.say("/dance/hold", 0)
    session.run(8)
    session.show.fill(view, session.ticks / 64)
    assert view.element_count >= 1


@pytest.mark.long
def test_each_cue_fires_in_tick_of_its_beat(session):
    for name in ("dim", "up", "solo", "top"):
        session.say("/dance/cue", name)
        session.run(ticks=37)
    session.run(30)
    assert session.cues["fired"] == 5  # one came by itself
    assert session.cues["late_ticks_max"] == 0


def test_all_faulty_calls_of_a_cue_are_told_with_near_addresses():
    calls = '[["/dance/spred"], ["/dance/step"], ["/dance/spread"]]'
    with pytest.raises(PatchError) as error:
        DeskSession(f'[[cue]]\nname = "x"\ncalls = {calls}\n')
    assert len(error.value.faults) == 2
    assert "cue.1.calls.1: cue 'x': '/dance/spred'" in error.value.faults[0]
    assert "did you mean '/dance/spread'?" in error.value.faults[0]
    assert "cue.1.calls.2" in error.value.faults[1]
