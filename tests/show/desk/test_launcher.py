"""Tests of launches: on the beat, measure and section, what follows them, stop, undo, hold, snapshots and replay."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.event_json import event_from_json, event_to_json
from live.show.desk.pad import KINDS
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import restore
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DeskSession
from tests.show.made_show import GRAPH, PATCH, made_show
from tests.show.state.test_snapshot import capture_from, run

SECTIONS = '[[section]]\nname = "a"\nmeasures = 3\nrepeat = 2\n[[section]]\nname = "b"\nmeasures = 2\n'
PHRASES = (
    '[[sequence]]\nname = "opening"\nmeasure = 90\nsteps = ["glide", "spin"]\n'
    '[[sequence]]\nmeasure = 95\nsteps = ["sway"]\n'
)
OWN = (
    '[[pad]]\nname = "one"\ndoes = "step glide"\nmeasures = 1\nfollow = "next"\n'
    '[[pad]]\nname = "two"\ndoes = "element spread"\nmeasures = 2\nfollow = "next"\n'
    '[[pad]]\nname = "three"\ndoes = "step spin"\nmeasures = 1\n'
)
SCENES = (
    '[[scene]]\nname = "low"\nmeasures = 0\n[scene.set]\n"/dance/light/level" = 0.25\n'
    '[[cue]]\nname = "dim"\nscene = "low"\n'
)


class Session(DeskSession):
    """A show without sections whose launches are looked at."""

    def __init__(self, extra=""):
        super().__init__(extra)

    def waiting(self):
        return {one.pad.text: one.due for one in self.show.launcher.waiting.values()}

    def running(self):
        return {one.pad.text: (one.due, one.ends) for one in self.show.launcher.running.values()}

    def steps(self, group=0):
        """Names of the steps that dancers of a group dance now."""
        library = self.show.graph.library
        nodes = self.show.dancers.node[self.show.group == group]
        return {library.steps[library.node_step[node]] for node in nodes}


@pytest.mark.long
def test_a_step_begins_on_the_measure_and_ends_after_its_measures():
    session = Session().run(5)
    assert session.say("/dance/launch", "step spin", "front", "measure", 2)
    assert session.waiting() == {"step spin": 8.0}
    session.run(3, -1)
    assert session.running() == {}
    session.run(ticks=2)
    assert session.waiting() == {}
    assert session.running() == {"step spin": (8.0, 16.0)}
    assert session.steps() == {"spin"}
    session.run(4)
    assert session.steps() == {"spin"}
    session.run(4)
    assert session.running() == {}
    assert session.steps() != {"spin"}


@mostly_long(("when", "begins"), [("now", 5 + 1 / 32), ("beat", 6.0)], quick=[0])
def test_a_step_begins_at_once_or_on_the_beat(when, begins):
    session = Session().run(5, 1)
    session.say("/dance/launch", "step spin", "front", when, 1)
    session.run(begins - 5 - 1 / 32, 0 if when == "now" else -1)
    assert session.show.interrupts.cue_count == 0
    session.run(0.5, 1)
    assert session.show.interrupts.cue_count == 1
    assert session.steps() == {"spin"}
    assert session.running()["step spin"] == (pytest.approx(begins), 12.0)  # the rest of this measure, and one more
    session.run(11 - session.show.danced_beats)
    assert session.steps() == {"spin"}
    session.run(1.5)
    assert session.running() == {}


@mostly_long("late", [2.5, 3.0, 3.5, 3.9], quick=[3])
def test_a_step_launched_just_before_the_line_is_danced_from_the_line(late):
    session = Session().run(4 + late)
    session.say("/dance/launch", "step spin", "front", "measure", 2)
    session.run(4 - late, 3)
    assert session.steps() == {"spin"}
    session.run(4)
    assert session.steps() == {"spin"}


def test_a_launch_on_the_section_waits_for_the_end_of_its_pass():
    session = Session(SECTIONS).run(5)
    session.say("/dance/launch", "step spin", "front", "section", 1)
    assert session.waiting() == {"step spin": 12.0}
    session.say("/dance/launch", "formation circle", "back", "section")
    session.say("/dance/section", "b")  # the section begins sooner
    session.run(ticks=1)
    assert session.waiting() == {"step spin": 8.0, "formation circle": 8.0}
    session.run(3, 1)
    assert set(session.running()) == {"step spin", "formation circle"}
    assert session.steps() == {"spin"}


def test_without_sections_it_waits_for_eight_measures_or_the_phrase_of_the_music():
    session = Session().run(5)
    session.say("/dance/launch", "step spin", "front", "section")
    assert session.waiting() == {"step spin": 32.0}
    lines = "".join(
        f"[[music.line]]\ntime_s = {2 * measure - 2}\nmeasure = {measure}\nbeats = 4\n" for measure in range(1, 30)
    )
    mapped = "[music]\nfile = 'song.wav'\n" + lines
    phrases = "".join(f"[[music.phrase]]\nmeasure = {measure}\n" for measure in (1, 4, 10))
    session = Session(mapped + phrases).run(5)
    session.say("/dance/launch", "step spin", "front", "section")
    assert session.waiting() == {"step spin": 12.0}


def test_formations_elements_and_looks_begin_when_they_are_due():
    session = Session(SCENES).run(5)
    session.say("/dance/launch", "formation circle", "front", "measure", 2)
    session.say("/dance/launch", "element spread", "back", "beat", 1)
    session.say("/dance/launch", "scene low", "back", "measure")
    assert session.say("/dance/launch", "cue dim", "*", "section")  # the later look counts
    session.run(1, 1)
    assert len(session.show.motion.elements.in_force) == 1
    session.run(2)
    assert any(who.sum() == 5 for _, who in session.show.motion.evolutions.moved())
    assert session.value("/dance/light/level") == 1.0
    session.run(25)
    assert session.value("/dance/light/level") == 0.25
    assert not session.show.motion.elements.in_force


def test_an_element_gives_way_to_the_next_one_of_its_dancers():
    session = Session().run(5)
    session.say("/dance/launch", "element spread", "front", "now", 8)
    session.run(2)
    session.say("/dance/launch", "element vortex", "front", "measure", 8)
    session.run(1.5)
    first, second = session.show.motion.elements.in_force
    assert first.end_beat < 10.0 < second.end_beat
    session.say("/dance/launch/stop", "back")
    session.run(1)
    assert session.running()
    session.say("/dance/launch/stop", "front")
    session.run(2)
    assert session.running() == {}
    assert not session.show.motion.elements.in_force


@pytest.mark.long
def test_a_phrase_is_repeated_for_its_measures_and_then_the_own_steps_resume():
    session = Session(PHRASES).run(5)
    session.say("/dance/launch", "phrase opening", "front", "now", 4)  # it can begin only with a measure
    assert session.waiting() == {"phrase opening": 8.0}
    danced = []
    for _ in range(6):
        session.run(4)
        danced.append(session.steps())
    assert danced[:4] == [{"glide"}, {"spin"}, {"glide"}, {"spin"}]
    assert not session.show.scheduler.programmes[0].live_sequence
    assert session.running() == {}
    assert session.say("/dance/launch", "phrase 2", "front")


@pytest.mark.long
def test_a_step_after_a_phrase_ends_the_phrase():
    session = Session(PHRASES).run(5)
    session.say("/dance/launch", "phrase opening", "front", "measure", 64)
    session.run(8)
    session.say("/dance/launch", "step sway", "front", "measure", 1)
    session.run(4)
    assert session.steps() == {"sway"}
    assert not session.show.scheduler.programmes[0].live_sequence


@pytest.mark.long
def test_for_everybody_replaces_what_runs_for_groups():
    session = Session().run(5)
    session.say("/dance/launch", "step spin", "front", "measure", 16)
    session.run(4)
    session.say("/dance/launch", "step glide", "*", "measure", 2)
    session.run(4)
    assert set(session.running()) == {"step glide"}
    assert session.steps(0) == session.steps(1) == {"glide"}


@pytest.mark.long
def test_a_selection_of_dancers_has_its_own_launches():
    session = Session().run(5)
    session.say("/dance/launch", "step spin", "1 + 2", "measure", 2)
    session.run(4)
    library = session.show.graph.library
    names = [library.steps[library.node_step[node]] for node in session.show.dancers.node]
    assert names[:2] == ["spin", "spin"]
    session.say("/dance/launch/stop", "1 + 2")
    session.run(4)
    assert session.running() == {}


@pytest.mark.long
def test_a_stopped_step_leaves_a_sequence_set_by_hand():
    session = Session().run(1)
    assert session.say("/dance/sequence", "glide, sway", "front")
    session.say("/dance/launch", "step spin", "front", "measure", 16)
    session.run(8)
    assert session.steps() == {"spin"}
    session.say("/dance/launch/stop", "front")
    session.run(4.5)
    assert session.steps() <= {"glide", "sway"}
    assert session.show.scheduler.programmes[0].live_sequence


@pytest.mark.long
def test_a_place_counts_once_when_it_is_launched():
    session = Session(PHRASES).run(5)
    position = session.show.state.position
    left = (np.flatnonzero(session.show.casting.select("front & left", position)) + 1).tolist()
    session.say("/dance/launch", "phrase opening", "front & left", "measure", 2)
    (one,) = session.show.launcher.waiting.values()
    session.run(3.5)
    session.show.state.position[:, 0] *= -1.0  # they change sides
    session.run(12)
    assert session.show.casting.select(one.group, session.show.state.position).nonzero()[0].tolist() == [
        number - 1 for number in left
    ]
    assert session.running() == {}
    assert session.show.scheduler.subgroups.sequences == ()


@mostly_long(("follow", "then"), [("again", "glide"), ("next", "spin"), ("first", "sway")], quick=[2])
def test_what_follows(follow, then):
    session = Session().run(1)
    assert [pad.name for pad in session.show.launcher.pads.page("step")] == ["sway", "glide", "spin", "phrase"]
    session.say("/dance/launch", "step glide", "front", "measure", 1, follow)
    session.run(4.2)
    assert session.waiting() == {}
    session.run(0.1)
    assert session.waiting() == {f"step {then}": 8.0}
    session.run(3)
    assert session.steps() == {then}
    assert len(session.running()) == 1
    session.run(1)  # and so on
    assert len(session.waiting()) == 1
    session.say("/dance/launch/stop")
    session.run(4.5)
    assert session.running() == session.waiting() == {}
    session.run(8)
    assert session.running() == {}


def test_a_step_that_cannot_follow_at_once_is_passed_over():
    session = Session().run(1)
    names = [pad.name for pad in session.show.launcher.pads.page("step")]
    session.say("/dance/launch", "step phrase", "front", "measure", 2)
    while session.steps() != {"phrase"}:
        session.run(4)
    away = dict(zip(names, session.show.launcher.measures_away("front").tolist(), strict=True))
    assert away["phrase"] == 0
    assert away["spin"] == 1  # it has a second measure
    session.run(1.5)
    session.say("/dance/launch", "step spin", "front", "now", 1, "next")  # a cut: it can always be danced
    session.run(1)
    assert session.steps() == {"spin"}
    (row,) = session.show.launcher.running.values()
    ready = [name for name, count in zip(names, session.show.launcher.measures_away("front"), strict=True) if not count]
    order = [*names[names.index("spin") + 1 :], *names]
    session.run(row.ends - 2.7 - session.show.danced_beats)
    assert list(session.waiting()) == [f"step {next(name for name in order if name in ready)}"]


@pytest.mark.long
def test_another_is_drawn_by_the_seed_and_never_itself():
    def danced(seed):
        session = Session()
        session.show = made_show(seed=seed)
        session.say("/dance/launch", "element spread", "front", "measure", 1, "other")
        names = []
        for _ in range(12):
            session.run(4)
            names += [one.pad.name for one in session.show.launcher.running.values()]
        return names

    first = danced(3)
    assert first == danced(3)
    assert first != danced(4)
    assert len(first) > 10
    assert all(one != other for one, other in itertools.pairwise(first))


@pytest.mark.long
def test_own_pads_have_their_measures_and_follow_each_other():
    session = Session(OWN).run(1)
    session.say("/dance/launch", "own one", "front")
    session.run(4)
    assert session.running() == {"own one": (4.0, 8.0)}
    session.run(4)
    assert set(session.running()) == {"own two"}
    session.run(8)
    assert set(session.running()) == {"own three"}
    session.run(4)
    assert session.running() == session.waiting() == {}
    with pytest.raises(PersonError, match="pad 'x': no step is called 'nothing'"):
        made_show('[[pad]]\nname = "x"\ndoes = "step nothing"\n')


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (("step nowhere",), "no step is called 'nowhere'"),
        (("step spin", "nobody"), "nobody"),
        (("step spin", "*", "tomorrow"), "there are: now, beat, measure, section"),
        (("step spin", "*", "now", 1, "back"), "there are: stop, again, next, first, other"),
        (("phrase x",), "the patch has none"),
        (("formation ((",), "formation"),
        (("element fly",), "no element is called 'fly'"),
        (("cue x",), "the patch has none"),
        (("own x",), "the patch has none"),
        (("spin",), "kinds are step, phrase"),
    ],
)
def test_what_is_not_there_is_refused_at_once(values, words):
    session = Session().run(1)
    assert not session.say("/dance/launch", *values)
    assert words in session.words
    assert session.waiting() == {}


def test_what_is_refused_when_it_is_due_is_told_and_is_not_running():
    session = Session().run(1)
    assert session.say("/dance/launch", "scene nowhere")
    session.run(4)
    assert session.running() == session.waiting() == {}
    assert list(session.show.launcher.refused.values()) == [("scene nowhere", "*", session.words)]
    session.say("/dance/launch", "element spread")
    assert session.show.launcher.refused
    session.say("/dance/scene/store", "kept")
    session.say("/dance/launch", "scene kept")
    assert not session.show.launcher.refused


def test_a_flood_is_bounded():
    session = Session().run(1)
    for count in range(300):
        session.say(
            "/dance/launch",
            "element spread",
            f"1-5 - {count // 5 % 5 + 1}" + f" + {count % 9 + 1} + {count // 9 % 9 + 1}",
        )
    assert len(session.show.launcher.waiting) <= 128
    session.run(4)
    assert len(session.show.launcher.running) <= 128


def test_undo_withdraws_what_waits_and_stops_what_runs():
    session = Session().run(5)
    session.say("/dance/launch", "step spin", "front", "measure", 8)
    session.run(4)
    session.say("/dance/launch", "element spread", "front", "section", 8)
    session.say("/dance/launch", "step glide", "front", "section", 8)
    assert session.say("/dance/undo")
    assert list(session.waiting()) == ["element spread"]
    assert session.say("/dance/redo")
    session.run(ticks=1)
    assert session.waiting() == {"element spread": 32.0, "step glide": 32.0}
    session.say("/dance/undo")
    session.say("/dance/undo")
    session.say("/dance/undo")
    session.run(4)
    assert session.waiting() == session.running() == {}
    assert session.steps() != {"spin"}


def test_clear_and_panic_end_all_launches_and_hold_keeps_them_waiting():
    session = Session().run(5)
    session.say("/dance/launch", "element spread", "front", "now", 8)
    session.say("/dance/launch", "step spin", "front", "measure", 8)
    session.say("/dance/hold", 1)
    session.run(8)
    assert set(session.waiting()) == {"element spread", "step spin"}
    session.say("/dance/hold", 0)
    session.run(4)
    assert set(session.running()) == {"element spread", "step spin"}
    session.say("/dance/clear")
    session.run(ticks=1)
    assert session.running() == {}
    session.say("/dance/launch", "element spread", "front", "section", 8)
    session.say("/dance/panic")
    assert session.waiting() == {}


WRITTEN = PHRASES.replace("90", "4").replace("95", "1")
LOADED = LoadedShow(Path("test.toml"), parse_patch(PATCH + SECTIONS + WRITTEN + OWN, "test.toml"), GRAPH)
SCRIPT = {
    40: events.Launch(time=0.6, source="osc", pad="own one", group="front"),
    50: events.Launch(
        time=0.8, source="osc", pad="element flock", group="back", when="beat", measures=1, follow="other"
    ),
    160: events.Launch(
        time=2.5, source="osc", pad="step spin", group="back", when="section", measures=2, follow="next"
    ),
    420: events.Launch(time=6.5, source="osc", pad="phrase opening", group="front", when="now", measures=3),
    900: events.StopLaunches(time=14.0, source="osc", group="back"),
}


@mostly_long("tick", [45, 130, 200, 333, 600], quick=[0])
def test_launches_continue_bit_identically_from_a_snapshot(tick):
    show = LOADED.start()
    run(show, 1, tick, SCRIPT)
    at, data = capture_from(show, tick, SCRIPT)
    restored = restore(LOADED, data)
    assert restored.launcher.waiting == show.launcher.waiting
    assert restored.launcher.running == show.launcher.running
    assert run(restored, at + 1, at + 500, SCRIPT) == run(show, at + 1, at + 500, SCRIPT)
    assert restored.launcher.facts() == show.launcher.facts()
    assert show.launcher.facts()["launched"] > 4


@pytest.mark.long
def test_launches_from_a_journal_are_the_same():
    written = {tick: json.loads(json.dumps(event_to_json(event))) for tick, event in SCRIPT.items()}
    read = {tick: event_from_json(event) for tick, event in written.items()}
    assert run(LOADED.start(), 1, 1200, read) == run(LOADED.start(), 1, 1200, SCRIPT)


def test_pads_of_each_page_can_be_launched():
    session = Session(PHRASES + OWN + SCENES).run(1)
    for kind in KINDS:
        pads = session.show.launcher.pads.page(kind)
        assert pads
        assert len({pad.text for pad in pads}) == len(pads)
        for pad in pads:
            assert session.say("/dance/launch", pad.text), session.words
    session.run(4)
    assert not session.show.launcher.refused
    with pytest.raises(PersonError):
        session.show.launcher.pads.find("step")
