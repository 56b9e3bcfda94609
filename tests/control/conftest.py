"""Fixtures: an OSC input with a sender, and a private PulseAudio with a null sink whose monitor is recorded."""

import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.control.osc.osc_stage import Stage

NEEDED = ("pulseaudio", "pactl", "paplay")


@dataclass
class PulseSink:
    """The running server, its environment, and players into it."""

    env: dict[str, str]
    server: subprocess.Popen[bytes]
    command: list[str]
    players: list[subprocess.Popen[bytes]]

    def play(self, wav_path: Path) -> subprocess.Popen[bytes]:
        """Starts to play a file into the sink."""
        player = subprocess.Popen(["paplay", str(wav_path)], env=self.env)
        self.players.append(player)
        return player

    def wait_until_up(self, seconds: float = 10.0) -> None:
        deadline = time.monotonic() + seconds
        while subprocess.run(["pactl", "info"], env=self.env, capture_output=True).returncode != 0:
            if self.server.poll() is not None or time.monotonic() > deadline:
                raise RuntimeError("PulseAudio does not start")
            time.sleep(0.05)

    def restart(self, *, rate: int = 48_000, channels: int = 2) -> None:
        """Restarts the server after a kill, optionally with another sound card format."""
        card = f"rate={rate} channels={channels}"
        command = [part.replace("rate=48000 channels=2", card) for part in self.command]
        self.server = subprocess.Popen(command, env=self.env)
        self.wait_until_up()
        self.make_default()

    def make_default(self) -> None:
        for kind, name in (("sink", "stage"), ("source", "stage.monitor")):
            subprocess.run(["pactl", f"set-default-{kind}", name], env=self.env, check=True)

    def kill(self) -> None:
        """Kills the server without a clean shutdown."""
        self.server.kill()
        self.server.wait()

    def stop_players(self) -> None:
        for player in self.players:
            if player.poll() is None:
                player.kill()
            player.wait()
        self.players.clear()


@pytest.fixture
def stage() -> Iterator[Stage]:
    """An OSC input on a free port with a socket to send from."""
    with Stage() as running:
        yield running


@pytest.fixture(scope="module")
def pulse_sink() -> Iterator[PulseSink]:
    """A PulseSink on which the device "pulse" plays and listens; skipped where PulseAudio or PortAudio is missing."""
    missing = [name for name in NEEDED if shutil.which(name) is None]
    if missing:
        pytest.skip(f"{', '.join(missing)} not installed (apt install pulseaudio pulseaudio-utils)")
    from live.control.audio.devices import SoundUnavailable, list_input_devices, refresh

    try:
        list_input_devices()
    except SoundUnavailable as error:
        pytest.skip(str(error))
    with tempfile.TemporaryDirectory(prefix="live-pulse-") as folder:
        ours = {
            "XDG_RUNTIME_DIR": folder,
            "PULSE_RUNTIME_PATH": f"{folder}/pulse",
            "PULSE_STATE_PATH": f"{folder}/state",
            "PULSE_COOKIE": f"{folder}/cookie",
            "PULSE_SERVER": f"unix:{folder}/pulse/native",
        }
        for name in ("pulse", "state"):
            Path(folder, name).mkdir(mode=0o700)
        command = [
            *("pulseaudio", "-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no", "--disable-shm=no"),
            *("--realtime=no", "--high-priority=no", f"--log-target=file:{folder}/log"),
            *("-L", "module-native-protocol-unix auth-anonymous=1"),
            *("-L", "module-null-sink sink_name=stage rate=48000 channels=2"),
            *("-L", "module-always-sink"),
        ]
        before = dict(os.environ)
        os.environ.update(ours)
        env = dict(os.environ)
        sink = PulseSink(env, subprocess.Popen(command, env=env), command, [])
        try:
            sink.wait_until_up()
            sink.make_default()
            refresh()
            if not any(device.name == "pulse" for device in list_input_devices()):
                pytest.skip("PortAudio does not know PulseAudio (apt install libasound2-plugins)")
            yield sink
        finally:
            sink.stop_players()
            sink.kill()
            os.environ.clear()
            os.environ.update(before)
            refresh()
