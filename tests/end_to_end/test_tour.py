"""A tour of the documentation: every command that it tells to type is run, page by page, in a folder of its own.

What a page names is in that folder (`tour_folder`). Shows end after two seconds and have no window; servers are ended
once they say that they run. What needs a device that this machine lacks has to say so, in the words of `REFUSALS`.
"""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import threading
from itertools import groupby
from pathlib import Path

import pytest

from tests.documentation.snippets import commands
from tests.documentation.tour_folder import make_tour_folder

pytestmark = [pytest.mark.long, pytest.mark.xdist_group("tour")]

DEADLINE = 180.0
"""Seconds for one command on a busy machine."""
NOT_RUN = {
    r"live (soak|bench)\b": "runs for minutes or hours: make soak, make bench",
    r"live service (install|stop|uninstall)": "changes the machine",
    r"live calibrate": "plays sweeps over a loudspeaker",
    r"(192\.168|10\.0\.0|236\.10)\.|stage-left|stage\.local|fullchain|--psn|--dmx sacn|rtp:|tcp:": "other machines",
    r"live steps enrich|live texture .*--with": "needs recordings of dancers",
    r"live partner": "needs recordings of pairs",
    r"49_10\.amc": "needs a recording of the CMU library",
    r"live (music|document) .*(lines\.(txt|csv))": "needs lines of another program",
    r"live document keep": "needs a show that runs",
    r"live clock-check": "needs a recorded clock",
    r"live mocap send": "needs a show that listens",
    r"live sim .*--phones": "needs a show that runs",
}
REFUSALS = {
    r'--(audio|click|midi|midi-out|midi-clock-out) "|--grid': r"no .*(input|output|device|port|MIDI|sound)|PortAudio",
}
"""Commands that may end with exit code 2 here, and what they have to say then."""
ENDLESS = re.compile(r"live (studio|docs|pair$)")
LIMITS = {"play": "2", "steps play": "2", "render": "1"}
"""Seconds after which commands end."""
WINDOWS = ("play", "steps play")
PAGES = [(page, [each[1] for each in group]) for page, group in groupby(commands(), lambda each: each[0].page)]


@pytest.fixture(scope="session")
def materials(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tour") / "folder"
    make_tour_folder(folder)
    return folder


def replace_value(words, option, value):
    """Give an option another value, if it is there."""
    if option in words:
        words[words.index(option) + 1] = value


def shorten(typed):
    """Return the words of a command, with less to do, on this machine only."""
    words = [word for word in shlex.split(typed.replace("0.0.0.0", "127.0.0.1"))[1:] if word != "--fullscreen"]
    replace_value(words, "--size", "320x180")
    if words[0] == "play":
        replace_value(words, "--journal", "short.jsonl")  # the long night stays
    name = " ".join(words[:2]) if words[0] == "steps" else words[0]
    if name in WINDOWS and not {"--film", "--record"} & set(words):
        words.append("--headless")
    if name in LIMITS:
        replace_value(words, "--seconds", LIMITS[name])
        words += [] if "--seconds" in words else ["--seconds", LIMITS[name]]
    return words


def run(typed, folder, home):
    """Run a command; return its exit code and what it printed."""
    environment = {
        **os.environ, "HOME": str(home), "XDG_CONFIG_HOME": str(home / "config"), "XDG_DATA_HOME": str(home / "data"),
        "NO_COLOR": "1", "COLUMNS": "200", "BROWSER": "true", "SDL_AUDIODRIVER": "dummy",
    }  # fmt: skip
    words = [sys.executable, "-m", "live", *shorten(typed)]
    process = subprocess.Popen(
        words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, start_new_session=True,
    )  # fmt: skip
    said, timer = "", threading.Timer(DEADLINE, os.killpg, (process.pid, signal.SIGKILL))
    timer.start()
    try:
        if ENDLESS.match(typed):
            for line in process.stdout:
                said += line
                if re.search(r"https?://|phrase", line):
                    process.send_signal(signal.SIGINT)
                    break
        said += process.communicate()[0]
    finally:
        timer.cancel()
    return process.returncode, said


@pytest.mark.parametrize(("page", "typed"), PAGES, ids=[page for page, _ in PAGES])
def test_commands_of_a_page_run(page, typed, materials, tmp_path):
    folder = tmp_path / "tour"
    shutil.copytree(materials, folder)
    cache = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    home = tmp_path / "home"
    home.mkdir()
    (home / ".cache").symlink_to(cache)
    venues = home / "config" / "choreographics-live" / "venues"
    venues.mkdir(parents=True)
    (venues / "hall.toml").write_text('name = "Hall"\n[latency]\nprojector_ms = 35.0\n')
    failed = []
    for line in typed:
        if any(re.search(pattern, line) for pattern in NOT_RUN):
            continue
        code, said = run(line, folder, home)
        may_refuse = [words for pattern, words in REFUSALS.items() if re.search(pattern, line)]
        ended = code in (0, 130) or (code == 1 and re.search(r"live (check|doctor|steps check|journal diff)", line))
        refused = code == 2 and any(re.search(words, said) for words in may_refuse)
        if (not ended and not refused) or "Traceback" in said:
            failed.append(f"{line}\n  ends with {code}: {said.strip()[-600:]}")
    assert not failed, "\n\n".join(failed)
