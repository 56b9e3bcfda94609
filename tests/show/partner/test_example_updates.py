"""Examples that are added while the show runs: learnt beside it, danced from a measure line on, replayed (H026)."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from live.control.events.events import ExamplesChanged
from live.motion.formats.bvh_writer import write_bvh
from live.motion.partner_live.stage_partner import LeaderReader
from live.show.journal.journal import read_journal
from live.show.journal.replay import ReplayError, first_start, load_journal, replay, run_from, start_before
from live.show.loader import load_show
from live.show.partner.example_bank import ExampleBank
from live.show.partner.example_updates import ExamplesWatch, former_texts, texts_of, weights_text
from live.show.state.snapshot import SnapshotError, restore, snapshot
from live.supervisor.recovery import Recovery
from live.supervisor.state_follower import StateFollower
from tests.motion.partner.test_answer import random_dance_clip
from tests.show.partner.test_example_style import write_pairs
from tests.show.patch.edited_night import JournaledShow, write_patch_folder

NIGHT = """name = "night"
steps = "moves"
reserve = 0
[clock]
bpm = 120
[[group]]
name = "all"
dancers = 2
steps = ["groove"]
[[partner]]
name = "duet"
leader = "1"
follower = "2"
examples = "pairs.toml"
"""
ADDED = (
    '\n[[pair]]\nleader = { file = "d_leader.bvh", bpm = 164, first_beat_s = 0.3 }\n'
    'follower = { file = "d_follower.bvh" }\nstyle = "wild"\n'
)


class WatchedNight(JournaledShow):
    """A journaled show whose pairs are watched."""

    def __init__(self, patch: Path) -> None:
        super().__init__(patch)
        self.events: list[ExamplesChanged] = []
        self.watch = ExamplesWatch(
            patch, self.loaded.graph.library, self.show.hot_swap.answers, offer=self.show.hot_swap.offer_examples,
            post=self.inbox.put, now=self.clock.now,
        )  # fmt: skip

    def edit(self, text: str) -> bool:
        """Write the pairs; return whether they were taken."""
        (self.path.parent / "pairs.toml").write_text(text)
        assert not self.watch.poll(self.show.patch)  # it may still be written
        return self.watch.poll(self.show.patch)

    @property
    def pairs(self) -> str:
        """What the file of pairs holds."""
        return (self.path.parent / "pairs.toml").read_text()

    def reader(self) -> LeaderReader:
        """The reader of the leader."""
        answering = self.show.dancers.partner_response
        assert answering is not None
        (read,) = answering.leaders.readers.values()
        return read

    def names(self) -> set[str]:
        """The recordings that the follower may dance."""
        return {one.name for one in self.reader().partner.filter.units.examples}

    def closed(self):
        """The journal, closed."""
        self.writer.close(self.engine.ticks.index)
        return read_journal(self.journal)


@pytest.fixture(name="night")
def _night(tmp_path: Path) -> WatchedNight:
    path = write_patch_folder(tmp_path, NIGHT)
    write_pairs(tmp_path, ((61, "a", "soft"), (65, "c", "hard")))
    for side, seed in (("leader", 71), ("follower", 72)):
        (tmp_path / f"d_{side}.bvh").write_text(write_bvh(random_dance_clip(seed, 300), rate=30.0))
    return WatchedNight(path)


@pytest.mark.long
def test_a_pair_that_is_added_is_danced_from_the_next_measure_line_on_and_in_a_replay(night: WatchedNight) -> None:
    night.run(4.5)
    assert night.names() == {"a_follower", "c_follower"}
    danced = night.reader().partner.filter.frame_index
    assert night.edit(night.pairs + ADDED)
    assert night.watch.last_change.startswith("new examples: pairs.toml: 3 recordings, all of them count alike")
    night.run(0.1)
    assert night.names() == {"a_follower", "c_follower"}
    night.run(2.0)
    assert night.names() == {"a_follower", "c_follower", "d_follower"}
    assert night.reader().partner.filter.frame_index > danced  # it goes on
    assert sorted(night.reader().examples.filters) == ["", "hard", "soft", "wild"]
    assert night.edit(night.pairs.replace("first_beat_s = 0.3", "first_beat_s = 0.4"))
    night.run(6.0)
    journal = night.closed()
    loaded = load_journal(journal)
    assert loaded.answers is not None
    assert loaded.answers.digest() == night.loaded.answers.digest()  # as it began, though the file has changed
    found = replay(first_start(journal, loaded).show, journal)
    assert found.measures > 5
    assert found.different == 0


@pytest.mark.long
def test_a_spare_engine_that_has_loaded_the_new_file_reaches_the_same_state(night: WatchedNight) -> None:
    night.run(2.5)
    assert night.edit(night.pairs + ADDED)
    night.run(4.0)
    night.closed()
    following = StateFollower(load_show(night.path))
    for line in night.journal.read_text().splitlines():
        following.add_line(line)
    show = Recovery(following).run().show
    assert following.compared >= 3
    assert following.differences == 0
    assert following.loaded.answers is show.hot_swap.answers
    assert show.hot_swap.answers.digest() == night.show.hot_swap.answers.digest() != night.loaded.answers.digest()


@pytest.mark.long
def test_a_snapshot_of_the_new_examples_needs_them(night: WatchedNight) -> None:
    night.run(2.5)
    assert night.edit(night.pairs + ADDED)
    night.run(4.0)
    data = snapshot(night.show)
    with pytest.raises(SnapshotError, match="other examples of partners"):
        restore(night.loaded, data)
    loaded = replace(night.loaded, answers=night.show.hot_swap.answers)
    again = restore(loaded, data)
    assert again.state_hash() == night.show.state_hash()
    night.run(3.0)
    journal = night.closed()
    later = load_journal(journal)
    problems: list[str] = []
    start = start_before(journal, later, 4, problems)
    assert problems == []
    found = run_from(start, journal)
    assert found.different == 0
    assert found.measures > 0


@pytest.mark.long
def test_examples_that_cannot_be_danced_are_refused_and_the_present_ones_stay(night: WatchedNight) -> None:
    night.run(2.5)
    for text, words in (
        (night.pairs + ADDED.replace("d_leader", "e_leader"), "e_leader.bvh"),
        (night.pairs + ADDED.replace("style", "stile"), "stile"),
        (night.pairs + ADDED + "x", "not valid TOML"),
        (night.pairs + ADDED.replace('leader.bvh"', 'leader.bvh", fps = 60'), "frames a second"),
        ("unit_beats = 4\n" + night.pairs, "other units"),
    ):
        before = night.pairs
        assert not night.edit(text)
        assert words in night.watch.problem
        assert "the present ones stay" in night.watch.problem
        assert not night.edit(before)
        assert night.watch.problem == ""
    night.run(4.0)
    assert night.names() == {"a_follower", "c_follower"}
    assert night.edit(night.pairs + ADDED)
    assert night.watch.problem == ""


@pytest.mark.long
def test_a_style_that_the_new_examples_have_not_is_left_and_told(night: WatchedNight) -> None:
    answering = night.show.dancers.partner_response
    assert answering is not None
    answering.set_style("duet", "hard")
    night.run(2.5)
    assert night.names() == {"c_follower"}
    assert night.edit(night.pairs.replace('style = "hard"', 'style = "soft"'))
    night.run(2.5)
    assert night.names() == {"a_follower", "c_follower"}
    assert answering.settings[0].style == ""
    assert "no example has the style 'hard' any more" in night.show.refusals.last_reason


def test_an_event_whose_examples_nobody_has_is_refused(night: WatchedNight) -> None:
    before = night.show.refusals.count
    night.show.apply(ExamplesChanged(time=0.0, source="examples", was="{}", now="{}", bank="0"))
    assert night.show.refusals.count == before + 1
    assert night.show.hot_swap.at_rest


@pytest.mark.long
def test_a_replay_with_other_recordings_is_refused(night: WatchedNight) -> None:
    night.run(2.5)
    assert night.edit(night.pairs + ADDED)
    night.run(2.5)
    journal = night.closed()
    (night.path.parent / "d_follower.bvh").write_text(write_bvh(random_dance_clip(73, 300), rate=30.0))
    with pytest.raises(ReplayError, match=r"recordings of .*partner.* have changed"):
        load_journal(journal)


def test_texts_of_events() -> None:
    def event(was: dict[str, str]) -> ExamplesChanged:
        return ExamplesChanged(time=0.0, source="examples", was=json.dumps(was), now="{}", bank="0")

    assert former_texts([event({"a": "1"}), event({"a": "2", "b": "3"})]) == {"a": "1", "b": "3"}
    for damaged in ("[]", '{"a": 1}', "{", "zlib:x"):
        with pytest.raises(ValueError, match=r"."):
            texts_of(damaged)
    assert weights_text(ExampleBank(())) == "0 recordings, all of them count alike"
