"""The rules of ARCHITECTURE.md that code can check: layers, names, docstrings, one import of numba."""

import ast
import graphlib
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

from tests.fixtures.source_trees import no_collection, parse
from tests.places import ROOT

SITE = ROOT / "live" / "site"
"""The documentation, if it has been built."""
MODULES = sorted(path for path in (ROOT / "live").rglob("*.py") if not path.is_relative_to(SITE))


def _identify(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.fixture(scope="module", autouse=True)
def trees_of_this_file_only() -> Iterator[None]:
    """The trees are more than a million objects: they are forgotten before the tests of other files run."""
    with no_collection():
        yield
        for known in (_tree, _nodes, _imports, _modules_imported, _import_graph):
            known.cache_clear()


_tree = cache(parse)


@cache
def _nodes(path: Path) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(_tree(path)))


@cache
def _imports(path: Path) -> frozenset[str]:
    """Top-level names of all imports of a file, at module level and inside functions."""
    found: set[str] = set()
    for node in _nodes(path):
        if isinstance(node, ast.Import):
            found.update(alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None and node.level == 0:
            found.add(node.module.partition(".")[0])
    return frozenset(found)


def test_layers_import_only_lower_layers() -> None:
    lint = shutil.which("lint-imports", path=str(Path(sys.executable).parent))
    if lint is None:
        pytest.skip("import-linter is not installed (it comes with `make test`)")
    done = subprocess.run([lint, "--no-cache"], cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout


def test_modules_have_no_import_cycles() -> None:
    grimp = pytest.importorskip("grimp", reason="grimp is not installed (it comes with `make test`)")
    graph = grimp.build_graph("live", cache_dir=None)
    imports = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    graphlib.TopologicalSorter(imports).prepare()  # raises CycleError, which names them


def test_top_packages_are_the_listed_ones() -> None:
    packages = {
        path.name for path in (ROOT / "live").iterdir() if path.is_dir() and path != SITE and any(path.rglob("*.py"))
    }
    assert packages == {
        "agents",
        "app",
        "base",
        "bridges",
        "cli",
        "clock",
        "control",
        "document",
        "graph",
        "library",
        "motion",
        "nodes",
        "rehearse",
        "render",
        "show",
        "supervisor",
    }
    without = [path for path in packages if not (ROOT / "live" / path / "__init__.py").exists()]
    assert without == []


def _folders() -> list[Path]:
    """All folders of live/ and tests/ with content that git tracks."""
    folders = [path for part in ("live", "tests") for path in (ROOT / part, *(ROOT / part).rglob("*")) if path.is_dir()]
    ours = (path for path in folders if "__pycache__" not in path.parts and not path.is_relative_to(SITE))
    return [path for path in ours if any(path.glob("*.*"))]


def test_folders_are_small_and_not_deep() -> None:
    """At most 25 entries, at most three names below live/, and no package of one module."""
    entries = {
        path: [each for each in path.iterdir() if each not in (path / "__pycache__", SITE)] for path in _folders()
    }
    assert {_identify(path): len(each) for path, each in entries.items() if len(each) > 25} == {}
    assert [_identify(path) for path in MODULES if len(path.relative_to(ROOT / "live").parts) > 3] == []
    assert [
        _identify(path)
        for path, each in entries.items()
        if path.is_relative_to(ROOT / "live") and len({one.name for one in each} - {"__init__.py", "README.md"}) < 2
    ] == []


def test_every_module_has_a_docstring() -> None:
    assert MODULES
    assert [_identify(path) for path in MODULES if not ast.get_docstring(_tree(path))] == []


def test_no_module_has_a_catch_all_name() -> None:
    forbidden = {"util", "utils", "helpers", "misc", "common", "manager"}
    assert [
        _identify(path) for path in MODULES if {part.lower() for part in (path.stem, path.parent.name)} & forbidden
    ] == []


def test_only_jit_module_imports_numba() -> None:
    users = [_identify(path) for path in MODULES if _imports(path) & {"numba", "llvmlite"}]
    assert users == ["live/base/jit.py"]


def test_kernels_are_defined_in_kernels_files_only() -> None:
    outside = [
        _identify(path)
        for path in MODULES
        if not path.stem.endswith("kernels")
        and path.name != "jit.py"
        and re.search(r"^from live\.base\.jit import (.*\W)?(inline_)?kernel\b", path.read_text("utf-8"), re.MULTILINE)
    ]
    assert outside == []


def test_kernels_import_only_numpy_math_and_lower_kernels() -> None:
    for path in (ROOT / "live").rglob("*kernels.py"):
        assert _imports(path) <= {"math", "numpy", "typing", "live"}, _identify(path)


def test_core_imports_neither_disk_nor_clock_modules() -> None:
    core = [path for path in MODULES if path.relative_to(ROOT).parts[1] in ("agents", "graph", "motion")]
    assert core
    for path in core:
        assert not _imports(path) & {"time", "datetime", "random", "subprocess", "tempfile"}, _identify(path)


def test_random_generators_are_seeded() -> None:
    seedless = {"seed", "rand", "randn", "random", "normal", "uniform", "choice", "shuffle"}
    for path in MODULES:
        for node in _nodes(path):
            if isinstance(node, ast.Attribute) and node.attr in seedless:
                assert ast.unparse(node.value) not in ("np.random", "numpy.random"), f"{_identify(path)}:{node.lineno}"
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("random.default_rng"):
                assert node.args or node.keywords, f"{_identify(path)}:{node.lineno}: default_rng() without a seed"


_CODE_FROM_BYTES = {"pickle", "_pickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "copyreg", "code"}
"""Modules that make code or objects from bytes."""
_CALLS = {"eval", "exec", "compile", "__import__"}
_BY_NAME = {"import_module", "load_module", "exec_module", "find_class", "resolve_name"}
_OWN_NAMES = {
    "live/app/bridges.py",
    "live/cli/bench.py",
    "live/app/processes/warm_standby.py",
    "live/app/machine/kernel_build.py",
    "live/app/machine/kernel_loader.py",
    "live/library/motion_formats.py",
}
"""Files that import by names from the program itself, or from the command line of a benchmark."""


def _makes_code(node: ast.Call, path: str) -> bool:
    """Whether a call can make code or objects from its arguments."""
    called, name = ast.unparse(node.func), node.func.attr if isinstance(node.func, ast.Attribute) else ""
    pickles = [word.value for word in node.keywords if word.arg == "allow_pickle"]
    arrays = called in ("np.load", "numpy.load") and not pickles
    unpickles = any(not (isinstance(value, ast.Constant) and value.value is False) for value in pickles)
    by_name = name in _BY_NAME and path not in _OWN_NAMES
    return called in _CALLS or by_name or arrays or unpickles or called.endswith("yaml.load")


def test_no_module_unpickles_evaluates_or_imports_bytes() -> None:
    """Files and sockets contain data only: no function that makes code or objects from bytes is used."""
    assert [_identify(path) for path in MODULES if _imports(path) & _CODE_FROM_BYTES] == []
    calls = ((path, node) for path in MODULES for node in _nodes(path) if isinstance(node, ast.Call))
    found = [
        f"{_identify(path)}:{node.lineno}: {ast.unparse(node)[:80]}"
        for path, node in calls
        if _makes_code(node, _identify(path))
    ]
    assert found == []


def _module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def _known_modules() -> frozenset[str]:
    return frozenset(_module_name(path) for path in MODULES)


@cache
def _modules_imported(path: Path, *, lazy: bool) -> frozenset[str]:
    """Modules of live/ that a file imports at module level; with `lazy` inside functions, too.

    Imports in `if TYPE_CHECKING:` do not count, because they are never executed.
    """
    known, found = _known_modules(), set[str]()
    waiting: list[ast.AST] = [_tree(path)]
    while waiting:
        for node in ast.iter_child_nodes(waiting.pop()):
            if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
                continue
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) and not lazy:
                continue
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                names = [f"{node.module}.{alias.name}" for alias in node.names]
                found |= {name if name in known else node.module for name in names}
            elif isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            if not isinstance(node, ast.expr):
                waiting.append(node)
    return frozenset(found & known - {_module_name(path)})


@cache
def _import_graph(*, lazy: bool) -> dict[str, frozenset[str]]:
    return {_module_name(path): _modules_imported(path, lazy=lazy) for path in MODULES}


def _longest_chain(imports: dict[str, frozenset[str]], start: str) -> list[str]:
    """Return the longest chain of modules from `start` on, each of which imports the next one."""

    @cache
    def chain(module: str) -> tuple[str, ...]:
        return (module, *max((chain(each) for each in sorted(imports[module])), key=len, default=()))

    return list(chain(start))


@pytest.mark.parametrize(
    ("start", "lazy", "limit"),
    [
        ("live.app.window_loop", False, 25),  # the process that runs a live show
        ("live.cli.play", True, 35),  # `live play`, with what it imports only when it needs it
        ("live.show.assembly", False, 17),
        ("live.show.show", True, 7),
    ],
)
def test_chains_of_imports_are_short(start: str, lazy: bool, limit: int) -> None:
    chain = _longest_chain(_import_graph(lazy=lazy), start)
    assert len(chain) <= limit, " > ".join(chain)


@pytest.mark.parametrize("start", ["live.show.show", "live.show.frame"])
def test_show_and_frame_know_only_values_and_interfaces(start: str) -> None:
    """All that the show itself imports, directly or through others; `assembly.py` is the place that knows all parts."""
    imports, reached, waiting = _import_graph(lazy=True), {start}, [start]
    while waiting:
        new = imports[waiting.pop()] - reached
        reached |= new
        waiting += new
    assert len(reached) <= 40, sorted(reached)
    assert not {module for module in reached if module.startswith(("live.agents", "live.graph", "live.motion"))}


def test_frame_is_read_in_one_file() -> None:
    assert len((ROOT / "live/show/frame.py").read_text(encoding="utf-8").splitlines()) < 150
