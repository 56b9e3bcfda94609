"""Chaos: call sites and injected exceptions, measures of a journal, processes, small disk, and the seeded plan."""

import json
import os
import signal
import subprocess
import sys
import threading

import pytest

from live.rehearse.chaos.call_sites import CallSite, CallSiteTracer, ExceptionInjector, InjectedError, replaced_tick
from live.rehearse.chaos.fault_actions import ACTIONS, STALLS
from live.rehearse.chaos.fault_page import FaultPage, PageWord
from live.rehearse.chaos.fault_plan import DISK_FAULTS, ENGINE_FAULTS, FAULT_SECONDS, chaos_schedule
from live.rehearse.chaos.injection import THREADS_FILE, raise_in_thread
from live.rehearse.chaos.journal_checks import read_measures
from live.rehearse.chaos.process_tree import ProcessTree, cpu_pressure, descriptors, limited_descriptors, read_process
from live.rehearse.chaos.small_disk import SmallDisk
from live.rehearse.chaos.virtual_run import SiteSequence, virtual_chaos
from live.rehearse.soak_test import SoakOptions
from live.show.patch.patch_search_path import find_patch
from tests.control.waiting import wait_for
from tests.show.made_show import made_show


@pytest.fixture(scope="module")
def sites():
    """The call sites of a few seconds of a made show."""
    show, looker = made_show(), CallSiteTracer()
    with replaced_tick(looker.run):
        for tick in range(1, 400):
            show.tick(tick / 64.0)
    return sorted(looker.sites)


@pytest.mark.long
def test_call_sites_include_tick_and_measure_line_code(sites):
    callers = {site.caller.split(", ")[1] for site in sites}
    assert {"Frame._tick", "CrowdStage.tick", "MeasureLines._cross"} <= callers
    assert len(sites) > 50
    assert any(site.callee == "show/dancing.py, Dancing.begin_heading" or "begin" in site.callee for site in sites)
    assert any(", " not in site.callee for site in sites)  # what is not ours, too
    assert sys.getprofile() is None


@pytest.mark.long
def test_call_sites_in_circuit_breakers_are_marked(sites):
    """The name of their file is a string, which went stale when the file moved."""
    assert 0 < sum(site.is_breaker for site in sites) < len(sites) / 2


def test_exception_is_injected_given_number_of_times(sites):
    site = next(
        site for site in sites if site.caller.endswith("CrowdStage.tick") and "GroupMotion.advance" in site.callee
    )
    injector, show, raised = ExceptionInjector(), made_show(), []
    injector.arm(site, 3, since=1.0)
    with replaced_tick(injector.run):
        for tick in range(1, 200):
            try:
                show.tick(tick / 64.0)
            except InjectedError as error:
                raised.append((tick, str(error)))
    assert [tick >= 64 and str(site) in words for tick, words in raised] == [True] * 3
    assert injector.raised_count == 3
    assert injector.remaining == 0


def test_unknown_call_site_raises_no_exception():
    injector, show = ExceptionInjector(), made_show()
    injector.arm(CallSite("show/show.py, Show.nothing", 1, "none"), 3, since=0.0)
    with replaced_tick(injector.run):
        for tick in range(1, 80):
            show.tick(tick / 64.0)
    assert injector.raised_count == 0


@pytest.mark.long
def test_show_survives_tick_failures_and_journal_replays(tmp_path):
    plan = SoakOptions(find_patch("score"), seed=2, hours=0.2, fps=16.0, faults=0.0)
    facts = virtual_chaos(plan, tmp_path, sites=4)
    assert facts["problems"] == []
    assert facts["tried"] == facts["wanted"] >= 8
    assert facts["deaths"] >= 4
    assert facts["replay"]["different"] == 0
    assert facts["replay"]["measures"] > 5
    json.dumps(facts)


@pytest.mark.long
def test_failed_recovery_is_reported_with_its_call_site(tmp_path, monkeypatch):
    """A recovery that gives up is reported with the failing call site of that time."""

    class Gives:
        def __init__(self, following, death):
            pass

        def run(self):
            raise RuntimeError("nothing has helped")

    monkeypatch.setattr("live.rehearse.chaos.virtual_run.Recovery", Gives)
    monkeypatch.setattr("live.rehearse.chaos.virtual_run.TRACE_SECONDS", 2.0)
    plan = SoakOptions(find_patch("score"), seed=2, hours=0.02, fps=16.0, faults=0.0)
    facts = virtual_chaos(plan, tmp_path, sites=2)
    assert not facts["ok"]
    assert "nothing has helped" in facts["problems"][0]
    assert facts["problems"][1].startswith("failing at that time: show/")


def test_plan_is_seeded_and_contains_every_kind_first():
    first, again, other = (list(chaos_schedule(seed, until=600.0)) for seed in (1, 1, 2))
    assert first == again != other
    assert {blow.kind for blow in first[: len(FAULT_SECONDS)]} == set(FAULT_SECONDS)
    assert [blow.time for blow in first] == sorted(blow.time for blow in first)
    assert all(blow.time < 600.0 for blow in first)
    assert {*DISK_FAULTS, *ENGINE_FAULTS} <= set(FAULT_SECONDS)
    assert len(list(chaos_schedule(1, until=300.0, rate=2.0))) > 1.8 * len(list(chaos_schedule(1, until=300.0)))


def test_every_fault_kind_has_an_action():
    assert set(ACTIONS) == set(FAULT_SECONDS)
    assert set(STALLS) < set(FAULT_SECONDS)


def _journal(path, *lines):
    path.write_text("\n".join(json.dumps(line) for line in ({"journal": 2}, *lines)) + "\n")
    return read_measures(path)


def _measure_line(number, tick, **more):
    return {"tick": tick, "measure": number, "hash": "0", **more}


def test_journal_measures_are_classified(tmp_path):
    path = tmp_path / "j"
    skipped = {"tick": 30, "event": {"type": "TicksSkipped", "time": 1.0, "source": "engine", "count": 500}}
    good = _journal(
        path, _measure_line(2, 10), _measure_line(3, 20), skipped, _measure_line(6, 700), {"tick": 800, "end": True}
    )
    assert (good.twice, good.missed, good.leapt, good.lacking, good.ended) == ([], [], [4, 5], [], True)
    assert good.skipped == 500
    lost = _journal(path, _measure_line(2, 10), _measure_line(5, 20, gap=7))
    assert (lost.missed, lost.lacking, lost.lost, lost.ended) == ([], [3, 4], 7, False)
    missed = _journal(path, _measure_line(2, 10), _measure_line(4, 20))
    assert missed.missed == [3]
    twice = _journal(path, _measure_line(2, 10), _measure_line(3, 20), _measure_line(3, 30))
    assert twice.twice == [3]


def test_exception_is_raised_in_another_thread(tmp_path):
    ended, found = threading.Event(), []

    def work():
        try:
            while not ended.wait(0.001):
                pass
        except InjectedError as error:
            found.append(error)

    thread = threading.Thread(target=work, name="a device of a test", daemon=True)
    thread.start()
    names = [one.name for one in threading.enumerate() if not one.name.startswith(("MainThread", "Thread-"))]
    assert raise_in_thread(sorted(names).index("a device of a test"), tmp_path) == "a device of a test"
    assert wait_for(lambda: bool(found), 5.0)
    assert (tmp_path / THREADS_FILE).read_text() == "a device of a test\n"
    ended.set()
    thread.join()


def test_fault_page_is_shared_between_processes(tmp_path):
    page = FaultPage(tmp_path / "page", make=True)
    page[PageWord.LEFT] = -3
    code = (
        "import sys; from pathlib import Path; from live.rehearse.chaos.fault_page import FaultPage, PageWord\n"
        "page = FaultPage(Path(sys.argv[1])); page[PageWord.RAISED] = page[PageWord.LEFT] + 10; page.close()"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path / "page")], check=True)
    assert page[PageWord.RAISED] == 7
    page.close()
    with pytest.raises(FileNotFoundError):
        FaultPage(tmp_path / "none")


@pytest.fixture
def sleeper():
    """A process that waits."""
    started = subprocess.Popen([sys.executable, "-S", "-c", "import sys; print(1, flush=True); sys.stdin.read()"],
                               stdin=subprocess.PIPE, stdout=subprocess.PIPE)  # fmt: skip
    started.stdout.readline()
    yield started
    started.stdin.close()
    started.wait(5.0)
    started.stdout.close()


def test_processes_are_listed_stopped_and_resumed(sleeper, tmp_path):
    tree = ProcessTree(os.getpid(), tmp_path)
    assert any(one.pid == sleeper.pid for one in tree.descendants())
    assert tree.signal(sleeper.pid, signal.SIGSTOP)
    assert wait_for(lambda: read_process(sleeper.pid).state == "T", 5.0)
    tree.resume_all()
    assert wait_for(lambda: read_process(sleeper.pid).state == "S", 5.0)
    assert not tree.zombies() & {sleeper.pid}
    assert read_process(1 << 22) is None
    assert 0.0 <= cpu_pressure() <= 1.0


def test_orphans_of_killed_supervisor_belong_to_next_one(tmp_path):
    words = (
        "import subprocess, sys, time; subprocess.Popen([sys.executable, '-S', '-c', 'import time; time.sleep(60)'])"
    )
    first = subprocess.Popen([sys.executable, "-S", "-c", f"{words}; time.sleep(60)"])
    tree = ProcessTree(first.pid, tmp_path)
    assert wait_for(lambda: [one.state for one in tree.descendants()] == ["S"], 5.0)
    [left] = tree.descendants()
    tree.kill_supervisor()
    first.wait(5.0)
    tree.supervisor = os.getpid()
    assert left.pid in {one.pid for one in tree.descendants()}
    tree.signal(left.pid, signal.SIGKILL)
    assert wait_for(lambda: read_process(left.pid) is None or read_process(left.pid).state == "Z", 5.0)
    assert left.pid not in tree.zombies()


def test_descriptor_limit_is_restored(sleeper):
    import resource

    before = resource.prlimit(sleeper.pid, resource.RLIMIT_NOFILE)
    with limited_descriptors(sleeper.pid):
        assert resource.prlimit(sleeper.pid, resource.RLIMIT_NOFILE)[0] == descriptors(sleeper.pid) > 0
    assert resource.prlimit(sleeper.pid, resource.RLIMIT_NOFILE) == before


def test_small_disk_is_filled_and_freed(tmp_path):
    disk = SmallDisk(tmp_path / "disk")
    disk.open()
    try:
        (disk.path / "journal.jsonl").write_text("first\n")
        if disk.fill():
            with pytest.raises(OSError, match="space"):
                (disk.path / "more").write_bytes(bytes(8192))
        disk.free()
        (disk.path / "more").write_bytes(bytes(8192))
        disk.copy_to(tmp_path)
    finally:
        disk.close()
    assert (tmp_path / "journal.jsonl").read_text() == "first\n"
    assert not os.path.ismount(disk.path)


def test_site_sequence_advances_and_detects_restart_loop():
    class Made:
        def __init__(self):
            self.told, self.inbox, self.foreseen = [], [], False
            self.clock = type("", (), {"now": staticmethod(lambda: Made.now)})
            self.deaths = type("", (), {"count": 0})()
            self.journal = type("", (), {"add_problem": self.told.append})()
            self.show = type("", (), {"breakers": type("", (), {"reasons": {}})()})()

    Made.now = 0.0
    soak = Made()
    row = SiteSequence(soak, [(CallSite("a", 1, "b"), "always"), (CallSite("a", 2, "b"), "once")])
    row.before_frame()
    assert row.injector.site == CallSite("a", 1, "b")
    soak.deaths.count = 20
    row.injector.raised_count = 20
    row.before_frame()
    assert "20 engines ended" in soak.told[0]
    Made.now = 5.0
    row.before_frame()
    assert row.injector.site == CallSite("a", 2, "b")
    Made.now = 50.0
    row.before_frame()
    assert row.is_done
    assert row.never_reached == ["a, line 2 -> b (once)"]
