"""PatchWatch: an edit of the patch's files reaches the running show at the next measure, a bad one never."""

import json

import pytest

from live.base.fault_isolation import FAULTS
from live.base.picture_parameters import LEVEL
from live.control.events import events
from live.control.events.events import GiveCue, PatchChanged
from live.show.journal.journal import read_journal
from live.show.journal.replay import fresh_show, load_journal, replay, run_from, start_before
from live.show.patch.hot_reload import PatchWatch
from tests.show.patch import edited_night
from tests.show.patch.edited_night import STEPS, folder_with

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
    return folder_with(tmp_path, PATCH)


class Night(edited_night.Night):
    """A night whose patch is watched as well."""

    def __init__(self, patch):
        super().__init__(patch)
        self.watch = PatchWatch(self.loaded, self.show, post=self.inbox.put, now=self.clock.now, library=self.library)

    def edit(self, old="", new="", more="", file=None):
        """Change the patch's text, or write another `file` of it; whether the watch took it."""
        path = self.path if file is None else self.path.parent / file
        path.parent.mkdir(exist_ok=True)
        text = path.read_text() if path.exists() else ""
        assert old in text
        path.write_text(text.replace(old, new, 1) + more)
        assert not self.watch.poll()  # it may still be written
        return self.watch.poll()

    def replayed(self):
        """What a replay finds, of the journal alone."""
        self.writer.close(self.engine.ticks.index)
        journal = read_journal(self.journal)
        return replay(fresh_show(journal), journal)


def test_new_steps_are_danced_in_the_very_next_measure(patch):
    night = Night(patch)
    night.run(2.5)  # the second measure has begun
    assert night.edit('["groove"]', '["side step"]')
    danced = night.run(5.0)
    assert danced[2] == {"groove"}
    assert danced[3] == {"side step"}
    assert night.show.patch_updates.version == night.watch.status()["version"]
    assert night.watch.message == "patch: new from the next measure on: group"


def test_an_edit_after_the_next_measure_is_chosen_acts_from_the_one_after(patch):
    night = Night(patch)
    night.run(3.8)  # a tenth of a beat before the third measure
    assert night.edit('["groove"]', '["side step"]')
    danced = night.run(5.0)
    assert danced[3] == {"groove"}
    assert danced[4] == {"side step"}


def test_every_table_acts_from_its_measure_on_and_a_replay_needs_no_files(patch):
    night = Night(patch)
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
at = [2, 2]
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
    assert show.variation.head.tolist() == [0.5] * 4
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


def test_who_is_in_a_formation_goes_to_its_new_places(patch):
    night = Night(patch)
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


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ('["groove"]', '["grove"]', "show.toml, line 9: group.1.steps"),
        ('["groove"]', '["groove"]\ntravel_step = "wlak"', "show.toml, line 10: group.1.travel_step"),
        ('["groove"]', "[3]", "show.toml, line 9: group.1.steps.1"),
        ("bpm = 120", "bpm = = 3", "show.toml, line 5: not valid TOML"),
        ('["groove"]', '["groove"]\n[[segment]]\nmeasure = 1\nformation = "rnig"', "show.toml, line 10: segment.1"),
        (
            "[clock]",
            "[locomotion]\nthreshold_m = 0.011\n[clock]",
            "line 11: group.1.steps: group 'all': step 'groove' connects to no other",
        ),
    ],
)
def test_a_bad_edit_is_told_and_the_last_good_patch_goes_on(patch, old, new, where):
    night = Night(patch)
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


def test_a_file_that_the_next_start_would_refuse_is_told_when_it_is_named(patch):
    night = Night(patch)
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


def test_what_needs_a_new_start_is_named_and_the_rest_acts(patch):
    night = Night(patch)
    night.run(1.0)
    assert night.edit("dancers = 4", 'dancers = 6\nfacing = "90"', more="[stage]\nwidth = 20\n")
    assert night.watch.deferred_keys == ("stage.width", "group.1.dancers")
    assert "from the next start on" in night.watch.message
    assert "stage.width, group.1.dancers" in night.watch.message
    night.run(8.0)
    assert night.show.patch.stage.width == 12.0
    assert night.show.patch.group[0].facing == "90"
    assert night.show.dancers.present.end_heading() == pytest.approx([1.571] * 4, abs=0.3)
    text = patch.read_text()
    assert not night.edit(text, text.replace("width = 20", "width = 22"))
    assert night.watch.problem == ""


def test_what_was_set_live_stays_unless_the_edit_says_otherwise(patch):
    night = Night(patch)
    for parameter, value in (("head", 0.3), ("larger", 0.2)):
        night.inbox.put(events.SetMotion(time=0.0, source="test", parameter=parameter, value=value))
    night.run(1.0)
    assert night.edit(more="[motion]\nlarger = 0.4\n")
    night.run(2.0)
    assert night.show.variation.head[0] == 0.3
    assert night.show.variation.larger[0] == 0.4


def test_the_joins_of_steps_are_made_anew(patch):
    night = Night(patch)
    night.run(1.0)
    before = night.show.graph
    assert night.edit(more="[locomotion]\nthreshold_m = 0.5\ntransition_beats = 0.5\n")
    night.run(3.0)
    assert night.show.graph.window == 0.125
    assert night.show.graph.edge_count > before.edge_count
    assert night.replayed().differences == ()


def test_a_long_patch_is_short_in_the_journal(patch):
    night = Night(patch)
    entry = '[[element]]\nkind = "wander"\nmeasure = {}\nmeasures = 1\n'
    assert night.edit(file="score/a.toml", more="".join(entry.format(n) for n in range(1, 500)))
    night.run(3.0)
    event = next(event for line in _lines(night) if (event := line.get("event")) and event["type"] == "PatchChanged")
    assert len(event["patch"]) < 8000
    assert len(night.show.patch.element) == 499


def _lines(night):
    night.writer.close(night.engine.ticks.index)
    return [json.loads(line) for line in night.journal.read_text().splitlines()]


def test_a_damaged_event_is_refused_and_changes_nothing(patch):
    night = Night(patch)
    before = night.show.patch
    for text in ("{", "zlib:AAAA", "{}", PATCH):
        assert not night.show.apply(PatchChanged(time=0.0, source="patch", patch=text, version="x"))
    night.run(3.0)
    assert night.show.patch is before


def test_a_step_that_comes_later_mends_the_patch_that_names_it(patch):
    night = Night(patch)
    assert not night.edit('["groove"]', '["new bow"]')
    assert "new bow" in night.watch.problem
    text = (STEPS / "samba.toml").read_text().replace('name = "samba"', 'name = "new bow"')
    (patch.parent / "moves" / "another.toml").write_text(text)
    assert not night.watch.poll()
    assert night.watch.poll()
    assert night.watch.problem == ""
    assert "new bow" in set().union(*night.run(6.0).values())


def test_the_thread_starts_and_stops(patch):
    night = Night(patch)
    night.watch.start()
    night.watch.stop()
    night.watch.stop()


@pytest.mark.long
def test_a_replay_can_begin_after_an_edit_of_patch_and_steps(patch):
    night = Night(patch)
    night.run(2.5)
    assert night.edit('["groove"]', '["side step"]', more="[locomotion]\ntransition_beats = 0.5\n")
    night.run(4.0)
    library = night.watch._library
    library._read = night.loaded.clips
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


def test_what_a_group_leaves_out_is_left_out_in_the_journal_too(patch):
    patch.write_text(PATCH + "[group.motion]\nlarger = 0.1\n[motion]\nhead = 0.4\n")
    night = Night(patch)
    night.run(2.5)
    assert night.edit("head = 0.4", "head = 0.6")
    night.run(3.0)
    assert (night.show.variation.head[0], night.show.variation.larger[0]) == (0.6, 0.1)
    assert night.replayed().differences == ()


def test_sections_scenes_cues_and_signals_act_as_soon_as_they_are_written(patch):
    night = Night(patch)
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
    assert show.variation.head[0] == 0.7
    row = show.desk.parameters.picture
    assert row[LEVEL] == pytest.approx(0.2, abs=0.02)
    assert night.edit('"/dance/light/level" = 0.2', '"/dance/light/level" = 0.9')
    night.inbox.put(GiveCue(time=0.0, source="test", name="one"))
    night.run(6.0)
    assert show.desk.parameters.picture[LEVEL] == pytest.approx(0.9, abs=0.02)
    assert show.refusals.last_reason == ""
    assert night.replayed().differences == ()


def test_a_fault_of_the_program_while_it_reads_an_edit_is_told_and_the_next_edit_is_taken(patch, monkeypatch):
    night = Night(patch)
    night.run(2.5)
    counted = FAULTS.total

    def fails(path):
        raise IndexError("made by a test")

    with monkeypatch.context() as broken:
        broken.setattr("live.show.patch.hot_reload.read_sources", fails)
        assert not night.edit('["groove"]', '["side step"]')
    assert FAULTS.total == counted + 1
    assert "IndexError" in night.watch.problem
    assert "the last good one goes on" in night.watch.problem
    assert night.edit(more="[motion]\nhead = 0.5\n")
    assert night.watch.problem == ""
