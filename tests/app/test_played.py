"""What is to be played, on its way from the command line to its process: every field of a wish, and nothing else."""

import base64
import pickle
from dataclasses import fields
from pathlib import Path

import pytest

from live.app.launch_options import Played, Wish
from live.control.message_codec import packet_of

WISH = Wish(
    patch="samba", audio="mic", bpm=120.0, midi_file=Path("a.mid"), steps=Path("/tmp/steps"), seed=3, measures=(2, 9),
    tempo_share=0.8, osc=("0.0.0.0", 9010), osc_process=True, osc_musicians=("::", 9011),
    osc_out=(("127.0.0.1", 9000), ("localhost", 9001)), dmx=("sacn:1",), vmc_out=("127.0.0.1:39539",),
    vmc=(("0.0.0.0", 39540),), oscquery=("127.0.0.1", 8000), web=("127.0.0.1", 8001), web_key="k",
    web_hosts=("stage.example",), audience_tls=(Path("cert.pem"), Path("key.pem")),
    audience=("0.0.0.0", 80), audience_link="http://x", audience_secret=b"\x00\xff" * 16, journal=Path("night.jsonl"),
    status_json=Path("s.json"), seconds=3.5, record=Path("film.mp4"), share=("shm:x",), operator="2", size=(640, 360),
    fps=30.0, shaders=Path("shaders"), quality=2,
)  # fmt: skip


@pytest.mark.parametrize("played", [Played(Wish()), Played(WISH, "HDMI-1", True, False), Played(WISH, headless=True)])
def test_it_comes_as_it_was_sent(played):
    assert Played.unpacked(played.packed()) == played


def test_every_field_of_a_wish_was_tried():
    usual = Wish()
    same = {each.name for each in fields(Wish) if getattr(WISH, each.name) == getattr(usual, each.name)}
    assert same <= {
        "audio_channel",
        "venue",
        "link",
        "click",
        "click_channels",
        "midi",
        "midi_out",
        "midi_clock_out",
        "psn",
    }


def word(value):
    return base64.b64encode(packet_of(value)).decode()


class Calls:
    def __reduce__(self):
        return exec, ("raise SystemExit('called')",)


@pytest.mark.parametrize(
    "said",
    [
        "",
        "?",
        base64.b64encode(pickle.dumps(Calls())).decode(),
        base64.b64encode(pickle.dumps(Played(Wish()))).decode(),
        word([]),
        word({}),
        word({"wish": {"patch": 7}}),
        word({"wish": {"run": "x"}}),
        word({"wish": {}, "headless": "yes"}),
        word({"wish": {"osc": ("127.0.0.1", "9010")}}),
    ],
)
def test_a_word_that_somebody_made_up_is_refused(said):
    with pytest.raises(ValueError):  # noqa: PT011
        Played.unpacked(said)
