"""Colours of a patch in words, as #rrggbb and as numbers; several faults at once; keys that are nearly right."""

import colorsys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from live.base.errors import PersonError
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_schema import patch_schema
from live.show.patch.section_base import colour_value
from tests.cli.command import run_live

PATCH = """name = "test"
[look]
rim_light = {look}
[[group]]
name = "front"
dancers = 2
steps = ["sway"]
colour = {group}
"""


def colours(group, look="[0, 0, 0]"):
    """Colours of the group and of the light from behind, as the show has them."""
    patch = parse_patch(PATCH.format(group=group, look=look), "test.toml")
    return patch.group[0].colour, patch.look.rim_light


@pytest.mark.parametrize(
    ("written", "linear"),
    [
        ('"red"', (1.0, 0.0, 0.0)),
        ('"White"', (1.0, 1.0, 1.0)),
        ('"#f00"', (1.0, 0.0, 0.0)),
        ('"#808080"', (0.2159, 0.2159, 0.2159)),  # half of the screen's scale is a fifth of the light
        ('"hsl(120, 100%, 50%)"', (0.0, 1.0, 0.0)),
        ("[0.25, 0.5, 1]", (0.25, 0.5, 1.0)),
    ],
)
def test_colours_are_words_hex_or_linear_numbers(written, linear):
    group, look = colours(written, written)
    assert group == look == pytest.approx(linear, abs=1e-4)


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_hex_is_srgb(levels):
    """Against the standard's curve, in the other direction: linear light to the screen's levels."""
    linear = np.array(colour_value("#{:02x}{:02x}{:02x}".format(*levels)))
    screen = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    np.testing.assert_allclose(255.0 * screen, levels, atol=0.25)
    assert colorsys.rgb_to_hsv(*linear)[2] == max(linear)


@pytest.mark.parametrize(
    ("written", "words"),
    [
        ('"rde"', "line 8: group.1.colour: did you mean 'red'? a colour expected"),
        ('"#ff80"', ""),
        ('"#xyz"', "a colour expected: a word of the web such as 'gold', '#f80', or"),
        ("[1, 0]", "line 8: group.1.colour"),
        ("[2, 0, 0]", "less than or equal to 1"),
        ("7", "a list expected, found 7"),
    ],
)
def test_what_is_no_colour_is_refused_with_what_is(written, words):
    if not words:
        assert colours(written)[0] == pytest.approx((1.0, 1.0, 0.2462), abs=1e-3)  # alpha is left out
        return
    with pytest.raises(PersonError, match=words.replace("?", r"\?").replace("[", r"\[")):
        colours(written)


def test_schema_allows_both_forms():
    schema = patch_schema()
    colour = schema["definitions"]["GroupSection"]["properties"]["colour"]
    kinds = [one["type"] for one in colour["anyOf"]]
    assert kinds == ["array", "string"]
    assert colour["anyOf"][0]["items"][2] == {"type": "number", "minimum": 0, "maximum": 1}


def test_terminal_lists_every_fault_on_a_line_of_its_own(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text('name = "Bad"\nbmp = 120\n[[group]]\nname = "a"\ndancers = 0\nstpes = ["sway"]\ncolour = "rde"\n')
    done = run_live("check", str(path))
    assert done.returncode == 2
    first, *faults = done.stderr.strip().splitlines()
    assert first == "error: several things are wrong"
    assert len(faults) >= 4
    assert all(fault.startswith(f"  - {path}, line ") for fault in faults)
    told = "\n".join(faults)
    assert "did you mean bpm in [music] or bpm in [clock] or map in [midi]?" in told
    assert "group.1.stpes: unknown key; did you mean 'steps'?" in told
    one = tmp_path / "one.toml"
    one.write_text('name = "One"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["sway"]\ncolour = "rde"\n')
    assert run_live("check", str(one)).stderr.startswith(f"error: {one}, line 6: group.1.colour: did you mean 'red'?")
