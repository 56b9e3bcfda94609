# ruff: noqa
# mypy: ignore-errors
"""Every module of live/ goes to the room that modules.json says; those that will be merged keep a name of their own
there until then. Needs libcst. Usage: move.py ROOT, a clean checkout."""

import sys, re, json, pathlib, subprocess, collections

HERE = pathlib.Path(__file__).parent
PLAN = json.loads((HERE / "modules.json").read_text())
NEW, ROOM_WORDS = PLAN["modules"], PLAN["rooms"]


def CUR(root):
    found = {
        str(p.relative_to(root)).removesuffix(".py").replace("/", ".")
        for p in pathlib.Path(root).rglob("*.py")
        if p.name != "__init__.py"
    }
    return found - {"__main__"}


import libcst as cst
from libcst.metadata import MetadataWrapper, ScopeProvider

root = pathlib.Path(sys.argv[1])
live = root / "live"
cur = CUR(live)
mods = {}
taken = set()
for new, olds in NEW.items():
    if len(olds) == 1:
        mods[olds[0]] = new
        taken.add(new)
for new, olds in NEW.items():
    if len(olds) > 1:
        room = new.rpartition(".")[0]
        for old in olds:
            parts = old.split(".")
            base = parts[-1]
            if base == "kernels":
                base = parts[-2] + "_kernels"
            name = (room + "." if room else "") + base
            if name in taken or name in NEW and old not in NEW[name]:
                base = parts[-2] + "_" + base
                name = (room + "." if room else "") + base
            assert name not in taken, (old, name)
            mods[old] = name
            taken.add(name)
assert set(mods) == cur, set(mods) ^ cur
rooms = {m.rpartition(".")[0] for m in mods.values()}
clash = {m for m in mods.values()} & rooms
assert not clash, clash
FULL = {"live." + o: "live." + n for o, n in mods.items()}
# packages: for strings that name a package ('live.render' resources) nothing changes unless the package goes
oldpk = {o.rpartition(".")[0] for o in FULL}
pattern = re.compile(r"(?<![\w./])live(?:\.\w+)+")


def renamed(match):
    words = match.group(0).split(".")
    for n in range(len(words), 1, -1):
        head = ".".join(words[:n])
        if head in FULL:
            return ".".join([FULL[head], *words[n:]])
    return match.group(0)


path_pattern = re.compile(r"(?<![\w])live(?:/\w+)+\.py")


def renamed_path(match):
    m = match.group(0)[:-3].replace("/", ".")
    return FULL[m].replace(".", "/") + ".py" if m in FULL else match.group(0)


# packages whose __init__ hands on names of its modules
HANDED = {}
for init in live.rglob("__init__.py"):
    pk = "live." + str(init.parent.relative_to(live)).replace("/", ".")
    import ast

    for node in ast.parse(init.read_text()).body:
        if isinstance(node, ast.ImportFrom):
            for al in node.names:
                HANDED[f"{pk}.{al.name}"] = node.module
print(HANDED)


class Fix(cst.CSTTransformer):
    METADATA_DEPENDENCIES = (ScopeProvider,)

    def __init__(self):
        self.rename = {}
        self.notes = []

    def leave_ImportFrom(self, node, new):
        if new.module is None or isinstance(new.names, cst.ImportStar):
            return new
        mod = cst.Module([]).code_for_node(new.module)
        if not mod.startswith("live"):
            return new
        keep, out, handed = [], [], []
        for alias in new.names:
            full = f"{mod}.{alias.name.value}"
            if full in FULL:
                out.append((alias, FULL[full]))
            elif full in HANDED:
                handed.append((alias, FULL[HANDED[full]]))
            else:
                keep.append(alias)
        if not out and not handed:
            return new
        made = [
            cst.ImportFrom(
                module=cst.parse_expression("live" + t[4:]), names=[a.with_changes(comma=cst.MaybeSentinel.DEFAULT)]
            )
            for a, t in handed
        ]
        for alias, target in out:
            pkg, _, base = target.rpartition(".")
            asname = alias.asname
            old_local = alias.name.value
            if asname is None and base != old_local:
                asname = cst.AsName(cst.Name(old_local))
                self.notes.append((target, old_local))
            if asname is not None and asname.name.value == base:
                asname = None
            made.append(
                cst.ImportFrom(
                    module=cst.parse_expression("live" + pkg[4:]),
                    names=[cst.ImportAlias(cst.Name(base), asname=asname)],
                )
            )
        if keep:
            keep[-1] = keep[-1].with_changes(comma=cst.MaybeSentinel.DEFAULT)
            made.insert(0, new.with_changes(names=keep))
        return cst.FlattenSentinel(made)


def python(path):
    text = path.read_text()
    if re.search(r"from live[.\w]* import", text):
        tree = cst.parse_module(text)
        fix = Fix()
        done = MetadataWrapper(tree).visit(fix).code
        if done != text:
            text = done
        for note in fix.notes:
            print("as", path.relative_to(root), *note)
    return text


def git(*a):
    subprocess.run(["git", "-C", str(root), *a], check=True)


files = [
    pathlib.Path(root, f)
    for f in subprocess.run(["git", "-C", str(root), "ls-files"], capture_output=True, text=True).stdout.split("\n")
    if f
]
SKIP = {"CHANGELOG.md", "uv.lock", "LICENSE"}
for path in files:
    if (
        path.suffix not in {".py", ".md", ".toml", ".sh", ".cfg", ".yml", ".html", ".ts", ".js", ""}
        and path.name != "Makefile"
        or path.name in SKIP
    ):
        continue
    try:
        text = path.read_text()
    except UnicodeDecodeError:
        continue
    if "live" not in text:
        continue
    done = python(path) if path.suffix == ".py" else text
    done = pattern.sub(renamed, done)
    done = path_pattern.sub(renamed_path, done).replace("live", "live")
    if done != text:
        path.write_text(done)
for old, new in FULL.items():
    a, b = (root / (x.replace(".", "/") + ".py") for x in (old, new))
    if a == b:
        continue
    b.parent.mkdir(parents=True, exist_ok=True)
    git("mv", str(a), str(b))
inits = {}
for room in sorted({".".join(r.split(".")[: n + 1]) for r in rooms for n in range(r.count(".") + 1)}):
    init = live / room.replace(".", "/") / "__init__.py"
    if not init.exists():
        init.write_text(f'"""{(ROOM_WORDS.get(room) or room).capitalize()}."""\n')
        git("add", str(init))
# folders that hold nothing but __init__
for folder in sorted(
    (p for p in live.rglob("*") if p.is_dir() and p.name != "__pycache__"), key=lambda p: -len(p.parts)
):
    left = [p for p in folder.iterdir() if p.name != "__pycache__"]
    if [p.name for p in left] == ["__init__.py"]:
        git("rm", "-q", "-f", str(left[0]))
    elif left and not (folder / "__init__.py").exists() and any(p.suffix == ".py" for p in left):
        print("no init", folder)
(HERE / "moved.json").write_text(json.dumps(FULL, indent=1))
print(len(FULL), "moved")
