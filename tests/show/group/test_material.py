"""Formations and evolutions of a patch that are like others: loaded, refused, danced, edited."""

import numpy as np
import pytest

from live.agents.material.room import room_of
from live.base.errors import PersonError
from live.document.preview import first_change
from live.show.loader import load_show
from live.show.patch.patch_reader import read_patch

HALL = "[[-4, -3], [4, -3], [4, 0], [0, 0], [0, 3], [-4, 3]]"
PATCH = """
name = "material"
[clock]
bpm = 120
[[group]]
name = "ember"
dancers = 6
steps = ["groove"]
travel_step = "walk"
[[formation]]
name = "ring"
shape = "circle"
size = [5, 5]
[[formation]]
name = "in the hall"
like = "ring"
into = HALL
[[evolution]]
name = "flock"
ways = [[[-4, -1], [0, -2], [3, -1]], [[-4, 0], [3, 0]], [[-4, 1], [0, 2], [3, 1]], [[-2, 2]], [[-2, -3], [1, -3]],
  [[-5, -2], [-5, 2]]]
[[evolution]]
name = "flock in the hall"
like = "flock"
into = HALL
[[segment]]
measure = 2
measures = 2
formation = "in the hall"
[[segment]]
measure = 4
measures = 4
evolution = "Flock in the hall"
match = "number"
""".replace("HALL", HALL)


@pytest.fixture
def patch_file(tmp_path):
    def write(text=PATCH):
        path = tmp_path / "show.toml"
        path.write_text(text)
        return path

    return write


@pytest.mark.long
def test_a_show_dances_them_at_its_measures(patch_file):
    show, tick = load_show(patch_file()).start(), 0
    room = room_of((((-4.0, -3.0), (4.0, -3.0), (4.0, 0.0), (0.0, 0.0), (0.0, 3.0), (-4.0, 3.0)),))
    seen = {}
    while show.span.number < 7:
        tick += 1
        show.tick(tick / 64)
        end = {2: 3, 6: 7}.get(show.span.number)
        if end is not None and end not in seen:  # the end of each segment, while it is danced
            under, wanted, _ = show.motion.evolutions.target(end * 4.0 - 1e-6)
            assert under[:6].all()
            seen[end] = wanted[:6].copy()
            assert room.contains(seen[end].astype(np.float64), 0.05).all()
    ways = show.motion.evolutions.ways("flock in the hall")
    assert seen[7] == pytest.approx(ways[:, -1], abs=0.05)


@pytest.mark.parametrize(("old", "new", "words"), [
    (
        f'like = "ring"\ninto = {HALL}', 'like = "ring"\ninto = [[0, 0], [1.3, 0], [1.3, 1.3], [0, 1.3]]',
        "room for 4 of 6 dancers",
    ),
    ('evolution = "Flock in', 'evolution = "Fleet in', "no evolution is called 'Fleet in the hall'.*flock"),
    ('like = "flock"', 'like = "flock in the hall"', "leads back to itself"),
    ('like = "flock"', 'like = "flock"\nbend_deg = 200', "would fold"),
    ('like = "flock"', 'like = "flock"\nscale = 0', "scale"),
    ('like = "flock"', "", "either ways, or like"),
    ('like = "ring"', 'like = "rung"', "unknown formation 'rung'"),
    ('match = "number"', 'path = [[0, 0], [1, 1]]', "path and evolution: leave one out"),
    ('formation = "in', 'backwards = true\nformation = "in', "backwards needs an evolution"),
    ('name = "flock in the hall"', 'name = "flock"', "two evolutions are called"),
], ids=str)  # fmt: skip
def test_unusable_ones_are_refused_when_a_show_is_loaded(patch_file, old, new, words):
    with pytest.raises(PersonError, match=words):
        load_show(patch_file(PATCH.replace(old, new))).start()


def test_an_edit_of_what_others_are_like_is_danced_from_their_first_measure(patch_file):
    before = read_patch(patch_file())
    ring = read_patch(patch_file(PATCH.replace("size = [5, 5]", "size = [4, 4]")))
    assert first_change(before, ring) == 2
    flock = read_patch(patch_file(PATCH.replace("[[-2, 2]]", "[[-1, 2]]")))
    assert first_change(before, flock) == 4
