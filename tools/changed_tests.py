"""The tests of what has changed since a commit, a file each line: `python tools/changed_tests.py [COMMIT]`.

The nearest come first: the rules of the tree, changed test files, the tests in the folders that mirror the changed
ones (a bridge's own folder holds its tests). They are the test files that changed themselves, and those that import a
module that changed, directly or through one other module of the same room. Where files change that are no modules
(patches, shaders, pages), the tests of the folder that mirrors theirs. COMMIT is HEAD by default: what is not
committed.
"""

import ast
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ALWAYS = ("tests/test_architecture.py", "tests/documentation/test_files.py")


def changed(commit: str) -> list[str]:
    """Files that differ from a commit, and those that git does not know yet."""
    commands = (["diff", "--name-only", "--diff-filter=d", commit], ["ls-files", "--others", "--exclude-standard"])
    told = [subprocess.run(["git", *each], cwd=ROOT, capture_output=True, text=True, check=True) for each in commands]
    return sorted({line for one in told for line in one.stdout.splitlines()})


def imports(path: Path) -> set[str]:
    """All modules that a file may import, at its top or inside its functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return found


def module_of(name: str) -> str:
    """live/show/show.py is live.show.show."""
    return name.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def tests_of(names: list[str]) -> set[str]:
    """The test files that belong to changed files."""
    modules = {module_of(name) for name in names if name.endswith(".py")}
    for name in [each for each in modules if each.startswith("live.")]:
        room = ROOT / Path(*name.split(".")[:-1])
        modules |= {module_of(path.relative_to(ROOT).as_posix()) for path in room.glob("*.py") if name in imports(path)}
    places = ROOT / "tests", ROOT / "live" / "bridges"
    tests = {path.relative_to(ROOT).as_posix(): path for place in places for path in place.rglob("test_*.py")}
    found = {name for name in names if name in tests} | {
        name for name, path in tests.items() if imports(path) & modules
    }
    rooms = {Path("tests", *Path(name).parent.parts[1:3]) for name in names if not name.endswith((".py", ".md"))}
    return found | {name for name in tests for room in rooms if len(room.parts) > 1 and Path(name).is_relative_to(room)}


def nearest_first(names: list[str]) -> list[str]:
    """Return the tests of changed files, the nearest first."""
    rooms = {Path(name).parent for name in names if name.startswith("live/")}
    mirrors = rooms | {Path("tests", *room.parts[1:]) for room in rooms}

    def distance(test: str) -> int:
        return 0 if test in ALWAYS else 1 if test in names else 2 if Path(test).parent in mirrors else 3

    return sorted({*ALWAYS, *tests_of(names)}, key=lambda test: (distance(test), test))


if __name__ == "__main__":
    print("\n".join(nearest_first(changed(sys.argv[1] if len(sys.argv) > 1 else "HEAD"))))
