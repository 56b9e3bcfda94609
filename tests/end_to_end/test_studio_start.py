"""`live studio` without a show: a page on which one is begun, which then is that show's studio."""

import os
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from live.show.patch.patch_search_path import PATCHES
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser

pytestmark = [needs_browser, pytest.mark.browser, pytest.mark.long]
KEY = "a-key-of-the-tests-4711"


def free_ports(count: int) -> list[int]:
    opened = [socket.create_server(("127.0.0.1", 0)) for _ in range(count)]
    ports = [one.getsockname()[1] for one in opened]
    for one in opened:
        one.close()
    return ports


def test_a_show_is_begun_from_a_song_on_the_page(tmp_path: Path) -> None:
    (tmp_path / "settings").mkdir()
    key = tmp_path / "settings" / "web-key"
    key.write_text(KEY)
    key.chmod(0o600)
    shutil.copy(PATCHES / "music" / "first_show.ogg", tmp_path / "song.ogg")
    web, osc = free_ports(2)
    command = [sys.executable, "-m", "live", "studio", "--no-browser", "--web", str(web), "--osc", str(osc)]
    environment = {**os.environ, "LIVE_CONFIG_DIR": str(tmp_path / "settings")}
    process = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stderr is not None
        line = process.stderr.readline()
        assert f"http://127.0.0.1:{web}/studio#key=" in line
        with browser() as (opened, _):
            page = opened.new_context().new_page()
            page.set_default_timeout(60_000 * BUSY)
            errors: list[str] = []
            page.on("pageerror", lambda error: errors.append(str(error)))
            for _ in range(600):  # it listens a moment after it has told so
                try:
                    page.goto(line.split()[-1])
                    break
                except Exception:
                    page.wait_for_timeout(50)
            page.get_by_role("heading", name="A new show").wait_for()
            page.get_by_label("Name").fill("no/way")
            page.get_by_role("button", name="Begin").click()
            page.get_by_role("alert").wait_for()
            page.get_by_label("Name").fill("my piece")
            page.get_by_label("Dancers").fill("5")
            page.get_by_role("button", name="Begin").click()
            page.get_by_role("region", name="Timeline").wait_for()
            page.get_by_role("heading", name="My piece").wait_for()
            assert not errors
        assert 'file = "song.ogg"' in (tmp_path / "my piece" / "show.toml").read_text()
        assert (tmp_path / "my piece" / "song.ogg").is_file()
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60 * BUSY)
