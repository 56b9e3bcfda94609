"""Worked examples of CONTRIBUTING.md as changes that are made in memory: a process in which the files are changed.

A block of an example names its file in its first line, or `new` and the file. Its other lines begin with a space (they
are there already), with + (they are added) or with - (they go).
"""

import re
import subprocess
import sys
from pathlib import Path
from typing import Final

from tests.places import ROOT

_BLOCK: Final = re.compile(r"```diff\n(new )?(\S+)\n(.*?)```", re.DOTALL)
_RUN: Final = """
import importlib.abc, importlib.util, json, sys
from pathlib import Path

folder = Path(sys.argv[1])
changed = json.loads((folder / "changed.json").read_text())

class Changed(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    def find_spec(self, name, path=None, target=None):
        for place in (name.replace(".", "/") + ".py", name.replace(".", "/") + "/__init__.py"):
            if place in changed:
                whole = place.endswith("__init__.py")
                return importlib.util.spec_from_loader(name, self, origin=place, is_package=whole)
        return None
    def exec_module(self, module):
        place = module.__spec__.origin
        exec(compile(changed[place], str(Path.cwd() / place), "exec"), module.__dict__)

sys.meta_path.insert(0, Changed())
if (folder / "live/bridges").is_dir():
    import live.bridges
    live.bridges.__path__.append(str(folder / "live/bridges"))
if (folder / "shaders").is_dir():
    from live.render.shader import set_override_folder
    set_override_folder(folder / "shaders")
exec((folder / "checks.py").read_text(), {})
import pytest
options = ["-q", "-p", "no:cacheprovider", "--rootdir", str(folder), "-c", str(folder / "pytest.ini")]
sys.exit(pytest.main([*options, *json.loads((folder / "plugins.json").read_text()), str(folder / "tests")]))
"""


def read_example(text: str, title: str) -> dict[str, str]:
    """Return the whole texts of the files that an example changes or adds, by their places.

    Raises AssertionError if the lines that should be there are not, or are there twice.
    """
    section = text.partition(f"### {title}")[2].partition("\n### ")[0].partition("\n## ")[0]
    files: dict[str, str] = {}
    for new, place, lines in _BLOCK.findall(section):
        rows = lines.splitlines()
        added = "".join(row[1:] + "\n" for row in rows if not row.startswith("-"))
        if new:
            files[place] = added
            continue
        there = "".join(row[1:] + "\n" for row in rows if not row.startswith("+"))
        before = files.get(place) or (ROOT / place).read_text(encoding="utf-8")
        assert before.count(there) == 1, f"{place}: {before.count(there)} times:\n{there}"
        files[place] = before.replace(there, added)
    return files


def run_example(
    files: dict[str, str], folder: Path, *, checks: str = "", plugins: tuple[str, ...] = (), jit: bool = True
) -> str:
    """Run the example's tests, after the statements `checks`, in a process in which the files are changed.

    Without `jit` kernels run as Python. Raises AssertionError with the output if anything fails; returns it otherwise.
    """
    import json
    import os

    (folder / "tests").mkdir()
    for place, text in files.items():
        name = Path(place).name
        if name.startswith("test_"):
            (folder / "tests" / name).write_text(text, encoding="utf-8")
        elif place.endswith(".glsl"):
            (folder / "shaders").mkdir(exist_ok=True)
            (folder / "shaders" / name).write_text(text, encoding="utf-8")
        elif place.startswith("live/bridges"):
            (folder / place).parent.mkdir(parents=True, exist_ok=True)
            (folder / place).write_text(text, encoding="utf-8")
    modules = {place: text for place, text in files.items() if place.endswith(".py")}
    (folder / "changed.json").write_text(json.dumps(modules), encoding="utf-8")
    (folder / "checks.py").write_text(checks, encoding="utf-8")
    (folder / "plugins.json").write_text(json.dumps([word for one in plugins for word in ("-p", one)]))
    (folder / "pytest.ini").write_text("[pytest]\nmarkers =\n    gl: needs OpenGL\n")
    done = subprocess.run(
        [sys.executable, "-c", _RUN, str(folder)],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(ROOT)} | ({} if jit else {"NUMBA_DISABLE_JIT": "1"}),
        capture_output=True,
        text=True,
        check=False,
        timeout=240,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
