"""PatchWatch: a valid edit of the patch's files takes effect at the next measure, an invalid one never."""

import json

import pytest

from live.base.fault_isolation import FAULTS
from live.base.motion_parameters import HEAD, LARGER
from live.base.picture_parameters import LEVEL
from live.control.events import events
from live.control.events.events import GiveCue, PatchChanged
from live.show.journal.journal import read_journal
from live.show.journal.replay import first_start, load_journal, replay, run_from, start_before
from live.show.patch.hot_reload import PatchWatch
from tests.fixtures.mostly_long import mostly_long
from tests.show.patch import edited_night
from tests.show.patch.edited_night import STEPS, write_patch_folder

PATCH = """name = "edited"
steps = "moves"
reserve = 0
[clock]
bpm = 120
[[group]]
name = "all"
dancers = 4
steps = ["groove"]
"""


@pytest.fixture
def patch(tmp_path):
    """A show of four dancers with two steps of its own."""
    return write_patch_folder(tmp_path, PATCH)


class WatchedShow(edited_night.JournaledShow):
    """A journaled show whose patch is watched as well."""

    def __init__(self, patch):
        super().__init__(patch)
        self.watch = PatchWatch(self.loaded, self.show, post=self.inbox.put, now=self.clock.now, library=self.library)

    def edit(self, old="", new="", more="", file=None):
        """Edits the patch's text, or another `file` of it; returns whether the watch accepted the edit."""
        path = self.path if file is None else self.path.parent / file
        path.parent.mkdir(exist_ok=True)
        text = path.read_text() if path.exists() else ""
        assert old in text
        path.write_text(text.replace(old, new, 1) + more)
        assert not self.watch.poll()  # it may still be written
        return self.watch.poll()

    def replayed(self):
        """The result of a replay from the journal alone."""
        self.writer.close(self.engine.ticks.index)
        journal = read_journal(self.journal)
        return replay(first_start(journal, load_journal(journal)).show, journal)


def test_edited_steps_are_danced_in_the_next_measure(patch):
    night = WatchedShow(patch)
    night.run(2.5)  # the second measure has begun
    assert night.edit('["groove"]', '["side step"]')
    danced = night.run(5.0)
    assert danced[2] == {"groove"}
    assert danced[3] == {"side step"}
    assert night.show.patch_updates.version == night.watch.status()["version"]
    assert night.watch.message == "patch: new from the next measure on: group"


@pytest.mark.long
def test_edit_after_measure_decision_acts_one_measure_later(patch):
    night = WatchedShow(patch)
    night.run(3.8)  # a tenth of a beat before the third measure
    assert night.edit('["groove"]', '["side step"]')
    danced = night.run(5.0)
    assert danced[3] == {"groove"}
    assert danced[4] == {"side step"}


@pytest.mark.long
def test_every_edited_table_takes_effect_and_replay_needs_no_files(patch):
    night = WatchedShow(patch)
    night.run(2.5)
    assert night.edit(
        more="""[motion]
head = 0.5
[locomotion]
correction_m = 0.1
[selections]
pair = "1-2"
[[obstacle]]
name = "chair"
at = [5.4, 3.4]
[[react]]
to = "loudness"
sets = "amplitude"
"""
    )
    assert night.edit(file="formations/a.toml", more='[[formation]]\nname = "ring"\nshape = "circle"\nsize = [3, 3]\n')
    score = '[[segment]]\nmeasure = 4\nmeasures = 1\ngroup = "pair"\nformation = "ring"\n'
    assert night.edit(file="score/a.toml", more=score + '[[element]]\nkind = "wander"\nmeasure = 5\nmeasures = 1\n')
    night.run(3.0)
    show = night.show
    assert show.variation[HEAD].tolist() == [0.5] * 4
    assert show.motion.surroundings.obstacle_names == ("chair",)
    assert show.casting.select("pair", show.state.position).tolist() == [True, True, False, False]
    night.run(2.9)  # in the fifth measure
    assert [element.source for element in show.motion.elements.in_force] == ["score"]
    night.inbox.put(events.Evolve(time=0.0, source="test", formation="ring", measures=1.0, group="*"))
    night.run(4.0)
    for file in ("show.toml", "formations/a.toml", "score/a.toml"):
        (patch.parent / file).unlink()
    result = night.replayed()
    assert result.measures >= 5
    assert result.differences == ()


@pytest.mark.long
def test_dancers_in_formation_move_to_its_edited_positions(patch):
    night = WatchedShow(patch)
    ring = '[[formation]]\nname = "ring"\nshape = "circle"\nsize = [2, 2]\n'
    assert night.edit(file="formations/a.toml", more=ring)
    assert night.edit(
        '["groove"]', '["walk"]', more='[[segment]]\nmeasure = 2\nmeasures = 1\nformation = "ring"\nhold = true\n'
    )
    night.run(9.0)
    small = abs(night.show.state.position).max()
    assert small < 1.5
    assert night.edit("size = [2, 2]", "size = [6, 6]", file="formations/a.toml")
    night.run(8.0)
    assert abs(night.show.state.position).max() > small + 1.0


@mostly_long(
    ("old", "new", "where"),
    [
        ('["groove"]', '["grove"]', "show.toml, line 9: group.1.steps"),
        ('["groove"]', '["groove"]\ntravel_step = "wlak"', "show.toml, line 10: group.1.travel_step"),
        ('["groove"]', "[3]", "show.toml, line 9: group.1.steps.1"),
        ("bpm = 120", "bpm = = 3", "show.toml, line 5: not valid TOML"),
        (
            '["groove"]',
            '["groove"]\n[[segment]]\nmeasure = 1\nformation = "rnig"',
            "show.toml, line 12: segment.1.formation",
        ),
        (
            "[clock]",
            "[locomotion]\nthreshold_m = 0.011\n[clock]",
            "line 11: group.1.steps: group 'all': step 'groove' connects to no other",
        ),
    ],
    quick=[1],
)
def test_invalid_edit_is_reported_and_last_valid_patch_continues(patch, old, new, where):
    night = WatchedShow(patch)
    night.run(1.0)
    before = night.show.patch
    good = night.watch.version
    assert not night.edit(old, new)
    told = night.watch.status()["problem"]
    assert where in told
    assert "the last good one goes on" in told
    assert night.watch.version == good
    night.run(3.0)
    assert night.show.patch is before
    assert not night.edit(new, old)  # as it was: nothing to take, and nothing is wrong any more
    assert night.watch.problem == ""
    assert night.watch.message == "patch: mended; it is the same as the patch in force"


def test_missing_or_broken_asset_of_edit_is_reported(patch):
    night = WatchedShow(patch)
    (night.path.parent / "broken.png").write_text("no image")
    (night.path.parent / "nobody.glb").write_text("no model")
    before = night.path.read_text()
    for more, words in (
        ('[[background]]\nname = "b"\nfile = "gone.png"\n', "line 12: background.1.file: file: there is no 'gone.png'"),
        ('[[background]]\nname = "b"\nfile = "broken.png"\n', "the image 'broken.png' cannot be read"),
        ('[[character]]\nname = "c"\nfile = "nobody.glb"\n', "line 12: character.1.file"),
    ):
        assert not night.edit(more=more)
        assert words in night.watch.problem
        assert night.watch.problem.endswith("the last good one goes on")
        night.path.write_text(before)
        assert not any(night.watch.poll() for _ in range(2))
        assert night.watch.problem == ""


@pytest.mark.long
def test_edits_that_need_restart_are_deferred_and_others_act(patch):
    night = WatchedShow(patch)
    night.run(1.0)
    assert night.edit("dancers = 4", 'dancers = 6\nfacing = "90"', more="[steering]\nseparation = 2.0\n")
    assert night.watch.deferred_keys == ("steering.separation", "group.1.dancers")
    assert "from the next start on" in night.watch.message
    assert "steering.separation, group.1.dancers" in night.watch.message
    night.run(8.0)
    assert night.show.patch.steering.separation == 1.25
    assert night.show.patch.group[0].facing == "90"
    assert night.show.dancers.present.end_heading() == pytest.approx([1.571] * 4, abs=0.3)
    text = patch.read_text()
    assert not night.edit(text, text.replace("separation = 2.0", "separation = 2.5"))
    assert night.watch.problem == ""


def test_chosen_takes_act_at_the_next_start_and_unknown_ones_are_refused(patch):
    night = WatchedShow(patch)
    name = next(clip.clip.name for clip in night.show.graph.library.clips if clip.step == "side step")
    assert not night.edit("reserve = 0", f'reserve = 0\ntakes = {{"side step" = ["{name}"]}}')
    assert night.watch.deferred_keys == ("takes",)
    assert not night.edit(f'"{name}"', '"side step by nobody"')
    assert "line 4: takes.side step: the step 'side step' has no take" in night.watch.problem


def test_variations_are_made_at_the_next_start(patch):
    night = WatchedShow(patch)
    assert not night.edit("reserve = 0", "reserve = 0\nvariations = 2")
    assert night.watch.deferred_keys == ("variations",)
    assert not night.edit("variations = 2", "variations = 20")
    assert "line 4: variations" in night.watch.problem


@pytest.mark.long
def test_live_values_stay_unless_the_edit_changes_them(patch):
    night = WatchedShow(patch)
    for parameter, value in (("head", 0.3), ("larger", 0.2)):
        night.inbox.put(
            events.SetParameter(time=0.0, source="test", address=f"/dance/motion/{parameter}", value=(value,))
        )
    night.run(1.0)
    assert night.edit(more="[motion]\nlarger = 0.4\n")
    night.run(2.0)
    assert night.show.variation[HEAD][0] == 0.3
    assert night.show.variation[LARGER][0] == 0.4


@pytest.mark.long
def test_edited_transition_settings_rebuild_the_motion_graph(patch):
    night = WatchedShow(patch)
    night.run(1.0)
    before = night.show.graph
    assert night.edit(more="[locomotion]\nthreshold_m = 0.5\ntransition_beats = 0.5\n")
    night.run(3.0)
    assert night.show.graph.window == 0.125
    assert night.show.graph.edge_count > before.edge_count
    assert night.replayed().differences == ()


@pytest.mark.long
def test_long_patch_is_compressed_in_the_journal(patch):
    night = WatchedShow(patch)
    entry = '[[element]]\nkind = "wander"\nmeasure = {}\nmeasures = 1\n'
    assert night.edit(file="score/a.toml", more="".join(entry.format(n) for n in range(1, 500)))
    night.run(3.0)
    event = next(
        event for line in _journal_lines(night) if (event := line.get("event")) and event["type"] == "PatchChanged"
    )
    assert len(event["patch"]) < 8000
    assert len(night.show.patch.element) == 499


def _journal_lines(night):
    night.writer.close(night.engine.ticks.index)
    return [json.loads(line) for line in night.journal.read_text().splitlines()]


def test_damaged_patch_event_is_refused_without_effect(patch):
    night = WatchedShow(patch)
    before = night.show.patch
    for text in ("{", "zlib:AAAA", "{}", PATCH):
        assert not night.show.apply(PatchChanged(time=0.0, source="patch", patch=text, version="x"))
    night.run(3.0)
    assert night.show.patch is before


@pytest.mark.long
def test_step_added_later_makes_waiting_patch_valid(patch):
    night = WatchedShow(patch)
    assert not night.edit('["groove"]', '["new bow"]')
    assert "new bow" in night.watch.problem
    text = (STEPS / "samba.toml").read_text().replace('name = "samba"', 'name = "new bow"')
    (patch.parent / "moves" / "another.toml").write_text(text)
    assert not night.watch.poll()
    assert night.watch.poll()
    assert night.watch.problem == ""
    assert "new bow" in set().union(*night.run(6.0).values())


def test_watch_thread_starts_and_stops_twice(patch):
    night = WatchedShow(patch)
    night.watch.start()
    night.watch.stop()
    night.watch.stop()


@pytest.mark.long
def test_a_stage_on_which_dancers_would_stand_outside_never_reaches_the_show(patch):
    patch.write_text(PATCH + '[stage]\nwidth = 12\n[[segment]]\nmeasure = 9\nformation = "circle"\n')
    night = WatchedShow(patch)
    night.run(1.0)
    assert not night.edit("width = 12", "width = 4")
    assert "line 14: segment.1.formation: 2 dancers of 'circle' would stand outside the stage" in night.watch.problem
    assert not night.edit("width = 4", "width = 4\ndepth = 4")
    assert "4 dancers of 'circle' would stand outside the stage of 4 x 4 m" in night.watch.problem
    assert night.edit("width = 4\ndepth = 4", "width = 8")
    assert night.watch.problem == ""


@pytest.mark.long
def test_replay_starts_after_edits_of_patch_and_steps(patch):
    night = WatchedShow(patch)
    night.run(2.5)
    assert night.edit('["groove"]', '["side step"]', more="[locomotion]\ntransition_beats = 0.5\n")
    night.run(4.0)
    library = night.watch._library
    library._read = night.loaded.read_steps
    text = (STEPS / "samba.toml").read_text().replace('name = "samba"', 'name = "side step"')
    (patch.parent / "moves" / "side_step.toml").write_text(text)
    library.poll()
    assert library.poll()
    night.run(6.5)
    assert night.show.graph.leaving.any()
    night.writer.close(night.engine.ticks.index)
    journal, problems = read_journal(night.journal), []
    loaded = load_journal(journal)
    for measure in (3, 6, 99):
        start = start_before(journal, loaded, measure, problems)
        assert start.tick > 0
        result = run_from(start, journal, loaded=loaded)
        assert problems == []
        assert result.differences == ()
        assert result.measures >= (measure < 10)


@pytest.mark.long
def test_unset_group_keys_stay_unset_in_the_journal(patch):
    patch.write_text(PATCH + "[group.motion]\nlarger = 0.1\n[motion]\nhead = 0.4\n")
    night = WatchedShow(patch)
    night.run(2.5)
    assert night.edit("head = 0.4", "head = 0.6")
    night.run(3.0)
    assert (night.show.variation[HEAD][0], night.show.variation[LARGER][0]) == (0.6, 0.1)
    assert night.replayed().differences == ()


@pytest.mark.long
def test_added_sections_scenes_cues_and_signals_take_effect(patch):
    night = WatchedShow(patch)
    night.run(2.5)
    assert night.edit(
        more="""[look]
haze = 0.02
[[view]]
name = "near"
eye = [0, 2, 5]
[[scene]]
name = "dim"
set = { "/dance/light/level" = 0.2 }
measures = 1
[[cue]]
name = "one"
scene = "dim"
[[section]]
name = "a"
measures = 8
[[sequence]]
group = "all"
section = "a"
measure = 4
measures = 2
steps = ["side step"]
[[at]]
section = "a"
measure = 5
beat = 2.0
scene = "dim"
[[signal]]
name = "hey"
section = "a"
measure = 4
[[react]]
on = "hey"
call = "/dance/motion/head"
values = [0.7, "*"]
"""
    ), night.watch.problem
    danced = night.run(8.5)
    show = night.show
    assert show.score_runner.facts()["section"] == "a"
    assert danced[3] == {"groove"}
    assert danced[4] == danced[5] == {"side step"}
    assert show.variation[HEAD][0] == 0.7
    row = show.desk.parameters.picture
    assert row[LEVEL] == pytest.approx(0.2, abs=0.02)
    assert night.edit('"/dance/light/level" = 0.2', '"/dance/light/level" = 0.9')
    night.inbox.put(GiveCue(time=0.0, source="test", name="one"))
    night.run(6.0)
    assert show.desk.parameters.picture[LEVEL] == pytest.approx(0.9, abs=0.02)
    assert show.refusals.last_reason == ""
    assert night.replayed().differences == ()


def test_exception_while_reading_edit_is_reported_and_next_edit_works(patch, monkeypatch):
    night = WatchedShow(patch)
    night.run(2.5)
    counted = FAULTS.total

    def fails(path, tables):
        raise IndexError("made by a test")

    with monkeypatch.context() as broken:
        broken.setattr("live.show.patch.hot_reload.read_sources", fails)
        assert not night.edit('["groove"]', '["side step"]')
    assert FAULTS.total == counted + 1
    assert "IndexError" in night.watch.problem
    assert "the last good one goes on" in night.watch.problem
    assert night.edit(more="[motion]\nhead = 0.5\n")
    assert night.watch.problem == ""
