"""Random patch edits at any tick: the show continues, and a replay that prepares them itself has the same states."""

import random

import pytest

from live.base.compression import compress_text
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events.events import PatchChanged
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_update import patch_version, prepare_patch, split_deferred
from live.show.patch.table_batches import patch_json
from tests.show.made_show import PATCH, made_show

FRONT = (
    'steps = ["sway"]',
    'steps = ["spin", "sway", "glide"]\nchoose = "random"',
    'steps = ["phrase", "sway x2"]',
    'like = "back"\nbeats_later = 4',
    'like = "back"\nmirrored = true',
)
BACK = ('steps = ["glide", "sway"]', 'steps = ["spin"]', 'steps = ["phrase"]\nchoose = "random"')
MORE = (
    '[[element]]\nkind = "wander"\nmeasure = {n}\nmeasures = 1',
    '[[segment]]\nmeasure = {n}\nmeasures = 1\ngroup = "back"\nformation = "circle"',
    '[[formation]]\nname = "ring {n}"\nshape = "circle"\n'
    '[[segment]]\nmeasure = {n}\ngroup = "front"\nformation = "ring {n}"\nhold = true',
    "[motion]\nhead = 0.{n}",
    "[locomotion]\ntransition_beats = 0.{n}",
    "[locomotion]\ncorrection_m = 0.0",
    '[[section]]\nname = "a"\nmeasures = {n}\n[[section]]\nname = "b"\nmeasures = 2\nrepeat = 2',
    '[[regroup]]\nmeasure = {n}\ndancers = "1-2"\ngroup = "back"',
    '[[react]]\nto = "loudness"\nsets = "amplitude"',
    '[[obstacle]]\nname = "chair {n}"\nat = [{n}, 1]',
    "[look]\nhaze = 0.0{n}",
)


def random_patch_text(chance):
    """A random patch, as text."""
    head, front, back = PATCH.split("[[group]]")
    said = 'steps = ["sway", "glide x2", "spin", "phrase"]'
    front = front.replace(said, chance.choice(FRONT)) + f'facing = "{chance.choice(("public", "path", "40"))}"\n'
    back = back.replace('steps = ["glide", "sway", "spin"]\nchoose = "random"', chance.choice(BACK))
    back += f"ripple_beats = {chance.choice((0, 2))}\n"
    more = "\n".join(text.format(n=chance.randint(1, 6)) for text in chance.sample(MORE[:4] + MORE[7:], 3))
    more += "\n" + chance.choice(MORE[4:7]).format(n=chance.randint(2, 6))
    return head + "[[group]]" + front + "[[group]]" + back + more + "\n"


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
def test_random_edits_at_any_tick_keep_shows_identical(seed):
    chance, shows = random.Random(seed), (made_show(), made_show())
    running, patches = shows[0].patch, 0
    for tick in range(1, 64 * 20):
        if chance.random() < 0.02:
            try:  # what overlaps, or comes after the end, never reaches the show
                patch, waits = split_deferred(parse_patch(random_patch_text(chance), "edit"), running)
                assert waits == ()
                text = patch_json(patch)
                version = patch_version(text)
                prepared = prepare_patch(text, shows[0].hot_swap.make_show, running, shows[0].hot_swap.latest_graph)
            except PersonError:
                continue
            shows[0].hot_swap.offer_patch(prepared)
            event = PatchChanged(time=tick * TICK, source="patch", patch=compress_text(text), version=version)
            for show in shows:
                assert show.apply(event), show.refusals.last_reason
            running, patches = patch, patches + 1
        crossed = [show.tick(tick * TICK) for show in shows]
        assert crossed[0] == crossed[1]
        if crossed[0]:
            assert shows[0].state_hash() == shows[1].state_hash()
    assert patches > 10
    assert shows[0].patch_updates.applied_count > 5
    assert shows[0].patch == running or shows[0].patch_updates.waiting is not None
    assert shows[0].refusals.last_reason == shows[1].refusals.last_reason
