"""A real window on the second of two X monitors: OSC from liblo's oscsend moves the dancers in the picture."""

import shutil
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

from tests.end_to_end.conftest import Running
from tests.fixtures.two_monitor_x import FIRST, SECOND, TwoMonitorX


def _needs(*programs: str) -> None:
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed (apt install liblo-tools xdotool)")


def _second_monitor(server: TwoMonitorX) -> np.ndarray:
    """The picture of the second monitor, (height, width, 3)."""
    return server.screenshot()[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]].astype(int)


def _dancers_at(picture: np.ndarray) -> float:
    """Position of the blue dancers across the picture: the mean column [share of the width] of strongly blue pixels."""
    blue = (picture[..., 2] > 70) & (picture[..., 2] > 1.7 * picture[..., 0])
    assert blue.sum() > 500, "no blue dancers in the picture"
    return float(np.nonzero(blue)[1].mean() / SECOND[0])


def _osc(port: int, *message: str) -> None:
    subprocess.run(["oscsend", "127.0.0.1", str(port), *message], check=True)


def _wait_until(condition, seconds: float, running: Running, what: str) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert running.process.poll() is None, running.stop()
        assert time.monotonic() < deadline, f"{what} not within {seconds} s: {running.lines()[-1:]}"
        time.sleep(0.1)  # a look costs more than a frame of the show


@pytest.mark.x11
@pytest.mark.liblo
def test_osc_moves_dancers_on_second_monitor(play, patch: Path, two_monitor_x: TwoMonitorX):
    _needs("oscsend", "xdotool")
    two_monitor_x.plug_both()
    port = 19017
    env = {"DISPLAY": two_monitor_x.display}
    running = play(
        str(patch), "--bpm", "150", "--monitor", "2", "--fullscreen", "--alone", "--osc", f"127.0.0.1:{port}", env=env
    )  # fmt: skip
    running.wait_for(lambda line: line["frames"] > 20, 60)
    before = _dancers_at(_second_monitor(two_monitor_x))
    assert before < 0.48

    _osc(port, "/dance/attract", "ffff", "4.0", "0.0", "1.0", "60.0")
    _wait_until(lambda: _dancers_at(_second_monitor(two_monitor_x)) > before + 0.1, 60, running, "gathering")

    _osc(port, "/dance/blackout", "i", "1")
    _wait_until(lambda: _second_monitor(two_monitor_x).max() < 12, 20, running, "blackout")
    subprocess.run(["xdotool", "key", "b"], env=env, check=True)
    _wait_until(lambda: _second_monitor(two_monitor_x).max() > 60, 20, running, "light")
    subprocess.run(["xdotool", "key", "Escape"], env=env, check=True)
    _osc(port, "/dance/attract", "ff", "nan", "0")

    line = running.wait_for(lambda line: line["events_rejected"].get("not a finite number") == 1, 20)
    assert line["events_accepted"] >= 3
    assert line["faults"] == 0
    assert running.process.poll() is None  # Esc never ends a show in full screen
    assert "Traceback" not in running.stop()
