"""`style` of a `[[partner]]`: which pairs of its examples are danced, at the start and while the show runs (H025)."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.motion.formats.bvh_writer import write_bvh
from live.motion.partner_live.stage_partner import LeaderReader
from live.show.assembly import assemble
from live.show.loader import LoadedShow
from live.show.partner.example_bank import ExampleBank
from live.show.partner.partner_sources import load_example_bank
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import fresh_show, patch_version, prepare_patch, split_deferred
from live.show.show import Show
from live.show.state.snapshot import Snapshotter, restore, snapshot
from live.show.view.status import Status
from live.show.view.telemetry import CurrentValues
from tests.motion.partner.test_answer import random_dance_clip
from tests.show.partner.answering_show import FOLLOWER, GRAPH, PATCH, run

PARTNER = '[[partner]]\nname = "duet"\nleader = "front & 1"\nfollower = "back & 6"\nexamples = "pairs.toml"\n'
STAMP = {"time": 0.0, "source": "osc"}


def write_pairs(folder: Path, styles: tuple[tuple[int, str, str], ...]) -> None:
    lines = []
    for seed, name, style in styles:
        for side, more in (("leader", 0), ("follower", 1)):
            (folder / f"{name}_{side}.bvh").write_text(write_bvh(random_dance_clip(seed + more, 300), rate=30.0))
        lines.append(
            f'[[pair]]\nleader = {{ file = "{name}_leader.bvh", bpm = 164, first_beat_s = 0.3 }}\n'
            f'follower = {{ file = "{name}_follower.bvh" }}\n' + (f'style = "{style}"\n' if style else "")
        )
    (folder / "pairs.toml").write_text("\n".join(lines))


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    write_pairs(tmp_path, ((61, "a", "soft"), (63, "b", ""), (65, "c", "Hard")))
    return tmp_path


def bank_in(folder: Path, more: str = "") -> ExampleBank:
    bank = load_example_bank(parse_patch(PATCH + PARTNER + more, "test.toml"), folder / "test.toml", GRAPH.library)
    assert bank is not None
    return bank


@cache
def styled_bank() -> ExampleBank:
    """Two pairs of one style each, and one of every style."""
    with TemporaryDirectory() as name:
        write_pairs(Path(name), ((61, "a", "soft"), (63, "b", ""), (65, "c", "Hard")))
        return bank_in(Path(name))


def styled_show(more: str = "") -> Show:
    return assemble(parse_patch(PATCH + PARTNER + more, "test.toml"), GRAPH, seed=3, answers=styled_bank())


def reader_of(show: Show) -> LeaderReader:
    answering = show.dancers.partner_response
    assert answering is not None
    (read,) = answering.leaders.readers.values()
    return read


def known_to(read: LeaderReader) -> set[str]:
    return {one.name for one in read.partner.filter.units.examples}


def set_style(show: Show, style: str, partner: str = "*") -> bool:
    return show.apply(events.StylePartner(style=style, partner=partner, **STAMP))


@pytest.mark.long
def test_a_style_has_its_pairs_and_those_without_one(folder: Path) -> None:
    bank = bank_in(folder)
    (lore,) = bank.example_sets
    known = {name: {one.name for one in read.units.examples} for name, read in lore.filters.items()}
    assert known == {
        "": {"a_follower", "b_follower", "c_follower"},
        "soft": {"a_follower", "b_follower"},
        "hard": {"b_follower", "c_follower"},
    }
    with pytest.raises(PersonError, match="no pair has the style 'x'; there are: hard, soft") as told:
        bank_in(folder, 'style = "x"\n')
    assert told.value.key_path == ("partner", 0, "style")
    without = (folder / "pairs.toml").read_text().replace("style", "# style")
    (folder / "pairs.toml").write_text(without)
    assert set(bank_in(folder).example_sets[0].filters) == {""}
    assert bank_in(folder).digest() != bank.digest()


def test_a_style_with_too_little_is_refused_at_the_start(folder: Path) -> None:
    write_pairs(folder, ((61, "a", "soft"), (65, "c", "hard")))
    with (folder / "pairs.toml").open("a") as file:
        file.write(
            '\n[[pair]]\nleader = { file = "a_leader.bvh" }\nfollower = { file = "a_follower.bvh" }\n'
            'cuts_s = [1.0, 1.7]\nstyle = "scant"\n'
        )
    with pytest.raises(PersonError, match="style 'scant': 1 unit"):
        bank_in(folder)


@pytest.mark.long
def test_a_patch_says_the_style_of_the_beginning_and_an_edit_changes_it() -> None:
    with pytest.raises(PersonError, match="style without examples"):
        parse_patch(PATCH + PARTNER.replace('examples = "pairs.toml"', 'style = "soft"'), "test.toml")
    one, other, wrong = (
        parse_patch(PATCH + PARTNER + f'style = "{style}"\n', "test.toml") for style in ("Soft ", "hard", "x")
    )
    assert split_deferred(other, one)[1] == ()
    show = assemble(one, GRAPH, seed=3, answers=styled_bank())
    assert known_to(reader_of(show)) == {"a_follower", "b_follower"}
    run(show, 1.0)
    text = other.model_dump_json()
    show.hot_swap.offer_patch(prepare_patch(text, show.hot_swap.make_show, one, show.graph))
    show.apply(events.PatchChanged(patch=text, version=patch_version(text), **STAMP))
    run(show, 4.1)
    assert known_to(reader_of(show)) == {"b_follower", "c_follower"}
    with pytest.raises(PersonError, match="no pair has the style 'x'") as told:
        fresh_show(wrong, show.hot_swap.make_show, show.patch, show.graph)
    assert told.value.key_path == ("partner", 0, "style")


@pytest.mark.long
def test_the_style_changes_while_the_follower_dances_and_the_follower_does_not_jump() -> None:
    show, plain = styled_show(), styled_show()
    read = reader_of(show)
    for _ in range(40):  # until a recording is danced that another style has not
        assert np.array_equal(run(show, 0.5), run(plain, 0.5))
        danced = read.partner.filter.units.examples[read.partner._example].name
        if show.time > 5.0 and danced != "b_follower":
            break
    assert danced != "b_follower"
    posterior = read.partner.filter.posterior.sum()
    style, names = (
        ("HARD", {"b_follower", "c_follower"}) if danced[0] == "a" else ("soft ", {"a_follower", "b_follower"})
    )
    assert set_style(show, style)
    assert known_to(read) == names
    assert read.partner.filter.units.examples[read.partner._example].name in names
    assert read.partner.filter.posterior.sum() == pytest.approx(posterior, abs=0.02)
    away = np.linalg.norm(run(show, 1.0)[:, FOLLOWER] - run(plain, 1.0)[:, FOLLOWER], axis=-1).max(axis=1)
    assert away[0] < 0.005
    assert away[2] < 0.03
    assert away.max() > 0.02
    posterior = read.partner.filter.posterior.copy()
    assert set_style(show, "")
    assert known_to(read) == {"a_follower", "b_follower", "c_follower"}
    known = read.partner.filter.posterior
    assert np.sort(known)[-3:] == pytest.approx(np.sort(posterior)[-3:], abs=0.02)


@pytest.mark.long
def test_a_change_of_style_is_the_same_in_every_run_and_in_a_snapshot() -> None:
    shows = [styled_show() for _ in range(2)]
    hashes = []
    for show in shows:
        run(show, 3.0)
        assert set_style(show, "soft", "duet")
        run(show, 3.0)
        hashes.append(show.state_hash())
    assert hashes[0] == hashes[1]
    show = shows[0]
    loaded = LoadedShow(Path("test.toml"), show.patch, GRAPH, answers=styled_bank())
    data = snapshot(show)
    again = restore(loaded, data)
    assert reader_of(again).style == "soft"
    assert np.array_equal(run(show, 2.0), run(again, 2.0))
    assert Snapshotter(again).capture(round(again.time / TICK)) is not None


def test_a_style_that_nobody_has_is_refused_and_nothing_changes() -> None:
    show = styled_show('style = "soft"\n')
    refused = show.refusals.count
    assert not set_style(show, "x")
    assert not set_style(show, "hard", "quartet")
    assert show.refusals.count == refused + 2
    assert "no partner is called 'quartet'" in show.refusals.last_reason
    assert known_to(reader_of(show)) == {"a_follower", "b_follower"}
    values = CurrentValues(show, Status(show, rejected=dict, memory=lambda: 1.0)).changes()
    assert values["/dance/partner/style"] == (("duet", ("soft",)),)
