"""What a show imports until its first frame: nothing that takes long and that only later work needs."""

import ast
import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LATER = (
    *("scipy.interpolate", "scipy.optimize", "scipy.integrate", "scipy.spatial", "scipy.sparse", "scipy.ndimage"),
    *("scipy.cluster", "scipy.fft", "scipy.special", "svgpathtools", "svgwrite", "matplotlib", "aiohttp", "zeroconf"),
    *("cryptography", "pygltflib", "jax", "segno", "asyncio"),
)
"""Modules of which none is needed for a first frame."""
REPORT = "import gc, sys; print('imported', gc.get_stats()[0]['collections'], *sys.modules)"
MAX_COLLECTIONS = 100
"""Searches for reference cycles during a start: 700 with Python's own threshold."""


def imported(code: str) -> set[str]:
    """Return the names of all modules after this code has run in a process of its own, and the number of searches for
    reference cycles."""
    done = subprocess.run([sys.executable, "-c", f"{code}\n{REPORT}"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("imported ")]
    return set(line.split()[1:])


def too_early(modules: set[str], later: tuple[str, ...]) -> list[str]:
    return sorted(name for name in modules if any(name == one or name.startswith(f"{one}.") for one in later))


@pytest.mark.parametrize("name", LATER)
def test_listed_modules_are_spelt_as_they_are_imported(name):
    top = name.partition(".")[0]
    declared = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    assert f'"{top}' in declared or top == "svgwrite" or top in sys.stdlib_module_names
    if importlib.util.find_spec(top) is not None:
        assert importlib.util.find_spec(name) is not None


@pytest.mark.long
def test_film_imports_nothing_late_until_its_first_frame(tmp_path):
    command = ["live", "render", "--seconds", "0.02", "--size", "64x36", "--out", str(tmp_path / "first.mp4")]
    modules = imported(
        "import contextlib, sys\n"
        "from live.cli.main import main\n"
        f"sys.argv = {command!r}\n"
        "with contextlib.suppress(SystemExit):\n"
        "    main()\n"
    )
    assert (tmp_path / "first.mp4").exists()
    assert next(int(word) for word in modules if word.isdecimal()) < MAX_COLLECTIONS
    assert "live.render.renderer" in modules
    assert too_early(modules, LATER) == []


@pytest.mark.long
def test_headless_show_imports_nothing_late_until_its_first_frame():
    modules = imported(
        "from live.app import headless_loop, session, headless_picture\n"
        "from live.app.launch_options import LaunchOptions\n"
        "from live.app.session_audio import choose_audio\n"
        "options = LaunchOptions(headless=True, bpm=120.0)\n"
        "loaded = options.load()\n"
        "show = session.Session(options, loaded, choose_audio(options, loaded))\n"
        "show.engine.frame(lambda view: None)\n"
    )
    assert too_early(modules, LATER) == []


@pytest.mark.long
def test_sound_process_imports_neither_show_nor_renderer():
    modules = imported("import live.app.processes.audio_main")
    assert too_early(modules, (*LATER, "live.show.show", "live.agents", "live.graph", "live.render", "av")) == []


def test_supervisor_imports_neither_numba_nor_controls():
    modules = imported(
        "import live.cli.main\nimport live.app.processes.engine_main\nimport live.app.services.http_services"
    )
    later = (*LATER, "numpy", "numba", "live.control.registry", "live.control.events", "live.agents", "live.render")
    assert too_early(modules, later) == []


@pytest.mark.long
def test_osc_process_imports_neither_numba_nor_show():
    modules = imported("import live.app.processes.osc_reader_main")
    assert too_early(modules, (*LATER, "numba", "live.show.show", "live.agents", "live.graph", "live.render")) == []


def inner_imports(path: Path) -> set[str]:
    """Return the modules that the functions of a file import."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    inner = [node for outer in ast.walk(tree) if isinstance(outer, ast.FunctionDef) for node in ast.walk(outer)]
    found = {node.module for node in inner if isinstance(node, ast.ImportFrom) and node.module is not None}
    return found | {one.name for node in inner if isinstance(node, ast.Import) for one in node.names}


@pytest.mark.long
def test_slow_modules_that_frames_import_are_imported_before_by_a_thread():
    """In the packages that frames run in, an import within a function would stop one frame for its length."""
    offline = {"live/agents/goals/goals.py", "live/agents/formations/svg_import.py"}  # scenarios; reading of files
    background = ROOT / "live" / "show" / "background_work.py"
    found = set()
    for package in ("agents", "show", "graph/select", "graph/search", "motion/pose"):
        for path in (ROOT / "live" / package).rglob("*.py"):
            if path != background and str(path.relative_to(ROOT)) not in offline:
                found |= inner_imports(path)
    slow = {name for name in found if name.partition(".")[0] in ("scipy", "svgpathtools", "shapely")}
    assert slow == inner_imports(background)
