"""The service for DMX: universes of the command line, channels and values for the process that sends."""

import socket
import struct
from types import SimpleNamespace

import pytest

from live.base.errors import PersonError
from live.bridges.lamps.dmx_output import Universe
from live.bridges.lamps.dmx_section import DmxTables
from live.bridges.lamps.dmx_service import DmxService, parse_universe
from live.clock.time_source import SystemClock
from live.control.registry.registry import REGISTRY
from live.show.assembly import assemble
from live.show.patch.patch_reader import parse_patch
from tests.control.waiting import wait_for
from tests.show.made_show import GRAPH, PATCH


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


LEVEL, KEY = REGISTRY["/dance/light/level"], REGISTRY["/dance/light/key"]


def test_channels_are_those_of_the_patch_also_after_an_edit():
    def read(text):
        return parse_patch(PATCH + text, "test.toml", [DmxTables])

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(20.0)
        show = assemble(read('[[dmx]]\nchannel = 5\nsends = "/dance/light/level"\n'), GRAPH)
        engine = SimpleNamespace(show=show, view=show.view())
        service = DmxService(engine, (Universe("artnet", 0, "127.0.0.1", receiver.getsockname()[1]),), SystemClock())
        service.start()
        try:
            service.publish({control.address: (("", (control.arguments[0].maximum,)),) for control in (LEVEL, KEY)})

            def lit():
                service.frame()
                data = receiver.recv(2000)
                assert struct.unpack_from(">H", data, 16) == (512,)
                return [number for number, value in enumerate(data[18:], start=1) if value]

            assert wait_for(lambda: lit() == [5], 20.0)
            service.update_patch(read('[[dmx]]\nchannel = 9\nsends = "/dance/light/key"\n'))
            assert wait_for(lambda: lit() == [9], 20.0)
        finally:
            service.stop()


@pytest.mark.parametrize(
    ("row", "line", "words"),
    [
        ('channel = 1\nsends = "bees"', 0, r"dmx\.1: nothing is called 'bees': beat, measure, .*address of a number"),
        ('channel = 512\nsends = "dancer"', 0, r"dmx\.1: it takes 4 channels from 512 on, and there are 512"),
        ('channel = 0\nsends = "beat"', 1, r"dmx\.1\.channel: input should be greater than or equal to 1, found 0"),
        ('chanel = 1\nsends = "beat"', 1, r"dmx\.1\.chanel: unknown key; did you mean 'channel'"),
    ],
)
def test_wrong_rows_are_refused_with_line_and_field(row, line, words):
    line += PATCH.count("\n") + 1
    with pytest.raises(PersonError, match=rf"test\.toml, line {line}: {words}"):
        parse_patch(f"{PATCH}[[dmx]]\n{row}\n", "test.toml", [DmxTables])
