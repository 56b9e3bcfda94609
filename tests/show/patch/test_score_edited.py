"""Score edits while the show runs: steps, improvisations and calls take effect at the next measure."""

import pytest

from live.control.events.events import Improvise, PatchChanged
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import patch_version
from tests.show.made_show import PATCH, made_show
from tests.show.score.test_sequences import steps_of


def patch_edit(extra):
    text = parse_patch(PATCH + extra, "test.toml").model_dump_json()
    return lambda time: PatchChanged(time=time, source="patch", patch=text, version=patch_version(text))


BEFORE = '[[sequence]]\nmeasures = 16\nsteps = ["sway"]\n'


def test_edited_sequence_is_danced_from_next_measure():
    after = '[[sequence]]\nmeasures = 16\nsteps = ["spin", "glide"]\n'
    danced = steps_of(made_show(BEFORE), 15, does={64 * 5: patch_edit(after)})
    assert danced[:3] == ["sway"] * 3
    assert danced[3:7] == ["glide", "spin", "glide", "spin"]


@pytest.mark.long
def test_removed_sequence_is_replaced_by_group_steps():
    danced = steps_of(made_show(BEFORE), 13, does={64 * 5: patch_edit("")})
    assert danced[:6] == ["sway"] * 3 + ["sway", "glide", "glide"]


@pytest.mark.long
def test_improvisation_starts_by_edit_and_survives_another():
    after = BEFORE + "[[improvise]]\nmeasure = 17\nsteps = {spin = 1, glide = 1}\n"
    does = {
        64 * 5: patch_edit(after),
        64 * 6: lambda time: Improvise(time=time, source="osc", on=True, group="front"),
        64 * 11: patch_edit(after.replace("spin = 1", "spin = 2")),
    }
    danced = steps_of(made_show(BEFORE), 20, does=does)
    assert danced[:3] == ["sway"] * 3
    assert set(danced[4:]) == {"spin", "glide"}


def test_overlapping_edit_is_refused_and_score_continues():
    show = made_show(BEFORE)
    twice = '"sequence":[{"group":"front","measure":3,"steps":["spin"]},'
    text = show.patch.model_dump_json().replace('"sequence":[', twice)
    does = {64 * 5: lambda time: PatchChanged(time=time, source="patch", patch=text, version=patch_version(text))}
    assert steps_of(show, 11, does=does) == ["sway"] * 6
    assert "lasts until the end of measure" in show.refusals.last_reason


def test_calls_and_signals_of_edited_score_act():
    call = '[[at]]\nmeasure = 5\nsignal = "hit"\n[[react]]\non = "hit"\nwhen = "now"\ncall = "/dance/spread"\n'
    show = made_show(BEFORE)
    steps_of(show, 10, does={64 * 5: patch_edit(BEFORE + call)})
    assert show.score_runner.signals == {"hit": 1}
    assert [element.source for element in show.motion.elements.in_force] == ["music"]
