# ruff: noqa
# mypy: ignore-errors
"""Tests ask tests.places where things are, so that they can move. usage: places.py ROOT"""

import sys, re, pathlib

root = pathlib.Path(sys.argv[1])
tests = root / "tests"
(
    tests / "places.py"
).write_text('''"""Where tests find what is no Python: the checkout, and the folder of shared data beside it, which may be absent."""

from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
"""The checkout."""
SHARED: Final = ROOT.parent / "shared"
"""Recordings, songs and papers; tests that need them skip where they are not there."""
''')
pat = re.compile(r"Path\(__file__\)(?:\.resolve\(\))?\.(?:parents\[(\d)\]|((?:parent\.?)+))(?=[\s)/.\]]|$)", re.M)
for path in sorted(tests.rglob("*.py")):
    rel = path.relative_to(tests)
    if path.name == "places.py" or rel.parts == ("conftest.py",):
        continue
    text = path.read_text()
    used = set()
    depth = len(rel.parts)  # parents[depth] = ROOT.parent ; parents[depth-1] = tests...

    def sub(m):
        n = int(m.group(1)) if m.group(1) else m.group(2).count("parent") - 1
        # parents[0] is the folder of the file
        up = n - (depth - 1)  # 0: tests, 1: root, 2: above
        if up == 1:
            used.add("ROOT")
            return "ROOT"
        if up == 2:
            used.add("ROOT")
            return "ROOT.parent"
        if up == 0:
            used.add("ROOT")
            return 'ROOT / "tests"'
        return m.group(0)

    done = pat.sub(sub, text)
    if not used:
        continue
    done = done.replace('ROOT.parent / "shared"', "SHARED").replace('(ROOT / "tests") /', 'ROOT / "tests" /')
    if re.search(r"^ROOT(: Final)? = ROOT$", done, re.M):
        done = re.sub(r"^ROOT(: Final)? = ROOT\n", "", done, flags=re.M)
    if re.search(r"^SHARED(: Final)? = SHARED$", done, re.M):
        done = re.sub(r"^SHARED(: Final)? = SHARED\n", "", done, flags=re.M)
    names = [n for n in ("ROOT", "SHARED") if re.search(rf"\b{n}\b", done)]
    line = f"from tests.places import {', '.join(names)}\n"
    m = list(re.finditer(r"^(?:from|import) .*?(?:\n(?=\S)|\Z)", done, re.M | re.S))
    tree = __import__("ast").parse(done)
    last = [x for x in tree.body if isinstance(x, (__import__("ast").Import, __import__("ast").ImportFrom))]
    rows = done.split("\n")
    at = last[-1].end_lineno if last else (tree.body[0].end_lineno if tree.body else 0)
    rows.insert(at, line.rstrip())
    path.write_text("\n".join(rows))
    print(rel, names)
