"""Who wears what, and patterns that the kernels can run."""

import numpy as np
import pytest

from live.base.body.appearance import COSTUMES, EXTRAS, FABRICS, HAIRS
from live.motion.cloth.cloth_kernels import RUN_COUNT, RUN_FIRST, RUN_SECOND
from live.motion.cloth.fabric import FABRICS as KNOWN
from live.motion.cloth.fabric import fabric_of
from live.motion.cloth.garment_catalogue import PATTERNS, SKIRT_LENGTHS, garments_of
from live.motion.cloth.pattern import compile_pattern
from live.render.body.body_limbs import body_sections


def test_costume_hair_and_extras_give_garments():
    assert garments_of("leotard", "bun", "none") == ()
    assert garments_of("dress", "long", "none") == ("skirt", "long hair")
    assert garments_of("skirt", "ponytail", "ribbons", skirt=0.0) == (
        "short skirt", "ponytail", "left ribbon", "right ribbon",
    )  # fmt: skip
    assert garments_of("skirt", "bun", "none", skirt=1.0) == ("long skirt",)


def test_every_name_of_an_appearance_is_known():
    worn = {
        name
        for costume in COSTUMES
        for hair in HAIRS
        for extra in EXTRAS
        for length, _ in SKIRT_LENGTHS
        for name in garments_of(costume, hair, extra, skirt=length)
    }
    assert worn == set(PATTERNS)
    assert set(FABRICS) == set(KNOWN)


@pytest.mark.parametrize("name", PATTERNS)
def test_no_particle_is_in_a_run_twice_and_none_on_the_body_moves(name):
    one = compile_pattern(PATTERNS[name], fabric_of(PATTERNS[name].kind, "silk"))
    pinned = one.pattern.pinned_rows * one.pattern.columns
    for runs, amounts in ((one.runs, one.amounts), (one.limit_runs, one.limits), (one.last_runs, one.last_limits)):
        for run, amount in zip(runs, amounts, strict=True):
            first = range(run[RUN_FIRST], run[RUN_FIRST] + run[RUN_COUNT])
            second = range(run[RUN_SECOND], run[RUN_SECOND] + run[RUN_COUNT])
            assert not {*first} & {*second}
            assert max(*first, *second) < one.pattern.count
            assert amount[2] == 0.0 or min(first) >= pinned
            assert amount[3] == 0.0 or min(second) >= pinned


@pytest.mark.parametrize("body", ["dancer", "slim", "strong", "round", "child"])
@pytest.mark.parametrize("name", PATTERNS)
def test_rest_shape_has_the_lengths_of_the_pattern(name, body):
    """As it hangs where nothing is simulated, columns are about as long as the cloth."""
    pattern = PATTERNS[name]
    places = pattern.rest_shape(body_sections(body))
    down = np.linalg.norm(np.diff(places, axis=0), axis=-1)
    assert places.shape == (pattern.rows, pattern.columns, 3)
    assert down.max() < 1.6 * pattern.spacing
    assert down.mean() < 1.1 * pattern.spacing
    assert sorted(pattern.order().ravel().tolist()) == list(range(pattern.count))
