"""Shared test setup: fixed seeds, strict floating point, parallel processes, test data."""

import contextlib
import gc
import importlib
import os
import random
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from live.base.system.blas_threads import use_one_blas_thread

use_one_blas_thread()  # several processes share the cores: threads that wait for each other take most of the time

import numpy as np  # noqa: E402
import pytest  # noqa: E402
from hypothesis import HealthCheck, settings  # noqa: E402

ROOT = Path(__file__).resolve().parent
SHARED = ROOT.parent / "shared"
WHOLE = {ROOT, ROOT / "tests", ROOT / "live" / "bridges"}
"""Folders whose tests are run by several processes."""

# Laws: the same examples each time and no deadline, so that neither luck nor a busy machine decides.
# `pytest --hypothesis-profile=search` looks further, with new examples each time.
settings.register_profile("steady", derandomize=True, deadline=None, max_examples=50)
settings.register_profile("search", deadline=None, max_examples=1000, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("steady")

# Children start sooner if they need not compile the package anew; so does pytest, to which compiling all tests
# is more than half of the time of collecting them.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Everything is drawn as macOS can: Mesa gives a forward-compatible core context of OpenGL 4.1, and no more.
os.environ.setdefault("MESA_GL_VERSION_OVERRIDE", "4.1FC")
os.environ.setdefault("MESA_GLSL_VERSION_OVERRIDE", "410")

BEGAN = pytest.StashKey[float]()
"""Time of the first test [s], for `--budget`."""

ONE_AT_A_TIME = ("pulse", "x11", "network")
"""Markers or fixtures of tests with real devices: tests with the same one never run at the same time."""

LONG_FIRST = ("pulse", "x11", "test_kernels_in_python.py", "end_to_end", "network", "supervisor", "app", "cli", "show")
"""Groups, folders or files that start first, so that no process has a long test left at the end. Tests that mostly wait
are mixed with tests that compute."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--budget", type=float, default=0.0, help="seconds after which the remaining tests are skipped")
    parser.addoption("--regenerate-goldens", action="store_true", help="rewrite the golden images")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what is left when the time that was allowed is over."""
    budget = item.config.getoption("--budget")
    if budget:
        began = item.config.stash.setdefault(BEGAN, time.monotonic())
        if time.monotonic() - began > budget:
            pytest.skip(f"{budget:g} s are over: `make check` runs this test, too")


def _is_whole(config: pytest.Config) -> bool:
    return {(config.invocation_params.dir / argument).resolve() for argument in config.args} <= WHOLE


@pytest.hookimpl(tryfirst=True)
def pytest_collection(session: pytest.Session) -> None:
    """With several processes, each imports its share of the tests first: in a new checkout, where importing compiles
    them, which takes longer than most tests, they would otherwise all compile the same.
    """
    there = getattr(session.config, "workerinput", None)
    if there is None or not _is_whole(session.config):
        return
    number, count = int(there["workerid"].removeprefix("gw")), there["workercount"]
    files = sorted(path.relative_to(ROOT) for part in ("tests", "live") for path in (ROOT / part).rglob("test_*.py"))
    for path in files[number::count]:
        with contextlib.suppress(Exception, pytest.skip.Exception):  # collecting tells
            importlib.import_module(".".join(path.with_suffix("").parts))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One process more than cores for the whole suite, since some tests wait for a device or another process;
    otherwise only this one: starting more takes longer than it saves.
    """
    if not _is_whole(config):
        return 0
    return 1 + min(len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, 7)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Tests of a file stay together, since they share costly fixtures, and so do tests of a group."""
    from xdist.scheduler import LoadGroupScheduling

    class Files(LoadGroupScheduling):
        def _split_scope(self, nodeid: str) -> str:
            group = super()._split_scope(nodeid)
            return nodeid.partition("::")[0] if group == nodeid else group

    return Files(config, log)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """With several processes: tests of one real device form a group, and long tests come first."""
    if not hasattr(config, "workerinput"):
        return
    for item in items:
        for name in ONE_AT_A_TIME:
            if item.get_closest_marker(name) or name in getattr(item, "fixturenames", ()):
                item.add_marker(pytest.mark.xdist_group(name))
                break

    def rank(item: pytest.Item) -> int:
        group = item.get_closest_marker("xdist_group")
        name = group.args[0] if group else item.path.relative_to(ROOT).parts[1]
        return LONG_FIRST.index(name) if name in LONG_FIRST else len(LONG_FIRST)

    if not config.getoption("--budget"):  # else they come in the order asked for, the nearest first
        items.sort(key=rank)


@pytest.hookimpl(trylast=True)
def pytest_collection_finish(session: pytest.Session) -> None:
    """What was imported and collected stays: to look for garbage in it again and again takes a seventh of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def fixed_seeds() -> Iterator[None]:
    """The same random numbers for each test, in any order; floating point errors raise.

    Except underflow: the square of a tiny number may be zero.
    """
    random.seed(0)
    np.random.seed(0)  # noqa: NPY002 - for libraries that still draw from the global generator
    with np.errstate(all="raise", under="ignore"):
        yield


@pytest.fixture(scope="session", autouse=True)
def facts_remembered() -> Iterator[None]:
    """Steps are measured once, not for every loaded show; only where tests with graphs were collected."""
    if "live.graph.motion_graph" not in sys.modules:
        yield
        return
    from tests.fixtures.remembered import facts_remembered

    with facts_remembered():
        yield


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared test data beside the repository; skips where it is absent."""
    if not SHARED.is_dir():
        pytest.skip("the shared test data is not beside the repository")
    return SHARED
