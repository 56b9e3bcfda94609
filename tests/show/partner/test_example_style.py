"""`style` of a `[[partner]]`: which pairs of its examples are danced (H025)."""

from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.motion.formats.bvh_writer import write_bvh
from live.show.partner.partner_sources import load_example_bank
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import split_deferred
from tests.motion.partner.test_answer import random_dance_clip
from tests.show.partner.answering_show import GRAPH, PATCH

PARTNER = '[[partner]]\nname = "duet"\nleader = "front & 1"\nfollower = "back & 1"\nexamples = "pairs.toml"\n'


@pytest.fixture(name="folder")
def _folder(tmp_path: Path) -> Path:
    lines = []
    for seed, name, style in ((61, "a", "soft"), (63, "b", ""), (65, "c", "Hard")):
        for side, more in (("leader", 0), ("follower", 1)):
            (tmp_path / f"{name}_{side}.bvh").write_text(write_bvh(random_dance_clip(seed + more, 300), rate=30.0))
        lines.append(
            f'[[pair]]\nleader = {{ file = "{name}_leader.bvh", bpm = 164, first_beat_s = 0.3 }}\n'
            f'follower = {{ file = "{name}_follower.bvh" }}\n' + (f'style = "{style}"\n' if style else "")
        )
    (tmp_path / "pairs.toml").write_text("\n".join(lines))
    return tmp_path


def labels_of(folder: Path, more: str) -> set[str]:
    patch = parse_patch(PATCH + PARTNER + more, "test.toml")
    bank = load_example_bank(patch, folder / "test.toml", GRAPH.library)
    assert bank is not None
    return set(bank.labels)


def test_only_pairs_of_the_style_and_those_without_one_are_danced(folder: Path) -> None:
    assert labels_of(folder, "") == {"a_follower", "b_follower", "c_follower"}
    assert labels_of(folder, 'style = "soft"\n') == {"a_follower", "b_follower"}
    assert labels_of(folder, 'style = "hard"\n') == {"b_follower", "c_follower"}
    with pytest.raises(PersonError, match="no pair has the style 'x'; there are: hard, soft") as told:
        labels_of(folder, 'style = "x"\n')
    assert told.value.key_path[:2] == ("partner", 0)


def test_a_style_needs_examples_and_waits_for_the_next_start() -> None:
    with pytest.raises(PersonError, match="style without examples"):
        parse_patch(PATCH + PARTNER.replace('examples = "pairs.toml"', 'style = "soft"'), "test.toml")
    one, other = (parse_patch(PATCH + PARTNER + f'style = "{style}"\n', "test.toml") for style in ("soft", "hard"))
    assert split_deferred(other, one)[1] == ("partner",)
