"""Launch options: every option becomes a field, and every field reaches the playing process."""

import base64
import pickle
from dataclasses import fields
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from live.app.launch_options import LaunchOptions
from live.app.option_values import OPTION
from live.base.errors import PersonError
from live.bridges.camera import CameraOptions
from live.bridges.lamps import LampOptions
from live.bridges.oscquery import OscQueryOptions
from live.bridges.posistagenet import PsnOptions
from live.bridges.vmc import VmcOptions
from live.cli.play import parsed, with_launch_options
from live.control.message_codec import encode_packet

USUAL = LaunchOptions()
ALL = LaunchOptions(
    patch="samba", audio="mic", bpm=120.0, midi_file=Path("a.mid"), steps=Path("/tmp/steps"), seed=3, measures=(2, 9),
    tempo_share=0.8, osc=("0.0.0.0", 9010), osc_process=True, osc_musicians=("::", 9011),
    osc_out=(("127.0.0.1", 9000), ("localhost", 9001)), web=("127.0.0.1", 8001), web_key="k",
    web_hosts=("stage.example",), phone_camera=("0.0.0.0", 8443), gateways=4,
    gateways_listen=("0.0.0.0", 9023), audience_tls=(Path("cert.pem"), Path("key.pem")),
    audience=("0.0.0.0", 80), audience_link="http://x", audience_secret=b"\x00\xff" * 16, journal=Path("night.jsonl"),
    no_record=True, status_json=Path("s.json"),
    seconds=3.5, record=Path("film.mp4"), share=("shm:x",), operator="2", size=(640, 360),
    fps=30.0, shaders=Path("shaders"), quality=2, monitor="HDMI-1", fullscreen=True, headless=True, alone=True,
    lead="9020", standby="other", nodes="9022", node="left", service="hall",
    audio_channel="3", venue="hall", link="lead", click="out",
    click_channels="1", midi="in", midi_out="out", midi_clock_out="clock", grid="auto", bridges={
        "camera": CameraOptions(camera=("any",), camera_model="lite"),
        "lamps": LampOptions(dmx=("sacn:1",)),
        "oscquery": OscQueryOptions(oscquery=("127.0.0.1", 8000)),
        "posistagenet": PsnOptions(psn="56565"),
        "vmc": VmcOptions(vmc_out=("127.0.0.1:39539",), vmc=(("0.0.0.0", 39540),)),
    },
)  # fmt: skip


@pytest.mark.parametrize("options", [USUAL, ALL])
def test_encoded_options_decode_unchanged(options):
    assert LaunchOptions.decode(options.encode()) == options


def test_sample_options_differ_from_defaults_in_every_field():
    assert [each.name for each in fields(LaunchOptions) if getattr(ALL, each.name) == getattr(USUAL, each.name)] == []


def parse_command_line(*words):
    """The values that a command with these options receives from a command line."""
    found = {}

    @with_launch_options
    def command(**written):
        found.update(written)

    app = typer.Typer()
    app.command()(command)
    result = CliRunner().invoke(app, list(words))
    assert result.exit_code == 0, result.output
    return found


def test_empty_command_line_gives_default_options():
    values = parsed(parse_command_line())
    assert LaunchOptions(**values) == USUAL
    assert set(values) == {each.name for each in fields(LaunchOptions)} - {
        "audience_secret",
        "node",
    }  # nobody writes these


def test_each_option_sets_its_field(tmp_path):
    words = (
        "samba --audio mic --audio-channel 3 --venue hall --bpm 120 --link lead --midi in --midi-file a.mid "
        "--midi-out out --midi-clock-out clock --grid auto --click out --click-channels 1 --seconds 3.5 --measures 2-9 "
        "--tempo-share 0.8 --steps /tmp --seed 3 --osc 0.0.0.0:9010 --osc-process --osc-musicians [::]:9011 "
        "--osc-out 127.0.0.1:9000 --osc-out localhost:9001 --dmx sacn:1 --web 127.0.0.1:8001 --web-key k "
        "--web-host stage.example --phone-camera 0.0.0.0:8443 --psn 56565 --vmc-out 127.0.0.1:39539 "
        "--vmc 0.0.0.0:39540 --oscquery 127.0.0.1:8000 --audience 0.0.0.0:80 --audience-link http://x "
        "--audience-tls cert.pem,key.pem --gateways 4 --gateways-listen 0.0.0.0:9023 --monitor HDMI-1 "
        "--fullscreen --operator 2 --headless --size 640x360 --fps 30 --shaders shaders --quality 2 "
        f"--record {tmp_path}/film.mp4 --share shm:x --journal {tmp_path}/night.jsonl --status-json {tmp_path}/s.json "
        "--alone --lead 9020 --standby other --nodes 9022 --service hall --no-record --camera any --camera-model lite"
    ).split()
    values = parsed(parse_command_line(*words))
    here = {"steps": Path("/tmp"), "journal": tmp_path / "night.jsonl", "status_json": tmp_path / "s.json"}
    here |= {"record": tmp_path / "film.mp4"}
    wanted = {name: here.get(name, getattr(ALL, name)) for name in values}
    assert values == wanted


@pytest.mark.parametrize(
    ("word", "value"),
    [("bpm", 1000.0), ("seconds", float("nan")), ("fps", 0.0), ("quality", 99), ("tempo_share", 9.0), ("link", "both"),
     ("size", "big"), ("osc", "x:y"), ("vmc", ["a:b:c"]), ("measures", "9-2"), ("journal", Path("/nowhere/a/b")),
     ("audience_tls", "one.pem"), ("share", ["ftp:x"])],
)  # fmt: skip
def test_invalid_value_is_refused_with_option_name(word, value):
    with pytest.raises(PersonError, match=f"--{word.replace('_', '-')}"):
        parsed({**parse_command_line(), word: value})


def test_every_option_has_help_text():
    assert [
        each.name for each in fields(LaunchOptions) if OPTION in each.metadata and not each.metadata[OPTION].help
    ] == []


def encode_options(value):
    return base64.b64encode(encode_packet(value)).decode()


class ExecPayload:
    def __reduce__(self):
        return exec, ("raise SystemExit('called')",)


@pytest.mark.parametrize(
    "said",
    [
        "",
        "?",
        base64.b64encode(pickle.dumps(ExecPayload())).decode(),
        base64.b64encode(pickle.dumps(USUAL)).decode(),
        encode_options([]),
        encode_options({"patch": 7, "bridges": {}}),
        encode_options({"run": "x", "bridges": {}}),
        encode_options({"headless": "yes", "bridges": {}}),
        encode_options({"osc": ("127.0.0.1", "9010"), "bridges": {}}),
        encode_options({"headless": True}),
        encode_options({"bridges": {"os": {"system": "x"}}}),
        encode_options({"bridges": {"lamps": {"dmx": "sacn:1"}}}),
    ],
)
def test_forged_option_text_is_refused(said):
    with pytest.raises(ValueError):  # noqa: PT011
        LaunchOptions.decode(said)


def test_keys_of_the_machine_that_led_replace_the_own_ones():
    there = LaunchOptions(web_key="of the leader", audience_secret=b"\x01" * 16)
    here = LaunchOptions(web=("127.0.0.1", 8010), web_key="own", audience_secret=b"\x02" * 16, lead="9020")
    both = here.with_keys(there.keys)
    assert (both.web_key, both.audience_secret, both.lead) == ("of the leader", b"\x01" * 16, "9020")
    assert here.with_keys(LaunchOptions().keys) == here  # a leader without a page and without phones
    for keys in ({}, {"web_key": "k"}, {**there.keys, "seed": "4"}, {**there.keys, "audience_secret": "no digits"},
                 {**there.keys, "web_key": "k" * 129}):  # fmt: skip
        with pytest.raises(ValueError, match=r"keys of a show|hexadecimal"):
            here.with_keys(keys)


def test_no_record_refuses_what_would_record(tmp_path: Path) -> None:
    LaunchOptions(no_record=True).check_privacy()
    LaunchOptions(journal=tmp_path / "a.jsonl").check_privacy()
    with pytest.raises(PersonError, match=r"--journal .* --no-record keeps nothing"):
        LaunchOptions(no_record=True, journal=tmp_path / "a.jsonl").check_privacy()
    with pytest.raises(PersonError, match="--record"):
        LaunchOptions(no_record=True, record=tmp_path / "a.mp4").check_privacy()
