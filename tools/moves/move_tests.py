# ruff: noqa
# mypy: ignore-errors
"""Tests follow the tree. usage: tests.py ROOT (after move.py)"""

import sys, re, pathlib, subprocess, collections, json, ast

root = pathlib.Path(sys.argv[1])
tests = root / "tests"
FULL = json.loads((pathlib.Path(__file__).parent / "moved.json").read_text())  # old -> new
NEWTO = {v: k for k, v in FULL.items()}
top = {"alive": "supervisor", "steps": "library", "cli": "app"}
KEEP = {"end_to_end", "training", "journals"}


def git(*a):
    subprocess.run(["git", "-C", str(root), *a], check=True)


def imports(path):
    found = collections.Counter()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("live"):
            if node.module in NEWTO:
                found[node.module] += len(node.names)
            for a in node.names:
                if f"{node.module}.{a.name}" in NEWTO:
                    found[f"{node.module}.{a.name}"] += 1
    return found


moves = {}
for path in sorted(tests.rglob("*.py")):
    rel = path.relative_to(tests)
    if len(rel.parts) == 1 or rel.parts[0] in KEEP or path.name in ("__init__.py", "conftest.py"):
        continue
    if not path.name.startswith("test_"):
        continue
    stem = path.stem[5:]
    folder = ".".join(rel.parts[:-1])
    room = None
    for old in (
        f"live.{folder}.{stem}",
        f"live.{folder}.{stem}.kernels" if stem != "kernels" else f"live.{folder}.kernels",
    ):
        if old in FULL:
            room = FULL[old].rpartition(".")[0]
            break
    if room is None:
        same = [n for o, n in FULL.items() if o.split(".")[1] == rel.parts[0] and o.split(".")[-1] == stem]
        if len(same) == 1:
            room = same[0].rpartition(".")[0]
    if room is None:
        votes = collections.Counter()
        for m, c in imports(path).items():
            votes[m.rpartition(".")[0]] += c * (3 if NEWTO[m].split(".")[1] == rel.parts[0] else 1)
        room = votes.most_common(1)[0][0] if votes else "live." + top.get(rel.parts[0], rel.parts[0])
    moves[path] = room
counts = collections.Counter(moves.values())
names = {}
modmap = {}
for path, room in moves.items():
    target = tests / "/".join(room.split(".")[1:])
    name = path.name
    while (target / name) in names:
        name = "test_" + path.parent.name + "_" + name[5:]
    names[target / name] = path
    a = "tests." + ".".join(path.relative_to(tests).with_suffix("").parts)
    b = "tests." + ".".join((target / name).relative_to(tests).with_suffix("").parts)
    modmap[a] = b
if __name__ == "__main__":
    big = [(str(r), c) for r, c in counts.items() if c > 20]
    print(len(moves), "tests", big)
    for target, path in names.items():
        if target == path:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        git("mv", str(path), str(target))
    print(json.dumps(modmap, indent=1))
