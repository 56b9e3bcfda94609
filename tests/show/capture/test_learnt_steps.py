"""Steps of a seen performer: recognised, answered by the group, and learnt while the show runs."""

import os
import shutil

import numpy as np
import pytest

from live.clock.ticks import TICK
from live.control.events import events
from live.library.step_folder import load_folder
from live.motion.capture.packed_pose import pack_pose
from live.motion.clip import read_clip
from live.motion.skeleton import JOINT_COUNT
from live.show.capture.learnt_step import learn_step, save_step
from live.show.journal.journal import read_journal
from live.show.journal.replay import first_start, load_journal, replay, run_from, start_at
from live.show.patch.hot_reload import PatchWatch
from live.show.patch.patch_reader import PatchError, parse_patch
from live.show.state.snapshot import at_rest, restore, snapshot
from tests.show.patch.edited_night import STEPS, JournaledShow, write_patch_folder

PATCH = """
name = "class"
steps = "moves"
[clock]
bpm = 120
[[mocap]]
name = "anna"
dancer = "none"
[[group]]
name = "all"
dancers = 6
steps = ["groove"]
"""
BPM = 120.0


@pytest.fixture(scope="module")
def danced(tmp_path_factory):
    """The clips that a performer dances, by step; "bow" is none of the show's library."""
    folder = tmp_path_factory.mktemp("danced")
    for name in ("groove", "side_step", "kick"):
        shutil.copy(STEPS / f"{name}.toml", folder)
    found = {}
    for clip in load_folder(folder):
        if not clip.mirrored:
            found.setdefault(clip.step, clip)
    return found


class Class(JournaledShow):
    """A show with a performer who dances clips, seen 32 times a second."""

    def __init__(self, patch, danced, dances="groove"):
        super().__init__(patch)
        self.danced, self.dances = danced, dances
        self.watch = PatchWatch(
            self.loaded, self.show, post=self.inbox.put, now=self.clock.now, library=self.library
        )  # fmt: skip
        self._seen = 0
        self.learns, self.backwards = True, False
        self.asked = []
        self.show.frame.router.observers.append(
            lambda event, now: (
                self.asked.append((now.span.number, event)) if isinstance(event, events.CallStep) else None
            )
        )

    def pose(self, beat):
        """The packed pose of the performer at a beat: one clip again and again, turned and moved."""
        clip = self.danced.get(self.dances)
        if clip is None:
            rotation = np.zeros((JOINT_COUNT, 4))
            rotation[:, 0] = 1.0
            return pack_pose([0.0, 0.93, 0.0], rotation)
        phase = (beat / clip.beats_per_measure) % clip.measures
        if self.backwards:  # a motion that no step of the library is
            phase = clip.measures - phase
        root, rotation, _ = read_clip(clip.clip, np.array([clip.first + phase * clip.samples_per_measure]))
        return pack_pose(root[0] * 1.05, rotation[0])

    def dance(self, measures):
        """Runs so many measures; returns the steps danced in each, by its number from 0."""
        found = {}
        for _ in range(round(measures * 4 * 60.0 / BPM * 64)):
            self._seen += 1
            now = self._seen * TICK
            self.clock.set(now)
            if self.dances and self._seen % 2 == 0:
                beat = self.show.span.danced_beats(self.show.timeline.beat_at(now), 4)
                self.inbox.put(events.MocapFrame(time=now, source="camera", performer="anna", pose=self.pose(beat)))
            self.engine.frame(lambda view: None)
            if self.learns:
                self.watch.frame()
                self.watch.run_tasks()
            found.setdefault(self.show.span.number, set()).update(self.names())
        return found

    def ask(self, **said):
        """Asks to learn a step."""
        self.inbox.put(events.LearnStep(time=self.clock.now(), source="osc", performer="anna", **said))


@pytest.fixture
def patch(tmp_path):
    return write_patch_folder(tmp_path, PATCH)


@pytest.fixture(scope="module")
def danced_before(tmp_path_factory, danced):
    """A show in which the performer has danced for more than a measure, for wishes that are refused: it stays."""
    night = Class(write_patch_folder(tmp_path_factory.mktemp("before"), PATCH), danced)
    night.dance(1.2)
    return night


def with_answer(tmp_path, answer):
    return write_patch_folder(tmp_path, PATCH + f'[[answer]]\nname = "echo"\nperformer = "anna"\n{answer}\n')


@pytest.mark.long
def test_step_is_danced_at_next_measure_but_one_and_kept(patch, danced):
    night = Class(patch, danced, "kick")
    night.backwards = True
    night.dance(3.0)
    night.ask(name="Anna's kick", when="next")  # measure 3, from 0, if asked before its line
    night.dance(0.02)
    first = night.show.seen_steps.takes[0].first / 4
    found = night.dance(5)
    assert night.show.refusals.count == 0, night.show.refusals.last_reason
    assert min(number for number, names in found.items() if "Anna's kick" in names) == first + 2
    assert night.watch.learnt == "learnt: Anna's kick can be danced"
    (learnt,) = [clip for clip in load_folder(patch.parent / "moves") if clip.step == "Anna's kick"][:1]
    assert learnt.bpm == pytest.approx(BPM, abs=0.5)
    graph = night.show.graph
    assert not night.library.poll()
    assert not night.library.poll()  # the saved files are the step that is danced already
    assert night.library.problem == ""
    assert night.show.graph is graph
    assert night.show.seen_steps.takes == []
    night.dance(2)
    assert night.show.seen_steps.facts()["anna"]["step"] == "Anna's kick"  # and it is recognised from now on


@pytest.mark.long
def test_replay_and_snapshot_have_learnt_step_bit_identically(patch, danced):
    night = Class(patch, danced, "kick")
    night.dance(3.2)
    night.ask(name="kick it", measures=2)
    night.dance(1.0)
    while not at_rest(night.show):
        night.dance(0.01)
    kept = snapshot(night.show, night.engine.ticks.index)
    night.dance(3.8)
    night.writer.close(night.engine.ticks.index)
    assert "kick it" in night.names()
    journal = read_journal(night.journal)
    (patch.parent / "moves" / "kick_it.bvh").unlink()  # a replay needs no file of it
    (patch.parent / "moves" / "kick_it.toml").unlink()
    result = replay(first_start(journal, load_journal(journal)).show, journal)
    assert result.measures >= 6
    assert result.differences == ()
    start = start_at(journal, load_journal(journal), kept)  # a recovered engine goes on from a snapshot
    assert "kick it" in start.show.graph.library.steps
    assert len(start.show.seen_steps.templates.step) == len(night.show.seen_steps.templates.step)
    resumed = run_from(start, journal)
    assert resumed.measures >= 3
    assert resumed.differences == ()


def test_take_waits_in_snapshot_until_an_engine_learns_it(patch, danced):
    night = Class(patch, danced, "kick")
    night.learns = False  # this engine ends before it has learnt the step
    night.dance(2.2)
    night.ask(name="kick it")
    night.dance(0.1)
    (take,) = night.show.seen_steps.takes
    assert take.is_over
    resumed = restore(night.loaded, snapshot(night.show))
    (again,) = resumed.seen_steps.takes
    assert np.array_equal(again.hips, take.hips)
    assert np.array_equal(again.stamp, take.stamp)
    posted = []
    watch = PatchWatch(night.loaded, resumed, post=posted.append, now=lambda: 9.0)
    watch.frame()
    watch.frame()  # begins nothing twice
    watch.run_tasks()
    assert [type(event) for event in posted] == [events.StepsChanged]
    assert resumed.apply(posted[0])


@pytest.mark.parametrize(
    ("said", "reason"),
    [
        ({"name": "groove"}, "there is a step called 'groove' already"),
        ({"name": "Side-Step"}, "already"),
        ({"name": "  "}, "is no name for a step"),
        ({"name": "x" * 80}, "is no name for a step"),
        ({"name": "new", "measures": 9}, "1 to 4 can be learnt"),
        ({"name": "new", "when": "now"}, "last: what was danced"),
        ({"name": "new", "group": "nobody"}, "nobody"),
        ({"name": "new", "measures": 4}, "was not seen for 4 whole measures"),
    ],
)
def test_impossible_wishes_are_refused_with_a_reason(danced_before, said, reason):
    night = danced_before
    refused = night.show.refusals.count
    night.ask(**said)
    night.dance(0.05)
    assert night.show.refusals.count == refused + 1
    assert reason in night.show.refusals.last_reason
    assert night.show.seen_steps.takes == []


def test_performer_who_was_never_seen_or_does_not_exist_is_refused(patch, danced):
    night = Class(patch, danced, "")
    night.dance(0.1)
    night.ask(name="new")
    night.dance(0.1)
    assert "anna was never seen" in night.show.refusals.last_reason
    night.inbox.put(events.LearnStep(time=0.0, source="osc", performer="bob", name="new"))
    night.dance(0.1)
    assert "no performer is called 'bob'" in night.show.refusals.last_reason


@pytest.mark.long
def test_still_body_and_body_that_leaves_are_refused(patch, danced):
    night = Class(patch, danced, "stand")
    night.dance(2.2)
    night.ask(name="new")
    night.dance(0.1)
    assert "stood still" in night.show.refusals.last_reason
    night.dances = "groove"
    night.ask(name="newer", when="next")
    night.dance(1.1)
    night.dances = ""  # out of the picture
    night.dance(1.2)
    assert "'newer' is not learnt: the performer was not seen all the time" in night.show.refusals.last_reason
    assert night.show.seen_steps.takes == []


@pytest.mark.long
def test_folder_that_cannot_be_written_is_said_and_the_step_danced(patch, danced):
    night = Class(patch, danced, "kick")
    night.dance(2.1)
    night.learns = False
    night.ask(name="kick it")
    night.dance(0.1)
    (take,) = night.show.seen_steps.takes
    step = learn_step(take, night.show.graph, night.show.patch, (120.0, 120.0), patch.parent / "moves")
    assert "cannot be written" in save_step(step, patch.parent / "gone")
    assert "no folder of steps of its own" in save_step(step, None)
    if os.geteuid() != 0:
        (patch.parent / "moves").chmod(0o500)
        assert "cannot be written: Permission denied" in save_step(step, patch.parent / "moves")
        (patch.parent / "moves").chmod(0o700)
    assert step.graph.library.step_index("kick it") is not None


def test_step_that_cannot_be_made_is_said_and_forgotten(patch, danced):
    night = Class(patch, danced, "kick")
    night.dance(1.2)
    night.ask(name="kick it", when="next")
    night.dance(0.1)
    failed = events.LearningFailed(time=0.0, source="learn", performer="anna", name="kick it", reason="no way")
    assert not night.show.apply(failed)
    assert night.show.refusals.last_reason == "learn: anna: 'kick it' is not learnt: no way"
    assert night.show.seen_steps.takes == []


def test_same_step_is_answered_in_next_measure(tmp_path, danced):
    night = Class(with_answer(tmp_path, ""), danced, "side step")
    found = night.dance(2.9)
    number, event = night.asked[0]
    assert (number, event.name, event.group) == (1, "side step", "*")  # heard in measure 0 if it was whole, else in 1
    found |= night.dance(0.5)
    assert found[number + 1] == {"side step"}
    told = night.show.seen_steps.facts()["anna"]
    assert told["step"] == "side step"
    assert told["confidence"] > 0.5
    assert night.show.seen_steps.words().startswith("anna: side step ")


@pytest.mark.long
def test_canon_answers_a_measure_later_and_others_by_map(tmp_path, danced):
    night = Class(with_answer(tmp_path, 'how = "next"'), danced, "side step")
    found = night.dance(4)
    number, event = night.asked[0]
    assert event.name == "side step"
    assert "side step" not in found[number]
    assert found[number + 1] == {"side step"}
    night.inbox.put(events.SwitchAnswer(time=0.0, source="osc", on=False))
    night.dance(0.1)
    before = len(night.asked)
    night.dance(2)
    assert len(night.asked) == before
    night.inbox.put(events.SetAnswerHow(time=0.0, source="osc", how="map"))
    night.dance(0.1)
    assert "has no map" in night.show.refusals.last_reason
    night.inbox.put(events.SetAnswerHow(time=0.0, source="osc", how="other", answer="echo"))
    night.inbox.put(events.SwitchAnswer(time=0.0, source="osc", on=True))
    night.dance(2)
    assert {event.name for _, event in night.asked[before:]} == {"groove"}
    night.inbox.put(events.SetAnswerGroup(time=0.0, source="osc", group="1-2", answer="nobody"))
    night.dance(0.1)
    assert "no answer is called 'nobody'" in night.show.refusals.last_reason


@pytest.mark.long
def test_mapped_step_is_asked_for(tmp_path, danced):
    night = Class(
        with_answer(tmp_path, 'how = "map"\ngroup = "1-3"\nmap = { "side step" = "kick" }'), danced, "side step"
    )
    night.dance(2)
    assert {(event.name, event.group) for _, event in night.asked} == {("kick", "1-3")}


@pytest.mark.long
def test_standing_performer_is_no_step(tmp_path, danced):
    night = Class(with_answer(tmp_path, ""), danced, "stand")
    night.dance(2.5)
    assert night.asked == []
    assert night.show.seen_steps.facts()["anna"]["step"] is None


@pytest.mark.parametrize(
    ("answer", "reason"),
    [
        ('performer = "bob"', "no performer is called 'bob'"),
        ('performer = "anna"\nhow = "map"', "needs `map"),
        ('performer = "anna"\nmap = { groove = "kick" }', "has no effect"),
        ('performer = "anna"\nhow = "loud"', "how"),
    ],
)
def test_faults_of_the_table_name_the_line(answer, reason):
    with pytest.raises(PatchError) as error:
        parse_patch(PATCH + f'[[answer]]\nname = "echo"\n{answer}\n', "class.toml")
    assert reason in str(error.value)


def test_unknown_step_in_map_is_an_error_when_the_show_begins(tmp_path, danced):
    patch = with_answer(tmp_path, 'how = "map"\nmap = { groove = "moonwalk" }')
    with pytest.raises(Exception, match="answer 'echo': no step is called 'moonwalk'"):
        JournaledShow(patch)
