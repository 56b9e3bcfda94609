"""Motion capture over the network in a live show: addresses, errors, and a recording sent as live data."""

import socket
from types import SimpleNamespace

import numpy as np
import pytest

from live.app.bridges import ServiceContext
from live.base.errors import PersonError
from live.base.event_queue import EventQueue
from live.bridges.vmc import VmcOptions, services
from live.bridges.vmc.test_vmc_input import poses, stream
from live.bridges.vmc.vmc_output import play_clip
from live.clock.time_source import ManualClock
from live.motion.capture.packed_pose import unpack_pose
from live.motion.clip import Clip
from live.show.patch.patch_reader import parse_patch
from live.show.venue.venue import Venue
from tests.cli.command import run_live
from tests.show.made_show import PATCH, made_show

VENUE = Venue.model_validate({"vmc": {"at": ["0"]}})


def make_services(options, show=None, venue=None):
    """The services of these launch options."""
    context = ServiceContext(
        options=options, engine=SimpleNamespace(show=show or made_show()), venue=venue, clock=ManualClock(),
        add_queue=EventQueue().add_queue, osc=("127.0.0.1", 9010), host_names=(), resumes=False,
    )  # fmt: skip
    return services(context)


def test_receiver_listens_on_addresses_of_command_line_or_venue():
    show = made_show('[[mocap]]\nname = "anna"\nport = 39541\n')
    assert make_services(VmcOptions(), show) == {}
    part = make_services(VmcOptions(), show, VENUE)["vmc"]
    part.start()
    part.frame()
    assert part.refused().total() == 0
    assert part.status()["received"] == 0
    part.stop()
    part.stop()
    part = make_services(VmcOptions(vmc=(("127.0.0.1", 0),)), show, VENUE)["vmc"]
    part.update_patch(parse_patch(PATCH + '[[mocap]]\nname = "ben"\n', "test.toml"))
    assert part.status()["at"] == ["127.0.0.1:0"]


def test_busy_port_is_reported_in_one_line():
    with socket.socket(type=socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        part = make_services(VmcOptions(vmc=(("127.0.0.1", taken.getsockname()[1]),)))["vmc"]
        with pytest.raises(PersonError, match=r"VMC cannot listen.*--vmc"):
            part.start()


def test_recording_is_sent_in_time_and_received_unchanged():
    hips, rotation = poses(6)
    clip = Clip("walk", hips.astype(np.float32), rotation.astype(np.float32), 240.0, np.ones((6, 2), np.bool_))
    with socket.socket(type=socket.SOCK_DGRAM) as ear:
        ear.bind(("127.0.0.1", 0))
        ear.settimeout(10.0)
        where = ear.getsockname()
        assert play_clip(clip, where, first=2) == 4
        assert play_clip(clip, where, seconds=0.05, loop=True) == 12
        hearing, given, tally = stream()
        for number in range(2 * (4 + 12)):
            hearing.handle(ear.recv(4096), 1.0 + number)
    assert tally.total == 0
    assert len(given) >= 8
    root, turned = unpack_pose(given[0].pose)
    np.testing.assert_allclose(root[::2], hips[2, ::2], atol=1e-4)
    assert np.abs(np.sum(turned * rotation[2], axis=-1)).min() > 1.0 - 1e-6


def test_invalid_send_options_are_refused(tmp_path):
    for words, said in (
        (["no.bvh"], "no such file"),
        (["no.bvh", "--to", "nowhere"], "--to"),
        (["no.bvh", "--rate", "0"], "--rate"),
    ):
        outcome = run_live("mocap", "send", *words, cwd=tmp_path)
        assert outcome.returncode == 2
        assert said in outcome.stderr
