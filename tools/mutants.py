"""Do the tests of this tree find the faults that an earlier commit's tests found: seeded mutants of both.

    .venv/bin/python tools/mutants.py COMMIT [--count 200] [--seed 1] [--folder out/mutants] [--jobs 2]

A mutant is one changed operator, comparison or number in one function. Functions are drawn from those that both trees
have in the same shape, whatever their names and files are now, so that both get the same fault. Each tree runs those
of its own tests that import the changed module. Kernels are left out: each change of them compiles for a minute.
Prints a line for each mutant; exit 1 if the earlier tests kill one that these let live.
"""

import argparse
import ast
import hashlib
import os
import random
import shutil
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
LIMIT_S = 180.0
"""Time limit of a mutant's tests [s]; a mutant that does not end is killed."""
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt,
    ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
    ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
}  # fmt: skip
Function = ast.FunctionDef | ast.AsyncFunctionDef


class Place(NamedTuple):
    """One function of a tree: its file, and its number among the file's functions."""

    path: Path
    number: int


def functions(tree: ast.Module) -> list[Function]:
    """All functions of a module, in a fixed order."""
    return [node for node in ast.walk(tree) if isinstance(node, Function)]


def shape_of(function: Function) -> str:
    """What stays when names and texts are changed: the kinds of a function's nodes, and its numbers."""
    words = []
    for node in ast.walk(function):
        constant = isinstance(node, ast.Constant) and not isinstance(node.value, str)
        words.append(f"{type(node).__name__}{node.value!r}" if constant else type(node).__name__)  # type: ignore[attr-defined]
    return hashlib.sha256(" ".join(words).encode()).hexdigest()


def shapes(root: Path) -> dict[str, list[Place]]:
    """The functions of `root`/live by shape, kernels left out."""
    found: dict[str, list[Place]] = {}
    for path in sorted((root / "live").rglob("*.py")):
        if path.stem.endswith("kernels"):
            continue
        for number, function in enumerate(functions(ast.parse(path.read_text(encoding="utf-8")))):
            found.setdefault(shape_of(function), []).append(Place(path.relative_to(root), number))
    return found


def points(function: Function) -> Iterator[tuple[ast.AST, str, int]]:
    """What can be changed in a function: a node, its field and, in a list, the index."""
    for node in ast.walk(function):
        if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in SWAPS:
            yield node, "op", -1
        elif isinstance(node, ast.Compare):
            yield from ((node, "ops", k) for k, op in enumerate(node.ops) if type(op) in SWAPS)
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float, bool):
            yield node, "value", -1


def mutate(root: Path, place: Place, point: int) -> str:
    """Change the file in `root`; return what it was."""
    path = root / place.path
    text = path.read_text(encoding="utf-8")
    module = ast.parse(text)
    node, field, index = list(points(functions(module)[place.number]))[point]
    old = getattr(node, field)
    if index >= 0:
        old[index] = SWAPS[type(old[index])]()
    elif field == "value":
        node.value = not old if isinstance(old, bool) else old + 1  # type: ignore[attr-defined]
    else:
        node.op = SWAPS[type(old)]()  # type: ignore[attr-defined]
    path.write_text(ast.unparse(module), encoding="utf-8")
    return text


def tests_of(root: Path, module: Path) -> list[str]:
    """The tests that import the module itself; if there is none, those of the folder that mirrors its own."""
    name = module.with_suffix("").as_posix().replace("/", ".")
    parent, _, stem = name.rpartition(".")
    found = []
    for path in sorted((root / "tests").rglob("test_*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (
                node.module == name or (node.module == parent and any(each.name == stem for each in node.names))
            ):
                found.append(path.relative_to(root).as_posix())
                break
    folder = Path("tests", *module.parent.parts[1:])
    while not found and folder.parts and not (root / folder).is_dir():
        folder = folder.parent
    return found or [folder.as_posix()]


def is_killed(root: Path, place: Place, point: int) -> bool:
    """Whether the tree's tests notice the mutant."""
    tests = tests_of(root, place.path)
    original = mutate(root, place, point)
    command = [sys.executable, "-m", "pytest", "-o", "addopts=", "-q", "-x", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, "-m", "not soak and not long", *tests],
            cwd=root,
            env={**os.environ, "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"},
            capture_output=True,
            timeout=LIMIT_S,
            check=False,
        )
        return done.returncode not in (0, 5)
    except subprocess.TimeoutExpired:
        return True
    finally:
        (root / place.path).write_text(original, encoding="utf-8")


def main() -> int:
    """Draw the mutants, test them in both trees, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", help="the earlier commit")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=ROOT / "out" / "mutants", help="copies of both trees")
    wanted = parser.parse_args()
    pairs: SimpleQueue[tuple[Path, Path]] = SimpleQueue()
    for job in range(wanted.jobs):
        pair = tuple(wanted.folder.resolve() / f"{name}{job}" for name in ("before", "after"))
        for tree, commit in zip(pair, (wanted.commit, "HEAD"), strict=True):
            shutil.rmtree(tree, ignore_errors=True)
            tree.mkdir(parents=True)
            archive = subprocess.run(["git", "archive", commit], cwd=ROOT, capture_output=True, check=True)
            subprocess.run(["tar", "-x", "-C", str(tree)], input=archive.stdout, check=True)
        before, after = pair
        pairs.put((before, after))
    known = shapes(before), shapes(after)
    both = sorted(shape for shape in known[0] if len(known[0][shape]) == len(known[1].get(shape, ())) == 1)
    places = [(known[0][shape][0], known[1][shape][0]) for shape in both]
    choices = [
        (old, new, point)
        for old, new in places
        for point in range(len(list(points(functions(ast.parse((after / new.path).read_text()))[new.number]))))
    ]
    print(f"{len(both)} functions of the same shape, {len(choices)} possible mutants", flush=True)

    def judge(choice: tuple[Place, Place, int]) -> tuple[bool, bool]:
        old, new, point = choice
        pair = pairs.get()
        killed = is_killed(pair[0], old, point), is_killed(pair[1], new, point)
        pairs.put(pair)
        words = " / ".join("killed" if each else "lives " for each in killed)
        print(f"{words}  {new.path} function {new.number} point {point} (was {old.path})", flush=True)
        return killed

    drawn = random.Random(wanted.seed).sample(choices, min(wanted.count, len(choices)))
    with ThreadPoolExecutor(wanted.jobs) as pool:
        judged = list(pool.map(judge, drawn))
    lost = sum(old and not new for old, new in judged)
    print(
        f"killed before {sum(old for old, _ in judged)}, now {sum(new for _, new in judged)} of {len(judged)}", end=""
    )
    print(f"; {lost} that were killed live now")
    return int(lost > 0)


if __name__ == "__main__":
    raise SystemExit(main())
