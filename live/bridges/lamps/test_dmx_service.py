"""Parsing of DMX universes."""

import pytest

from live.base.errors import PersonError
from live.bridges.lamps.dmx_output import Universe
from live.bridges.lamps.dmx_service import parse_universe


@pytest.mark.parametrize(
    ("text", "universe"),
    [
        ("sacn:1", Universe("sacn", 1, "", 5568)),
        ("sacn:63999@10.0.0.5", Universe("sacn", 63999, "10.0.0.5", 5568)),
        (" artnet:0@node.local:6455 ", Universe("artnet", 0, "node.local", 6455)),
    ],
)
def test_universes_are_parsed(text, universe):
    assert parse_universe(text) == universe


@pytest.mark.parametrize(
    "text", ["", "sacn", "sacn:0", "sacn:64000", "artnet:1", "artnet:32768@a", "dmx:1", "sacn:1@a:99999"]
)
def test_invalid_universes_are_refused_with_example(text):
    with pytest.raises(PersonError) as error:
        parse_universe(text)
    assert "--dmx" in str(error.value)
