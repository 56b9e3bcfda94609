"""The studio without a show: a page on which one is begun, which then is that show's studio; and the page of
`live couple label`, on which a person labels patterns by keys and finds them in the file."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from live.library.pattern_labels import LabelledPattern, read_labels
from live.motion.formats.bvh_writer import write_bvh
from live.show.patch.patch_search_path import PATCHES
from tests.control.waiting import BUSY
from tests.end_to_end.browser import browser, needs_browser
from tests.motion.partner.test_answer import random_dance_clip

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


def test_patterns_are_labelled_by_keys(tmp_path: Path) -> None:
    lines = []
    for name in ("a", "b"):
        for side, seed in (("leader", 61), ("follower", 62)):
            (tmp_path / f"{name}_{side}.bvh").write_text(write_bvh(random_dance_clip(seed, 900), rate=30.0))
        lines.append(
            f'[[pair]]\nleader = {{ file = "{name}_leader.bvh", bpm = 164, first_beat_s = 0.3 }}\n'
            f'follower = {{ file = "{name}_follower.bvh" }}\n'
        )
    (tmp_path / "pairs.toml").write_text("\n".join(lines))
    (tmp_path / "settings").mkdir()
    key = tmp_path / "settings" / "web-key"
    key.write_text(KEY)
    key.chmod(0o600)
    (port,) = free_ports(1)
    command = [sys.executable, "-m", "live", "couple", "label", "pairs.toml", "--no-browser", "--web", str(port)]
    environment = {
        **os.environ, "LIVE_CONFIG_DIR": str(tmp_path / "settings"), "PYTHONPATH": os.pathsep.join(sys.path),
    }  # fmt: skip
    process = subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stderr is not None
        link = process.stderr.readline().split()[-1]
        with browser() as (opened, _):
            page = opened.new_context().new_page()
            page.set_default_timeout(60_000 * BUSY)
            errors: list[str] = []
            page.on("pageerror", lambda error: errors.append(str(error)))
            for _ in range(600):  # it listens a moment after it has told so
                try:
                    page.goto(link)
                    break
                except Exception:
                    page.wait_for_timeout(50)
            page.get_by_role("heading", name="Patterns of pairs.toml").wait_for()
            page.locator(".view canvas").wait_for()
            for word in ("ArrowRight", "1", "ArrowRight", "2", "ArrowRight", "3", "Control+z", "4"):
                page.keyboard.press(word)
            page.keyboard.press("ArrowDown")
            page.get_by_label("New label").fill("dip")
            page.get_by_role("button", name="Add").click()
            page.get_by_role("heading", name="Label of this pattern").click()  # out of the field
            page.locator("aside h2").evaluate("() => document.activeElement.blur()")
            page.keyboard.press("ArrowRight")
            page.keyboard.press("5")
            page.get_by_text("4 of 10 patterns have a label – saved").wait_for()
            taken = labels_of(tmp_path)
            assert [(one.take, one.label) for one in taken] == [
                ("a_follower", "basic"), ("a_follower", "inside turn"), ("a_follower", "cross-body lead"),
                ("b_follower", "dip"),
            ]  # fmt: skip
            page.keyboard.press("?")  # b is the double of a, which has labels
            page.get_by_role("button", name="inside turn?").wait_for()
            page.keyboard.press(" ")
            page.locator(".now span", has_text=re.compile(r"^[1-9]")).wait_for()
            page.keyboard.press(" ")
            page.keyboard.press("]")
            for _ in range(600):  # it is written a moment later
                (moved,) = [one for one in labels_of(tmp_path) if one.take == "b_follower"]
                if moved.from_s != taken[3].from_s:
                    break
                page.wait_for_timeout(50)
            assert moved.from_s - taken[3].from_s == pytest.approx(60.0 / 164.0, abs=0.01)
            assert errors == []
    finally:
        process.terminate()
        process.communicate()


def labels_of(folder: Path) -> tuple[LabelledPattern, ...]:
    return read_labels(folder / "pairs.labels.toml").patterns
