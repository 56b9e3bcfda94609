"""`live play`, `render`, `replay` and `check`: films, journals, reports, refusals."""

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import av
import pytest

from tests.cli.command import run_live
from tests.fixtures.mostly_long import mostly_long

NO_SCREEN = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}


def gl_or_skip():
    from live.render.headless import NoOpenGL, create_headless_context, release_headless_context

    try:
        release_headless_context(create_headless_context())
    except NoOpenGL as reason:
        pytest.skip(str(reason))


@contextlib.contextmanager
def signal_when(number, when):
    """Sends a signal to this process as soon as `when` holds."""
    over = threading.Event()

    def watch():
        while not over.wait(0.02):
            if when():
                os.kill(os.getpid(), number)
                return

    watcher = threading.Thread(target=watch)
    watcher.start()
    try:
        yield
    finally:
        over.set()
        watcher.join()


@pytest.mark.long
def test_render_makes_identical_films_with_sound(tmp_path):
    gl_or_skip()
    films = []
    for name in ("a", "b"):
        result = run_live(
            "render", "--seconds", "5", "--fps", "10", "--size", "160x90", "--out", str(tmp_path / f"{name}.mp4"),
            "--journal", str(tmp_path / f"{name}.jsonl"), "--report", str(tmp_path / f"{name}.json"),
        )  # fmt: skip
        assert result.returncode == 0, result.stderr
        with av.open(str(tmp_path / f"{name}.mp4")) as film:
            pictures = [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]
            assert film.streams.audio
            assert float(film.duration / av.time_base) == pytest.approx(5.0, abs=0.1)
        films.append(pictures)
    assert len(films[0]) == 50
    assert all((a == b).all() for a, b in zip(*films, strict=True))
    assert (tmp_path / "a.jsonl").read_bytes() == (tmp_path / "b.jsonl").read_bytes()
    report = json.loads((tmp_path / "a.json").read_text())
    assert report["beat_offset_ms"]["annotated"]["p95"] < 5
    assert {row["measure"] for row in report["steps"]} == {1, 2, 3}
    assert report["min_distance_m"] > 0.3

    verified = run_live("replay", str(tmp_path / "a.jsonl"), "--verify", "--json")
    assert verified.returncode == 0, verified.stderr
    assert json.loads(verified.stdout)["different"] == []
    (tmp_path / "c.jsonl").write_text((tmp_path / "a.jsonl").read_text().replace('"hash":"', '"hash":"0', 1))
    assert run_live("replay", str(tmp_path / "c.jsonl"), "--verify").returncode == 1


@pytest.mark.long
def test_play_without_screen_makes_film_and_prints_path(tmp_path):
    gl_or_skip()
    film = tmp_path / "mine.mp4"
    result = run_live(
        "play", "--seconds", "1", "--fps", "10", "--size", "160x90", "--record", str(film), "--bpm", "100", **NO_SCREEN
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert str(film) in result.stderr
    assert film.stat().st_size > 1000


def test_headless_show_runs_in_real_time_with_replayable_journal(tmp_path):
    journal, status = tmp_path / "j.jsonl", tmp_path / "s.jsonl"
    result = run_live(
        "play", "--headless", "--seconds", "4", "--bpm", "150", "--osc", "127.0.0.1:0", "--journal", str(journal),
        "--status-json", str(status), **NO_SCREEN,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    last = json.loads(status.read_text().splitlines()[-1])
    assert last["measure"] >= 2
    assert last["ticks"] + last["skipped_ticks"] >= 4 * 64
    assert last["clock_state"] == "internal"
    assert set(last) >= {
        "time", "measure", "beat", "bpm", "source", "clock_state", "confidence", "frames", "late_frames", "ticks",
        "skipped_ticks", "frame_ms", "work_ms", "cpu_ms", "dancers", "events_accepted", "events_rejected",
        "phones", "rss_mb",
    }  # fmt: skip
    verified = run_live("replay", str(journal), "--verify", "--json")
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert json.loads(verified.stdout)["measures"] >= 1


@pytest.mark.long
def test_check_prints_ok_or_line_field_and_remedy(tmp_path):
    good = run_live("check")
    assert good.returncode == 0, good.stderr
    assert "24 dancers" in good.stdout
    bad = tmp_path / "bad.toml"
    bad.write_text('name = "x"\n[[group]]\nname = "a"\ndancers = 3\nsteps = ["grove"]\n')
    result = run_live("check", str(bad))
    assert result.returncode == 2
    assert "did you mean 'groove'?" in result.stderr
    bad.write_text('name = "x"\n[[group]]\nname = "a"\ndancers = -3\nsteps = ["groove"]\n')
    result = run_live("check", str(bad))
    assert result.returncode == 2
    assert f"{bad}, line 4: group.1.dancers" in result.stderr


@mostly_long(
    ("options", "words"),
    [
        (("--audio", "no such device"), "no sound input 'no such device'"),
        (("--audio", os.devnull + "x.wav"), "there is no such file"),
        (("--audio", __file__), "cannot be read as music"),
        (("--monitor", "7"), "'7' is not a monitor"),
        (("--bpm", "nan"), "--bpm nan: 20 to 400 expected"),
        (("--osc", "nowhere"), "HOST:PORT expected"),
        (("--size", "big"), "width and height"),
        (("--journal", "/nowhere/at/all/j"), "there is no folder"),
        (("--steps", "/proc"), "TOML"),
        (("not_a_patch",), "there is no patch 'not_a_patch'"),
    ],
    quick=[4, 5, 6, 9],
)
def test_invalid_options_are_refused_in_one_line(options, words):
    result = run_live("play", "--seconds", "1", *options, **NO_SCREEN)
    assert result.returncode == 2, result.stderr
    assert words in result.stderr
    assert "Traceback" not in result.stderr


def test_busy_port_is_named_with_remedy():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        result = run_live("play", "--headless", "--seconds", "1", "--osc", f"127.0.0.1:{port}", **NO_SCREEN)
    assert result.returncode == 2
    assert f"127.0.0.1:{port}" in result.stderr
    assert "--osc" in result.stderr


def test_names_with_square_brackets_are_accepted(tmp_path):
    """Square brackets are markup to the console but allowed in names."""
    show = tmp_path / "[b] show.toml"
    show.write_text('name = "Act [/b]"\n[[group]]\nname = "[red]"\ndancers = 1\nsteps = ["groove"]\n')
    result = run_live("check", str(show))
    assert result.returncode == 0, result.stderr
    assert "Act [/b]" in result.stdout


@pytest.mark.long
def test_journal_replays_elsewhere_and_refused_start_keeps_old_journal(tmp_path):
    (tmp_path / "mine" / "steps").mkdir(parents=True)
    sway = 'name = "sway"\n[pelvis]\n"1" = "left 4"\n"3" = "right 4"\n'
    (tmp_path / "mine" / "steps" / "sway.toml").write_text(sway)
    (tmp_path / "mine" / "show.toml").write_text('name = "x"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["sway"]\n')
    played = run_live(
        "play", "mine", "--headless", "--seconds", "3", "--bpm", "200", "--osc", "127.0.0.1:0", "--journal", "j.jsonl",
        cwd=tmp_path, **NO_SCREEN,
    )  # fmt: skip
    assert played.returncode == 0, played.stderr
    verified = run_live("replay", str(tmp_path / "j.jsonl"), "--verify", cwd=tmp_path.parent)
    assert verified.returncode == 0, verified.stdout + verified.stderr
    before = (tmp_path / "j.jsonl").read_bytes()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        busy = f"127.0.0.1:{taken.getsockname()[1]}"
        refused = run_live(
            "play", "--headless", "--seconds", "1", "--osc", busy, "--journal", str(tmp_path / "j.jsonl"), **NO_SCREEN
        )  # fmt: skip
    assert refused.returncode == 2
    assert (tmp_path / "j.jsonl").read_bytes() == before


@pytest.mark.long
def test_interrupted_film_is_playable_to_its_end(tmp_path):
    gl_or_skip()
    film, journal = tmp_path / "a.mp4", tmp_path / "j"
    with signal_when(
        signal.SIGINT, lambda: journal.exists() and journal.read_bytes().count(b'"hash":') >= 2
    ):  # measures
        result = run_live(
            "render", "--seconds", "600", "--size", "160x90", "--fps", "10", "--out", str(film), "--journal",
            str(journal),
        )  # fmt: skip
    assert result.returncode == 130, result.stderr
    with av.open(str(film)) as container:
        assert sum(1 for _ in container.decode(video=0)) >= 10


def test_input_file_is_never_overwritten(tmp_path):
    music = tmp_path / "song.mp4"
    music.write_bytes(b"precious")
    result = run_live("render", "--audio", str(music), "--out", str(music), "--seconds", "1")
    assert result.returncode == 2
    assert "the show reads this file" in result.stderr
    assert music.read_bytes() == b"precious"
    result = run_live("render", "--out", str(tmp_path / "film.avi"), "--seconds", "1")
    assert result.returncode == 2
    assert "ends in .mp4" in result.stderr


def endless_show_options(journal, status):
    """Options of a show that runs until it is ended."""
    where = ("--osc", "127.0.0.1:0", "--journal", str(journal), "--status-json", str(status))
    return "play", "--headless", "--bpm", "120", *where


@mostly_long("number", [signal.SIGHUP, signal.SIGINT], quick=[])
def test_show_ended_by_signal_completes_its_journal(tmp_path, number):
    """All in this process; the next test is a show of several processes. It has begun when the signal comes: where
    it opens a file at that moment, Python itself warns that the file is not closed.
    """
    journal, status = tmp_path / "j", tmp_path / "s"
    with signal_when(number, lambda: status.exists() and status.read_text().count("\n") >= 2):
        result = run_live(*endless_show_options(journal, status), "--alone")
    assert result.returncode == 128 + number
    assert "Traceback" not in result.stderr
    assert journal.read_text().endswith('"end":true}\n')


@pytest.mark.long
def test_process_ended_by_signal_completes_its_journal(tmp_path):
    journal, status = tmp_path / "j", tmp_path / "s"
    process = subprocess.Popen(
        [sys.executable, "-m", "live", *endless_show_options(journal, status)], stderr=subprocess.PIPE, text=True
    )
    try:
        deadline = time.monotonic() + 120
        while not status.exists() or not status.read_text():
            assert process.poll() is None, process.communicate()[1]
            assert time.monotonic() < deadline
            time.sleep(0.05)
        process.send_signal(signal.SIGTERM)
        _, last_words = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 128 + signal.SIGTERM
    assert "Traceback" not in last_words
    assert journal.read_text().endswith('"end":true}\n')


@pytest.mark.long
def test_full_disk_is_reported_at_end():
    if not os.path.exists("/dev/full"):
        pytest.skip("this system has no /dev/full")
    result = run_live(
        "play", "--headless", "--bpm", "120", "--seconds", "3", "--osc", "127.0.0.1:0", "--journal", "/dev/full"
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert "of the journal could not be written" in result.stderr


@pytest.mark.long
def test_own_steps_are_used_beside_project_steps(tmp_path):
    (tmp_path / "steps").mkdir()
    sway = 'name = "sway"\n[pelvis]\n"1" = "left 4"\n"3" = "right 4"\n'
    (tmp_path / "steps" / "sway.toml").write_text(sway)
    (tmp_path / "show.toml").write_text(
        'name = "x"\n[[group]]\nname = "a"\ndancers = 2\nsteps = ["sway", "groove"]\ntravel_step = "walk"\n'
    )
    result = run_live("check", str(tmp_path))
    assert result.returncode == 0, result.stderr
    (tmp_path / "steps" / "sway.toml").write_text(sway.replace("left 4", "right 8, down 160"))
    result = run_live("check", str(tmp_path))
    assert result.returncode == 2
    assert "Traceback" not in result.stderr
    assert "sway.toml" in result.stderr
