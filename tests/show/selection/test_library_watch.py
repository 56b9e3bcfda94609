"""LibraryWatch: takes that are recorded while the show runs join the dance, and replays include them."""

from dataclasses import replace

import numpy as np
import pytest

from live.control.events import events
from live.show.journal.journal import read_journal
from live.show.journal.replay import ReplayError, first_start, load_journal, replay
from live.show.loader import load_show
from live.show.selection.library_watch import same_clip
from tests.motion.formats.made_bvh import body_bvh, still
from tests.show.patch.edited_night import STEPS, JournaledShow, write_patch_folder

PATCH = """
name = "growing"
steps = "moves"
[[group]]
name = "all"
dancers = 6
steps = ["groove", "side step"]
choose = "random"
[[group]]
name = "one"
dancers = 1
steps = ["groove"]
"""


@pytest.fixture
def patch(tmp_path):
    """A show with a folder of two steps of its own; others come from the project, under other names."""
    return write_patch_folder(tmp_path, PATCH)


def fresh_show(journal):
    """A fresh show of the journal's patch, steps and seed."""
    return first_start(journal, load_journal(journal)).show


def add_step(patch, name="new bow"):
    text = (STEPS / "samba.toml").read_text().replace('name = "samba"', f'name = "{name}"')
    assert name in text
    (patch.parent / "moves" / "another.toml").write_text(text)


@pytest.mark.long
def test_new_take_is_danced_from_next_measure_line(patch):
    night = JournaledShow(patch)
    night.run(3)
    before = night.show.graph
    add_step(patch)
    assert not night.library.poll()  # the folder has changed: it may still be written
    assert night.library.poll()
    night.run(3)
    assert night.show.graph is not before
    assert night.show.graph.library.steps[: len(before.library.steps)] == before.library.steps
    assert night.show.apply(events.CallStep(time=0.0, source="test", name="new bow"))
    night.run(6)
    assert "new bow" in night.names()
    assert not night.library.poll()


@pytest.mark.long
def test_replay_with_new_take_is_bit_identical(patch):
    night = JournaledShow(patch)
    night.run(3)
    add_step(patch)
    night.library.poll()
    assert night.library.poll()
    night.run(3)
    night.inbox.put(events.CallStep(time=night.clock.now(), source="test", name="new bow"))
    night.run(6)
    night.writer.close(night.engine.ticks.index)
    journal = read_journal(night.journal)
    fresh = fresh_show(journal)
    assert "new bow" not in fresh.graph.library.steps
    result = replay(fresh, journal)
    assert result.measures >= 4
    assert result.differences == ()
    (patch.parent / "moves" / "another.toml").unlink()
    assert replay(fresh_show(journal), journal).differences  # the take is gone: the replay says so


def test_unreadable_step_is_reported_and_show_continues(patch):
    night = JournaledShow(patch)
    night.run(1)
    (patch.parent / "moves" / "broken.toml").write_text('name = "x"\nbeats = ')
    night.library.poll()
    assert not night.library.poll()
    assert "broken.toml" in night.library.problem
    night.run(3)
    (patch.parent / "moves" / "broken.toml").unlink()
    add_step(patch)
    night.library.poll()
    assert night.library.poll()
    assert night.library.problem == ""
    assert night.library.last_change == "new steps: new bow can be danced"


@pytest.mark.long
def test_step_of_another_meter_is_reported(patch):
    night = JournaledShow(patch)
    text = (STEPS / "samba.toml").read_text().replace('name = "samba"', 'name = "march"')
    (patch.parent / "moves" / "march.toml").write_text(text.replace("beats = ", "beats_per_measure = 2\nbeats = ", 1))
    night.library.poll()
    assert not night.library.poll()
    assert "march" in night.library.problem
    assert "4 beats" in night.library.problem


@pytest.mark.long
def test_recording_that_fits_no_tempo_of_the_show_is_reported(patch):
    """The show is at 112 bpm; a take at 30 would be danced four times too fast."""
    night = JournaledShow(patch)
    moves = patch.parent / "moves"
    (moves / "slow.bvh").write_text(body_bvh(still(1200)))
    (moves / "slow.toml").write_text('file = "slow.bvh"\nname = "slow"\nbpm = 30\nfirst_beat_s = 9\n')
    night.library.poll()
    assert not night.library.poll()
    assert "new steps: step 'slow'" in night.library.problem
    assert "was recorded at 30 bpm and the show is at 112 bpm" in night.library.problem
    (moves / "slow.toml").write_text('file = "slow.bvh"\nname = "slow"\nbpm = 50\nfirst_beat_s = 9\n')
    night.library.poll()
    assert night.library.poll()
    assert night.library.problem == ""
    assert [clip.measures for clip in night.library.graph.library.clips if clip.step == "slow"] == [2]  # half time


def test_steps_event_without_clips_is_refused(patch):
    night = JournaledShow(patch)
    event = events.StepsAdded(time=0.0, source="osc", clips="nothing | here | as made", library="00")
    assert not night.show.apply(event)
    assert "do not exist" in night.show.refusals.last_reason


def test_project_steps_are_not_watched():
    from live.show.patch.patch_search_path import DEFAULT_PATCH

    assert load_show(DEFAULT_PATCH).steps_folder is None


@pytest.mark.long
def test_journal_with_changed_steps_is_refused(patch):
    night = JournaledShow(patch)
    night.run(1)
    night.writer.close(night.engine.ticks.index)
    add_step(patch)  # what has come since is left out
    assert fresh_show(read_journal(night.journal)).graph.library.steps == night.show.graph.library.steps
    change_step(patch)
    with pytest.raises(ReplayError, match="changed"):
        fresh_show(read_journal(night.journal))


class FullLibraryShow(JournaledShow):
    """A journaled show whose folder of steps is polled until it is read."""

    def look(self):
        self.library.poll()
        return self.library.poll()

    def clips(self):
        """The library indices of the current clips."""
        return set(self.show.graph.library.node_clip[self.show.dancers.node].tolist())


def change_step(patch, name="groove"):
    """Changes a step's file: its clip is that of another step."""
    path = patch.parent / "moves" / f"{name}.toml"
    text = path.read_text()
    keys = [line for line in text.splitlines() if line.startswith("root = ") or "hips" in line]
    changed = (STEPS / "reach.toml").read_text().replace('name = "reach"', f'name = "{name.replace("_", " ")}"')
    assert changed != text, keys
    path.write_text(changed)


@pytest.mark.long
def test_changed_step_is_danced_and_replayed_without_its_file(patch):
    night = FullLibraryShow(patch)
    night.run(3)
    before = night.show.graph.library
    change_step(patch)
    assert night.look()
    assert night.library.last_change == "new steps: groove danced as they are now"
    night.run(8)
    library = night.show.graph.library
    assert library.steps == before.steps
    old = {n for n, clip in enumerate(before.clips) if clip.step == "groove"}
    assert not night.clips() & old
    assert "groove" in night.names()
    takes = night.show.graph.takes
    assert not night.show.graph.leaving[takes.node].any()
    (patch.parent / "moves" / "groove.toml").unlink()  # a replay does not ask the file, neither then nor now
    night.writer.close(night.engine.ticks.index)
    journal = read_journal(night.journal)
    result = replay(fresh_show(journal), journal)
    assert result.measures >= 4
    assert result.differences == ()


@pytest.mark.long
def test_deleted_step_is_finished_and_never_started_again(patch):
    (patch.parent / "show.toml").write_text(PATCH.replace('["groove", "side step"]', '["groove", "side step", "walk"]'))
    add_step(patch)
    text = (patch.parent / "show.toml").read_text()
    (patch.parent / "show.toml").write_text(text.replace('"walk"', '"walk", "new bow"', 1))
    night = FullLibraryShow(patch)
    night.run(3)
    (patch.parent / "moves" / "another.toml").unlink()
    assert night.look()
    assert night.library.last_change == "new steps: new bow not begun any more"
    night.run(4)
    later = set()
    for _ in range(8):
        night.run(2)
        later |= night.names()
    assert "new bow" not in later
    assert night.show.refusals.count == 0
    night.writer.close(night.engine.ticks.index)
    journal = read_journal(night.journal)
    assert replay(fresh_show(journal), journal).differences == ()


def test_deletion_of_needed_step_is_refused(patch):
    add_step(patch)
    (patch.parent / "show.toml").write_text(PATCH.replace('["groove"]', '["new bow"]'))
    night = FullLibraryShow(patch)
    night.library.check = lambda graph: night.show.hot_swap.make_show(night.show.patch, graph)
    night.run(1)
    before = night.library.graph
    (patch.parent / "moves" / "another.toml").unlink()
    assert not night.look()
    assert "new bow" in night.library.problem
    assert night.library.graph is before
    night.library.retry()
    assert not night.library.poll()  # as before: it is looked at once more


def test_invalid_steps_changed_event_is_refused(patch):
    night = FullLibraryShow(patch)
    for gone, now in (("nothing | here | as made", ""), ("", "AAAA"), ("x", "no base64!")):
        event = events.StepsChanged(time=0.0, source="library", gone=gone, was="", now=now, library="0")
        assert not night.show.apply(event)


@pytest.mark.long
def test_clip_comparison_is_bitwise(patch):
    first, again = load_show(patch).read_steps().clips, load_show(patch).read_steps().clips
    assert all(same_clip(one, other) for one, other in zip(first, again, strict=True))
    assert not same_clip(first[0], first[1])
    moved = replace(first[0].clip, root_position=first[0].clip.root_position + np.float32(1e-6))
    assert not same_clip(first[0], replace(first[0], clip=moved))
    assert not same_clip(first[0], replace(first[0], author="else"))
