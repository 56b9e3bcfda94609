"""A show on a warped projector beside the operator's window: cards by OSC, warping by keys, saved venue file."""

import subprocess
import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.end_to_end.test_window_show import _needs, _osc, _second_monitor, _wait_until
from tests.fixtures.two_monitor_x import FIRST, TwoMonitorX

VENUE = """# our hall
name = "hall"
operator = "primary"
[[output]]
name = "gallery"        # by hand
monitor = "right of primary"
corners = [[0.1, 0.1], [0.95, 0.0], [0.9, 1.0], [0.0, 0.9]]
"""


@pytest.mark.long
@pytest.mark.x11
@pytest.mark.liblo
def test_projector_is_set_up_during_show(play, patch: Path, tmp_path: Path, two_monitor_x: TwoMonitorX):
    _needs("oscsend", "xdotool")
    two_monitor_x.plug_both()
    (tmp_path / "venues").mkdir()
    file = tmp_path / "venues" / "hall.toml"
    file.write_text(VENUE)
    env = {"DISPLAY": two_monitor_x.display, "LIVE_CONFIG_DIR": str(tmp_path)}
    port = 19027
    running = play(
        str(patch), "--bpm", "150", "--venue", "hall", "--fullscreen", "--alone", "--osc", f"127.0.0.1:{port}",
        "--size", "320x180", env=env,
    )  # fmt: skip
    line = running.wait_for(lambda line: line["frames"] > 10, 60)
    assert line["outputs"] == [
        {"name": "gallery", "monitor": "DUMMY1", "size": [800, 600], "there": True, "card": "off", "edited": False}
    ]
    assert not _second_monitor(two_monitor_x)[:40, :60].any()  # beside the bent picture nothing is thrown
    own = two_monitor_x.screenshot()[: FIRST[1], : FIRST[0]]
    assert own[100:260, 180:460].max() > 40  # the operator sees the picture, too
    assert not own[:60].any()

    _osc(port, "/dance/output/card", "ss", "gallery", "grid")
    running.wait_for(lambda line: line["outputs"][0]["card"] == "grid", 20)
    _wait_until(lambda: (_second_monitor(two_monitor_x).min(axis=2) > 200).sum() > 1000, 20, running, "the card")
    _osc(port, "/dance/output/card", "ss", "cellar", "grid")
    running.wait_for(lambda line: line["events_rejected"].get("not in this show") == 1, 20)

    two_monitor_x.run("xdotool", "mousemove", "900", "300", "key", "F9", "key", "shift+Left", "key", "Up")
    running.wait_for(lambda line: line["outputs"][0]["edited"], 20)
    two_monitor_x.run("xdotool", "key", "F9")
    _wait_until(lambda: file.read_text() != VENUE, 20, running, "what was bent")
    (kept,) = tomllib.loads(file.read_text())["output"]
    np.testing.assert_allclose(kept["corners"][0], [0.1 - 10 / 800, 0.1 - 1 / 600], atol=1e-5)
    assert "# by hand" in file.read_text()
    subprocess.run(["xdotool", "key", "F7", "key", "b"], env={**env, "PATH": "/usr/bin:/bin"}, check=True)
    running.wait_for(lambda line: line["master"]["frozen"], 20)
    line = running.wait_for(lambda line: line["frames"] > line["late_frames"] or line["frames"] > 0, 20)
    assert line["faults"] == 0
    assert "Traceback" not in running.stop()


@pytest.mark.long
@pytest.mark.x11
def test_venue_with_missing_monitor_is_refused_before_show(
    play, patch: Path, tmp_path: Path, two_monitor_x: TwoMonitorX
):
    two_monitor_x.plug_both()
    (tmp_path / "venues").mkdir()
    (tmp_path / "venues" / "hall.toml").write_text(VENUE.replace('"right of primary"', '"HDMI-7"'))
    env = {"DISPLAY": two_monitor_x.display, "LIVE_CONFIG_DIR": str(tmp_path)}
    running = play(str(patch), "--bpm", "150", "--venue", "hall", "--alone", env=env)
    output, _ = running.process.communicate(timeout=240)
    assert running.process.returncode == 2
    assert "venue hall: output.1.monitor: 'HDMI-7' is not a monitor" in " ".join(output.split())
    assert "DUMMY1" in output
    assert "Traceback" not in output
