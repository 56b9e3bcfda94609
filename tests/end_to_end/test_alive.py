"""Shows with processes killed midway: the same measure, the same states, and no visible desktop."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from live.app.machine.systemd_unit import SystemdService
from live.base.system.picture_ring import ring_path
from live.show.patch.patch_search_path import PATCHES
from tests.cli.command import run_live
from tests.control.waiting import BUSY, wait_for
from tests.end_to_end.conftest import Running, children, end_all
from tests.end_to_end.test_window_show import _needs
from tests.fixtures.mostly_long import mostly_long
from tests.fixtures.screen_eye import ScreenReader
from tests.fixtures.two_monitor_x import FIRST, TwoMonitorX
from tests.supervisor.made_machines import free_port, pair_folders

RED = "c00000"
"""What the desktop shows where nothing else is seen."""


def wait_for_spare(running: Running) -> None:
    running.wait_for(lambda line: line["alive"].get("spare", False) and line["measure"] > 2, 60)


def verify_journal(journal: Path, begin: int = 1) -> dict[str, object]:
    done = run_live("replay", str(journal), "--verify", "--json", "--from", str(begin))
    assert done.returncode == 0, done.stdout + done.stderr
    found: dict[str, object] = json.loads(done.stdout)
    return found


def test_killed_processes_leave_measure_and_states_unchanged(play, patch: Path, tmp_path: Path):
    """One show: audio process and OSC reader are killed, then three engines, sooner than a spare can prepare itself.
    The journal of all of them is that of one show; the music plays on in its own process; messages sent while no
    engine ran are in it. A client logged in to the operator's page is accepted again.
    """
    journal = tmp_path / "j.jsonl"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with socket.create_server(("127.0.0.1", 0)) as free:
        page = free.getsockname()[1]
    how = (str(patch), "--audio", str(PATCHES / "music" / "first_show.ogg"), "--headless", "--osc", f"127.0.0.1:{port}")
    config = {"LIVE_CONFIG_DIR": str(tmp_path / "config")}
    running = play(*how, "--web", str(page), "--journal", str(journal), env=config)
    wait_for_spare(running)
    key = (tmp_path / "config" / "web-key").read_text().strip()
    assert wait_for(lambda: page_status(page, key) == 200, 20)
    os.kill(children(running, "audio_main")[0], signal.SIGKILL)
    os.kill(children(running, "osc_reader")[0], signal.SIGKILL)
    running.wait_for(lambda line: line["alive"].get("audio_restarts") == line["alive"].get("osc_restarts") == 1, 20)
    before = running.lines()[-1]
    after = kill_three_engines(running, port)
    beats = (after["time"] - before["time"]) * after["bpm"] / 60  # the measure is the one that it would have been
    assert after["measure"] - before["measure"] == pytest.approx(beats / 4, abs=1.0)
    heard = journal.read_text().count('"audio"')
    assert wait_for(lambda: journal.read_text().count('"audio"') > heard + 3, 20)
    running.wait_for(lambda line: line["alive"].get("spare", False) and line["measure"] > after["measure"] + 1, 20)
    assert wait_for(lambda: page_status(page, key) == 200, 20), "the key is the same in every engine"
    assert page_status(page, "another-key-than-that") == 401
    processes = children(running, "process")
    assert "Traceback" not in running.stop()
    assert wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in processes), 5)
    found = verify_journal(journal)
    assert found["complete"]
    assert int(str(found["measures"])) > after["measure"]
    assert journal.read_text().count('"Blackout"') == 1


def page_status(port: int, key: str) -> int:
    """The HTTP status of the operator's page for this key; 0 without an answer."""
    asked = urllib.request.Request(f"http://127.0.0.1:{port}/surface.json", headers={"Authorization": f"Bearer {key}"})
    try:
        with urllib.request.urlopen(asked, timeout=5.0) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as error:
        return error.code
    except OSError:
        return 0


def kill_three_engines(running: Running, port: int) -> dict[str, Any]:
    """From kill to dance within three seconds: the engine after the spare comes from the nursery, with all loaded. The
    stage is blacked out by OSC at `port` while no engine runs.
    """
    engine, nursery, spare = children(running, "engine_main")
    killed: list[int] = []

    def dancing() -> list[int]:
        return [pid for pid in children(running, "engine_main") if pid not in (nursery, *killed)]

    for number in range(3):
        if number:
            time.sleep(0.5)  # what is tested is how soon it comes, and whatever is there then is killed
        assert wait_for(lambda: bool(dancing()), 5)
        killed.append(dancing()[0])
        os.kill(killed[-1], signal.SIGKILL)
        if not number:
            send_blackout(port)
    assert killed[:2] == [engine, spare]
    line = running.wait_for(lambda line: line["alive"].get("restarts") == 3 and line["alive"]["takeover_s"], 20)
    assert line["alive"]["takeover_s"] < 3.0 * BUSY  # since the first of them
    assert not line["alive"]["calm"]
    assert nursery in children(running, "engine_main")
    return line


@pytest.mark.long
def test_show_outlives_supervisor_and_is_adopted_by_next_one(play, patch: Path, tmp_path: Path):
    """Supervisor killed: ticks, journal, sound, status and OSC continue in the same engine. Started again, it adopts
    that engine; then the engine is killed, and the show continues as if it had always been the supervisor's.
    """
    journal = tmp_path / "j.jsonl"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    music = ("--audio", str(PATCHES / "music" / "first_show.ogg"))
    how = (str(patch), *music, "--headless", "--osc", f"127.0.0.1:{port}", "--journal", str(journal))
    service = SystemdService("evening", how, tmp_path, True, {}).command()  # what systemd runs, and runs again
    assert service[:4] == [sys.executable, "-m", "live", "play"]
    own = {"XDG_RUNTIME_DIR": str(tmp_path)}
    running = play(*service[4:], env=own)
    wait_for_spare(running)
    engine, sound = children(running, "engine_main")[0], children(running, "audio_main")[0]
    running.process.kill()
    running.process.wait()
    killed = running.lines()[-1]
    assert wait_for(lambda: running.lines()[-1]["measure"] > killed["measure"] + 1, 20)
    alone = running.lines()[-1]
    assert not alone["alive"]["supervised"]
    assert alone["audio"]["state"] == killed["audio"]["state"]
    send_blackout(port)
    assert wait_for(lambda: '"Blackout"' in journal.read_text(), 10)
    again = play(*service[4:], env=own, status=running.status)
    again.wait_for(lambda line: line["alive"].get("adopted") == 1 and line["alive"]["supervised"], 30)
    again.wait_for(lambda line: line["alive"].get("adopted") == 1 and line["alive"]["spare"], 60)
    assert Path(f"/proc/{sound}").exists()
    os.kill(engine, signal.SIGKILL)
    line = again.wait_for(lambda line: line["alive"].get("restarts") == 1 and line["alive"]["takeover_s"], 20)
    again.wait_for(lambda now: now["measure"] > line["measure"] + 1, 20)
    beats = (line["time"] - killed["time"]) * line["bpm"] / 60
    assert line["measure"] - killed["measure"] == pytest.approx(beats / 4, abs=1.0)
    gaps = [after["time"] - before["time"] for before, after in pairwise(lines_between(again.lines(), alone, line))]
    assert max(gaps) < 3.0 * BUSY
    processes = children(again, "process")
    assert "Traceback" not in again.stop()
    assert wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in (*processes, sound)), 5)
    found = verify_journal(journal)
    assert found["complete"]
    assert found["problems"] == []


@pytest.mark.long
def test_service_without_processes_resumes_from_journal(play, patch: Path, tmp_path: Path):
    """All are killed at once; the service started next by systemd is in the measure where the show would be."""
    journal = tmp_path / "j.jsonl"
    how = (str(patch), "--bpm", "240", "--headless", "--osc", "127.0.0.1:0", "--journal", str(journal))
    service = SystemdService("evening", how, tmp_path, True, {}).command()
    own = {"XDG_RUNTIME_DIR": str(tmp_path)}
    running = play(*service[4:], env=own)
    running.wait_for(lambda line: line["measure"] > 12, 60)
    end_all(running.mark)
    gone = running.lines()[-1]
    again = play(*service[4:], env=own, status=running.status)
    assert wait_for(lambda: again.lines()[-1]["time"] > gone["time"] + 3.0, 60)
    back = again.lines()[-1]
    assert back["measure"] - gone["measure"] == pytest.approx(back["time"] - gone["time"], abs=1.1)
    assert "Traceback" not in again.stop()
    found = verify_journal(journal)
    assert found["complete"]
    assert int(str(found["measures"])) >= back["measure"] - 3  # hashes that were on their way are lost with all


def lines_between(lines: list[dict[str, Any]], first: dict[str, Any], last: dict[str, Any]) -> list[dict[str, Any]]:
    return [line for line in lines if first["time"] <= line["time"] <= last["time"]]


def send_blackout(port: int) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"/dance/blackout\0,i\0\0\0\0\0\1", ("127.0.0.1", port))


@pytest.mark.long
def test_standby_machine_dances_same_show_and_takes_over(play, patch: Path, tmp_path: Path):
    """Two paired machines; the standby has no screen, draws into a share and reports its state."""
    one, two, name = tmp_path / "one", tmp_path / "two", f"standby-{os.getpid()}"
    pair_folders(one, two)
    port = free_port()
    how = (str(patch), "--bpm", "240", "--headless", "--osc", "127.0.0.1:0", "--size", "160x96")
    leader = play(*how, "--lead", str(port), env={"LIVE_CONFIG_DIR": str(one)})
    other = play(
        *how, "--standby", f"127.0.0.1:{port}", "--journal", str(tmp_path / "j.jsonl"), "--share", f"shm:{name}",
        env={"LIVE_CONFIG_DIR": str(two)},
    )  # fmt: skip
    leader.wait_for(lambda line: line["alive"].get("followers") == 1, 60)
    leader.wait_for(lambda line: line["alive"].get("deputy") == "two", 60)
    ready = other.wait_for(lambda line: line["alive"].get("is_deputy", False), 20)
    assert (ready["alive"]["ready"], ready["alive"]["follows"]) == (True, "one")
    assert wait_for(lambda: _hashes(tmp_path / "j.jsonl") > 4, 60)
    before, _ = newest_picture(name)
    assert wait_for(lambda: newest_picture(name)[0] > before + 10, 10)
    assert max(newest_picture(name)[1]) > 30  # it is no black picture
    for pid in (*children(leader, "engine_main"), leader.process.pid):
        os.kill(pid, signal.SIGKILL)
    line = other.wait_for(lambda line: line["alive"].get("epoch") == 2, 20)
    assert ready["measure"] <= line["measure"]
    before, _ = newest_picture(name)
    assert wait_for(lambda: newest_picture(name)[0] > before + 10, 10)  # the same ring goes on
    assert (line["alive"]["different"], line["alive"]["compared"] > 3) == (0, True)
    other.wait_for(lambda now: now["measure"] > line["measure"] + 2, 20)
    assert "Traceback" not in other.stop()
    verify_journal(tmp_path / "j.jsonl")


@pytest.mark.long
def test_stopped_leader_follows_after_return_and_leads_again_when_needed(play, patch: Path, tmp_path: Path):
    """The real engines of both change roles twice, and both journals verify."""
    one, two = tmp_path / "one", tmp_path / "two"
    pair_folders(one, two)
    port = free_port()
    how = (str(patch), "--bpm", "240", "--headless", "--osc", "127.0.0.1:0")
    journals = tmp_path / "one.jsonl", tmp_path / "two.jsonl"
    leader = play(*how, "--lead", str(port), "--journal", str(journals[0]), env={"LIVE_CONFIG_DIR": str(one)})
    other = play(
        *how, "--standby", f"127.0.0.1:{port}", "--journal", str(journals[1]), env={"LIVE_CONFIG_DIR": str(two)}
    )
    leader.wait_for(lambda line: line["alive"].get("deputy") == "two", 120)
    stopped = [*children(leader, "process"), leader.process.pid]
    for pid in stopped:
        os.kill(pid, signal.SIGSTOP)
    other.wait_for(lambda line: line["alive"].get("epoch") == 2 and not line["alive"]["follows"], 20)
    for pid in stopped[::-1]:
        os.kill(pid, signal.SIGCONT)
    back = leader.wait_for(lambda line: line["alive"].get("follows") == "two" and line["alive"]["is_deputy"], 60)
    assert (back["alive"]["epoch"], back["alive"]["ready"], back["alive"]["different"]) == (2, True, 0)
    for pid in (*children(other, "engine_main"), other.process.pid):
        os.kill(pid, signal.SIGKILL)
    again = leader.wait_for(lambda line: line["alive"].get("epoch") == 3, 20)
    leader.wait_for(lambda now: now["measure"] > again["measure"] + 2, 20)
    assert again["alive"]["silent_s"] < 3.0
    assert not again["alive"]["fenced"]
    assert "Traceback" not in leader.stop()
    verify_journal(journals[0], begin=back["measure"])  # it begins with the snapshot that the other one gave
    assert journals[0].with_name("one.jsonl.1").exists()  # what it led before


def newest_picture(name: str) -> tuple[int, bytes]:
    """The number of the newest picture of a share of 160 x 96, and its pixels."""
    data = ring_path(name).read_bytes()
    number = int.from_bytes(data[32:40], "little")
    begin, size = 4096, 160 * 96 * 3
    place = (number - 1) % 4
    return number, data[begin + place * size : begin + (place + 1) * size]


def _hashes(journal: Path) -> int:
    return journal.read_text().count('"hash"') if journal.exists() else 0


@pytest.mark.long
@pytest.mark.x11
def test_projector_shows_dance_again_and_never_desktop(play, patch: Path, two_monitor_x: TwoMonitorX):
    _needs("xsetroot")
    two_monitor_x.plug_both()
    two_monitor_x.run("xsetroot", "-solid", f"#{RED}")
    environment = {"DISPLAY": two_monitor_x.display}
    running = play(
        str(patch), "--bpm", "150", "--monitor", "2", "--fullscreen", "--osc", "127.0.0.1:0", env=environment
    )  # fmt: skip
    wait_for_spare(running)
    eye = ScreenReader(two_monitor_x.display, FIRST[0] + 400, 560)  # on the stage's floor, near the audience
    try:
        floor = eye.see()
        assert floor not in (RED, "000000")
        os.kill(children(running, "engine_main")[0], signal.SIGKILL)
        # black, or the picture of before as long as the system has not cleared the dead engine away
        seen, _ = eye.watch(lambda _: any("takeover_s" in line["alive"] and line["alive"]["takeover_s"] is not None
                                          for line in running.lines()[-2:]), 20.0 * BUSY)  # fmt: skip
        assert RED not in seen
        line = running.wait_for(lambda line: line["alive"].get("takeover_s") is not None, 20)
        assert line["alive"]["takeover_s"] < 3.0
        assert eye.see() not in (RED, "000000")
        assert line["alive"]["guard"]
        processes = children(running, "process")
        assert "Traceback" not in running.stop()
        assert wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in processes), 5)
    finally:
        eye.close()


def test_lead_and_standby_need_supervisor_and_valid_address(tmp_path: Path):
    for option in (("--lead", "9020"), ("--standby", "somewhere")):
        done = run_live("play", "--headless", "--alone", *option)
        assert done.returncode == 2
        assert "need a supervisor" in done.stderr
    for wrong in ("a b:1", "host:70000", ":", "host:x"):
        done = run_live("play", "--headless", "--standby", wrong)
        assert done.returncode == 2, wrong
        assert "HOST:PORT expected" in done.stderr


@mostly_long("signals", [(signal.SIGINT,), (signal.SIGTERM,)], quick=[1])
def test_interrupted_start_leaves_no_process(play, patch: Path, signals):
    running = play(str(patch), "--headless", "--osc", "127.0.0.1:0")
    assert wait_for(lambda: len(children(running, "process")) > 0, 20)
    processes = children(running, "process")
    for number in signals:
        running.process.send_signal(number)
    code = running.process.wait(60)
    assert code in (130, 128 + signals[0])
    assert wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in processes), 5)


@pytest.mark.long
def test_person_error_is_printed_once_and_ends_command(tmp_path: Path):
    done = subprocess.run(
        [sys.executable, "-m", "live", "play", "no-such-patch", "--headless"],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert done.stderr.count("error:") == 1
