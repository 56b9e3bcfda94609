"""Check that the locked dependencies have wheels for every system and Python, and hold all that `live` imports.

`python tools/check_wheels.py` downloads the wheels of uv.lock for Windows (x86-64) and macOS (arm64) and looks into
them: nothing of them is run. It needs a network, uv, some minutes, and about 1 GB of the temporary folder.
"""

import ast
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
PLATFORMS: Final = {"windows": "Windows x86-64", "aarch64-apple-darwin": "macOS 14 arm64"}
PYTHONS: Final = ("3.11", "3.12", "3.13", "3.14")
EXTRAS: Final = ("cluster", "link", "fast", "nodes", "usd")
OLDEST_MACOS: Final = "14.0"
"""The oldest macOS for which all of them, PyAV first, have wheels."""
GUARDED: Final = {"choreographics_live_kernels", "jax", "mir_eval", "optax", "soundfile", "pymotion", "pybvh", "pyrvo"}
"""Packages of other extras, or looked for before they are imported."""


def imported(tree: ast.Module) -> Iterator[str]:
    """Yield the modules that a file imports when it runs: not those for types, nor what an except clause replaces."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            waiting += node.orelse
        elif isinstance(node, ast.Try) and any(
            "ImportError" in ast.unparse(one.type or ast.Pass()) for one in node.handlers
        ):
            waiting += node.finalbody
        elif isinstance(node, ast.Import):
            yield from (one.name for one in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module
        else:
            waiting += ast.iter_child_nodes(node)


def needed() -> dict[str, str]:
    """Return the modules of other packages that `live` imports, with a file that does."""
    found = {}
    for path in sorted((ROOT / "live").rglob("*.py")):
        if not path.name.startswith("test_"):
            for name in imported(ast.parse(path.read_text(encoding="utf-8"))):
                top = name.partition(".")[0]
                if top != "live" and top not in sys.stdlib_module_names and top not in GUARDED:
                    found[name] = path.relative_to(ROOT).as_posix()
    return found


def holds(folder: Path, module: str) -> bool:
    """Whether unpacked wheels hold a module: a package, a file of Python, or an extension."""
    place = folder.joinpath(*module.split("."))
    return place.is_dir() or any(place.parent.glob(f"{place.name}.py")) or any(
        place.parent.glob(f"{place.name}.*{ending}") for ending in ("so", "pyd")
    )  # fmt: skip


def check(platform: str, python: str, requirements: Path, modules: dict[str, str]) -> list[str]:
    """Return what is wrong on one system with one Python."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            ["uv", "pip", "install", "--quiet", "--target", folder, "--python-platform", platform, "--python-version",
             python, "--only-binary", ":all:", "--no-deps", "--requirements", str(requirements)],
            env={**os.environ, "MACOSX_DEPLOYMENT_TARGET": OLDEST_MACOS}, capture_output=True, text=True, check=False,
        )  # fmt: skip
        if done.returncode:
            return [done.stderr.strip()]
        return [f"{where} imports {name}" for name, where in modules.items() if not holds(Path(folder), name)]


def main() -> None:
    """Check all of them; exit 1 if anything is missing."""
    wrong = False
    with tempfile.NamedTemporaryFile("w+", suffix=".txt") as file:
        extras = [word for extra in EXTRAS for word in ("--extra", extra)]
        export = ["uv", "export", "--quiet", "--frozen", "--no-dev", "--no-emit-project", *extras]
        subprocess.run(export, cwd=ROOT, stdout=file, check=True)
        modules = needed()
        for python in PYTHONS:
            for platform, name in PLATFORMS.items():
                missing = check(platform, python, Path(file.name), modules)
                wrong |= bool(missing)
                print(
                    f"{name}, Python {python}: {len(modules)} modules, {'; '.join(missing) or 'all there'}", flush=True
                )
    sys.exit(wrong)


if __name__ == "__main__":
    main()
