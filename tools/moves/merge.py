# ruff: noqa
# mypy: ignore-errors
"""Merges modules: those of today that modules.json gives one new name become one file, in the order of their imports.

Usage: merge.py ROOT [NEW ...]; a group whose names clash is told and left alone, unless RENAMES says what to do.
"""

import ast, builtins, collections, json, pathlib, re, subprocess, symtable, sys, textwrap

HERE = pathlib.Path(__file__).parent
root = pathlib.Path(sys.argv[1]).resolve()
wanted = set(sys.argv[2:])
PLAN = json.loads((HERE / "modules.json").read_text())["modules"]
MOVED = json.loads((HERE / "moved.json").read_text())
RENAMES = json.loads((HERE / "renames.json").read_text()) if (HERE / "renames.json").exists() else {}


def path_of(module):
    return root / (module.replace(".", "/") + ".py")


def top_names(tree):
    """Names bound at the top: {name: statement or ('import', target)}."""
    found = {}

    def bind(node):
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            found[node.name] = node
        elif isinstance(node, ast.Assign):
            for target in node.targets:
                for each in ast.walk(target):
                    if isinstance(each, ast.Name):
                        found[each.id] = node
        elif isinstance(node, (ast.AnnAssign, ast.AugAssign)):
            if isinstance(node.target, ast.Name):
                found[node.target.id] = node
        elif isinstance(node, ast.TypeAlias if hasattr(ast, "TypeAlias") else ()):
            found[node.name.id] = node
        elif isinstance(node, ast.Import):
            for alias in node.names:
                found[alias.asname or alias.name.partition(".")[0]] = (
                    "import",
                    alias.name if alias.asname else alias.name.partition(".")[0],
                )
        elif isinstance(node, ast.ImportFrom):
            for alias in node.names:
                found[alias.asname or alias.name] = ("import", f"{node.module}.{alias.name}")
        elif isinstance(node, (ast.If, ast.Try, ast.With, ast.For, ast.While)):
            for each in ast.iter_child_nodes(node):
                if isinstance(each, ast.stmt):
                    bind(each)
                elif isinstance(each, ast.ExceptHandler):
                    for inner in each.body:
                        bind(inner)
            if isinstance(node, ast.For):
                for each in ast.walk(node.target):
                    if isinstance(each, ast.Name):
                        found[each.id] = node

    for node in tree.body:
        bind(node)
    return found


def global_uses(text, name):
    """Names used in a module that are bound nowhere in it: builtins."""
    found = set()

    def walk(table):
        for symbol in table.get_symbols():
            if (
                symbol.is_global()
                and symbol.is_referenced()
                or (
                    table.get_type() == "module"
                    and symbol.is_referenced()
                    and not symbol.is_assigned()
                    and not symbol.is_imported()
                )
            ):
                found.add(symbol.get_name())
        for child in table.get_children():
            walk(child)

    walk(symtable.symtable(text, name, "exec"))
    return found


class Part:
    def __init__(self, module):
        self.module, self.path = module, path_of(module)
        self.text = self.path.read_text()
        self.tree = ast.parse(self.text)
        self.names = top_names(self.tree)
        self.doc = ast.get_docstring(self.tree, clean=False) or ""
        self.base = module.rpartition(".")[2]


def is_typing_block(node):
    return isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"


def offsets(text):
    starts = [0]
    for line in text.split("\n"):
        starts.append(starts[-1] + len(line.encode()) + 1)
    return starts


def edit(text, changes):
    """Replace byte ranges [(begin, end, new)]."""
    data = text.encode()
    for begin, end, new in sorted(changes, reverse=True):
        data = data[:begin] + new.encode() + data[end:]
    return data.decode()


def rename_names(text, mapping):
    """Names (not attributes, not keywords of calls) of a module that are global, renamed."""
    tree = ast.parse(text)
    starts = offsets(text)
    changes = []
    local = set()

    class Walk(ast.NodeVisitor):
        def __init__(self):
            self.scopes = []

        def shadowed(self, name):
            return any(name in scope for scope in self.scopes)

        def function(self, node):
            arguments = node.args
            bound = {
                a.arg
                for a in [
                    *arguments.args,
                    *arguments.kwonlyargs,
                    *arguments.posonlyargs,
                    *([arguments.vararg] if arguments.vararg else []),
                    *([arguments.kwarg] if arguments.kwarg else []),
                ]
            }
            body = node.body if isinstance(node.body, list) else []
            hidden = set()
            for statement in body:
                for each in ast.walk(statement):
                    if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store):
                        bound.add(each.id)
                    if isinstance(each, ast.Global):
                        hidden.update(each.names)
            bound -= hidden
            for each in [
                *arguments.defaults,
                *[d for d in arguments.kw_defaults if d],
                *getattr(node, "decorator_list", []),
            ]:
                self.visit(each)
            for a in [
                *arguments.args,
                *arguments.kwonlyargs,
                *arguments.posonlyargs,
                *([arguments.vararg] if arguments.vararg else []),
                *([arguments.kwarg] if arguments.kwarg else []),
            ]:
                if a.annotation:
                    self.visit(a.annotation)
            if getattr(node, "returns", None):
                self.visit(node.returns)
            self.scopes.append(bound)
            for each in body or [node.body]:
                self.visit(each)
            self.scopes.pop()

        def visit_FunctionDef(self, node):
            self.name_of_def(node)
            self.function(node)

        visit_AsyncFunctionDef = visit_FunctionDef

        def visit_Lambda(self, node):
            self.function(node)

        def name_of_def(self, node):
            if not self.scopes and not getattr(self, "in_class", 0) and node.name in mapping:
                line = text.split("\n")[node.lineno - 1]
                at = line.index(node.name, node.col_offset)
                begin = starts[node.lineno - 1] + len(line[:at].encode())
                changes.append((begin, begin + len(node.name.encode()), mapping[node.name]))

        def visit_ClassDef(self, node):
            self.name_of_def(node)
            for each in [*node.bases, *node.keywords, *node.decorator_list]:
                self.visit(each)
            self.in_class = getattr(self, "in_class", 0) + 1
            for each in node.body:
                self.visit(each)
            self.in_class -= 1

        def visit_Global(self, node):
            if set(node.names) & set(mapping):
                line = text.split("\n")[node.lineno - 1]
                new = re.sub(r"\w+", lambda m: mapping.get(m.group(0), m.group(0)), line)
                changes.append((starts[node.lineno - 1], starts[node.lineno - 1] + len(line.encode()), new))

        def visit_Name(self, node):
            if node.id in mapping and not self.shadowed(node.id):
                begin = starts[node.lineno - 1] + node.col_offset
                changes.append((begin, begin + len(node.id.encode()), mapping[node.id]))

        def visit_Constant(self, node):
            # annotations in quotes
            if isinstance(node.value, str) and node.value.isidentifier() and node.value in mapping:
                begin = starts[node.lineno - 1] + node.col_offset
                changes.append((begin + 1, begin + 1 + len(node.value), mapping[node.value]))

    Walk().visit(tree)
    return edit(text, changes)


def replace_module_attributes(text, local, target, renamed={}):
    """`local.name` becomes `target.name` (or `name`, if target is empty), where `local` is a module that was imported."""
    tree = ast.parse(text)
    starts = offsets(text)
    changes = []
    for node in ast.walk(tree):
        if (
            isinstance(node, ast.Attribute)
            and isinstance(node.value, ast.Name)
            and node.value.id == local
            and not target
        ):
            begin = starts[node.value.lineno - 1] + node.value.col_offset
            end = starts[node.end_lineno - 1] + node.end_col_offset
            changes.append((begin, end, renamed.get(node.attr, node.attr)))
        elif isinstance(node, ast.Name) and node.id == local and target and isinstance(node.ctx, ast.Load):
            begin = starts[node.lineno - 1] + node.col_offset
            changes.append((begin, begin + len(local.encode()), target))
    return edit(text, changes)


def merge(new, olds):
    parts = [Part(old) for old in olds]
    group = {part.module for part in parts}
    rename = RENAMES.get(new, {})
    # what is renamed for a clash, module by module
    for part in parts:
        mapping = rename.get(part.base, {})
        if mapping:
            part.text = rename_names(part.text, mapping)
            part.tree = ast.parse(part.text)
            part.names = top_names(part.tree)
            part.renamed = mapping
        else:
            part.renamed = {}
    by_module = {part.module: part for part in parts}
    # inner imports
    needs = {part.module: set() for part in parts}
    for part in parts:
        aliases, modules = {}, {}
        for node in ast.walk(part.tree):
            if isinstance(node, ast.ImportFrom) and node.module:
                if node.module in group:
                    if node in part.tree.body:
                        needs[part.module].add(node.module)
                    for alias in node.names:
                        now = by_module[node.module].renamed.get(alias.name, alias.name)
                        if (alias.asname or alias.name) != now:
                            aliases[alias.asname or alias.name] = now
                else:
                    for alias in node.names:
                        full = f"{node.module}.{alias.name}"
                        if full in group:
                            if node in part.tree.body:
                                needs[part.module].add(full)
                            modules[alias.asname or alias.name] = full
        if aliases:
            part.text = rename_names(part.text, aliases)
        for local, full in modules.items():
            part.text = replace_module_attributes(part.text, local, "", by_module[full].renamed)
        part.tree = ast.parse(part.text)
        part.names = {
            name: where
            for name, where in top_names(part.tree).items()
            if not (isinstance(where, tuple) and (where[1] in group or where[1].rpartition(".")[0] in group))
        }
    # order
    order, left = [], list(parts)
    while left:
        ready = [part for part in left if not needs[part.module] - {p.module for p in order}]
        if not ready:
            return f"{new}: circle of imports"
        order.append(ready[0])
        left.remove(ready[0])
    # clashes
    clashes = []
    same, unwanted = set(), set()
    for at, part in enumerate(order):
        for other in order[at + 1 :]:
            for name in set(part.names) & set(other.names):
                a, b = part.names[name], other.names[name]
                if isinstance(a, tuple) and isinstance(b, tuple) and name != "ControlEvent":
                    if a != b:
                        clashes.append(f"{name} ({part.base}: {a[1]}, {other.base}: {b[1]})")
                elif not isinstance(a, tuple) and not isinstance(b, tuple) and ast.unparse(a) == ast.unparse(b):
                    same.add((other.base, name))
                elif name in ("Float64", "Float32") and isinstance(a, tuple) != isinstance(b, tuple):
                    unwanted.add(
                        ((part if isinstance(a, tuple) else other).base, name)
                    )  # an alias that is defined here
                elif name == "ControlEvent":
                    unwanted.add((part.base if a[1].endswith("events.events.ControlEvent") else other.base, name))
                elif name != "main" or True:
                    clashes.append(f"{name} ({part.base}, {other.base})")
    bindings = {name: part for part in order for name in part.names}
    for part in order:
        for name in global_uses(part.text, part.base) - set(part.names):
            if name in bindings and hasattr(builtins, name):
                clashes.append(f"builtin {name} in {part.base} is {bindings[name].base}'s")
    if clashes:
        return f"{new}: " + "; ".join(clashes)
    # text
    imports, typing, bodies = [], [], []
    for part in order:
        lines = part.text.split("\n")
        drop = set()
        tail = None
        for node in part.tree.body:
            rows = range(node.lineno, node.end_lineno + 1)
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                drop.update(rows)
                if isinstance(node, ast.ImportFrom) and node.module in group:
                    continue
                if isinstance(node, ast.ImportFrom):
                    keep = [
                        a
                        for a in node.names
                        if f"{node.module}.{a.name}" not in group and (part.base, a.asname or a.name) not in unwanted
                    ]
                    if not keep:
                        continue
                    node.names = keep
                comment = re.search(r"  #.*$", lines[node.end_lineno - 1])
                imports.append(ast.unparse(node) + (comment.group(0) if comment else ""))
            elif (
                is_typing_block(node)
                and all(isinstance(s, (ast.Import, ast.ImportFrom)) for s in node.body)
                and not node.orelse
            ):
                drop.update(rows)
                for each in node.body:
                    if isinstance(each, ast.ImportFrom) and each.module in group:
                        continue
                    typing.append(ast.unparse(each))
            elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and node is part.tree.body[0]:
                drop.update(rows)
            elif isinstance(node, ast.If) and ast.unparse(node.test) == "__name__ == '__main__'":
                drop.update(rows)
                tail = "\n".join(lines[node.lineno - 1 : node.end_lineno])
            elif any((part.base, name) in same for name in top_names(ast.Module([node], []))):
                drop.update(rows)
                following = part.tree.body[part.tree.body.index(node) + 1 :][:1]
                if following and isinstance(following[0], ast.Expr) and isinstance(following[0].value, ast.Constant):
                    drop.update(range(following[0].lineno, following[0].end_lineno + 1))
        # imports of the group inside functions
        for node in ast.walk(part.tree):
            if isinstance(node, ast.ImportFrom) and node not in part.tree.body and node.lineno not in drop:
                if node.module in group or all(f"{node.module}.{a.name}" in group for a in node.names):
                    drop.update(range(node.lineno, node.end_lineno + 1))
        kept = "\n".join(line for number, line in enumerate(lines, start=1) if number not in drop)
        bodies.append((part, kept.strip("\n"), tail))
    main = parts[0]
    docs = [re.sub(r"\n {4}", "\n", part.doc).strip() for part in [main, *[p for p in order if p is not main]]]
    doc = "\n\n".join(docs)
    text = f'"""{doc}\n"""\n\n' if "\n" in doc else f'"""{doc}"""\n\n'
    future = [i for i in imports if i.startswith("from __future__")]
    text += "\n".join(dict.fromkeys(future + imports)) + "\n"
    if typing:
        text += "\nif TYPE_CHECKING:\n" + "\n".join(f"    {line}" for line in dict.fromkeys(typing)) + "\n"
    text += "\n\n" + "\n\n\n".join(body for _, body, _ in bodies if body) + "\n"
    tails = [tail for _, _, tail in bodies if tail]
    if len(tails) > 1:
        return f"{new}: two mains"
    if tails:
        text += "\n\n" + tails[0] + "\n"
    ast.parse(text)
    return parts, text


def main():
    groups = {}
    for new, olds in PLAN.items():
        here = [MOVED["live." + old] for old in olds]
        if here != ["live." + new] and (not wanted or new in wanted):
            if all(path_of(each).exists() for each in here):
                groups["live." + new] = here
    replaced, told = {}, {}  # old module -> new; old name -> new name
    files = [
        p
        for p in (
            root / f
            for f in subprocess.run(["git", "-C", str(root), "ls-files"], capture_output=True, text=True).stdout.split(
                "\n"
            )
            if f
        )
        if p.is_file()
    ]
    for new, olds in groups.items():
        try:
            done = merge(new, olds)
        except Exception as error:
            print("FAIL", new, repr(error))
            continue
        if isinstance(done, str):
            print("clash", done)
            continue
        parts, text = done
        target = path_of(new)
        biggest = max(parts, key=lambda part: len(part.text)).path
        here = next((part.path for part in parts if part.path == target), biggest)
        if here != target:
            if target.exists():
                print("taken", new)
                continue
            subprocess.run(["git", "-C", str(root), "mv", str(here), str(target)], check=True)
        target.write_text(text)
        for part in parts:
            replaced[part.module] = new
            for was, now in part.renamed.items():
                told[f"{part.module}.{was}"] = f"{new}.{now}"
            if part.path not in (here, target):
                subprocess.run(["git", "-C", str(root), "rm", "-q", "-f", str(part.path)], check=True)
    # importers
    pattern = re.compile(r"(?<![\w./])live(?:\.\w+)+")
    paths = re.compile(r"(?<![\w])live(?:/\w+)+\.py")

    def dotted(match):
        words = match.group(0).split(".")
        for n in range(len(words), 1, -1):
            head = ".".join(words[:n])
            if n < len(words) and ".".join(words[: n + 1]) in told:
                return ".".join([told[".".join(words[: n + 1])], *words[n + 1 :]])
            if head in replaced:
                return ".".join([replaced[head], *words[n:]])
        return match.group(0)

    def slashed(match):
        module = match.group(0)[:-3].replace("/", ".")
        return replaced[module].replace(".", "/") + ".py" if module in replaced else match.group(0)

    for path in files:
        if (
            not path.exists()
            or path.suffix not in {".py", ".md", ".toml", ".sh", ".yml", ""}
            or "tools/moves" in str(path)
            or path.name in ("CHANGELOG.md", "uv.lock", "LICENSE")
        ):
            continue
        try:
            text = was = path.read_text()
        except UnicodeDecodeError:
            continue
        if "live" not in text:
            continue
        if path.suffix == ".py":
            text = importer(text, replaced, told, path)
        text = paths.sub(slashed, pattern.sub(dotted, text)).replace("liveNEW", "live")
        if text != was:
            path.write_text(text)
    for target in set(replaced.values()):
        path = path_of(target)
        text = path.read_text()
        text = paths.sub(slashed, pattern.sub(dotted, importer(text, replaced, told, path))).replace("liveNEW", "live")
        path.write_text(text)
    print(len(groups), "groups", len(set(replaced.values())), "merged", len(replaced), "files")
    (HERE / "merged.json").write_text(json.dumps(replaced, indent=1))


def importer(text, replaced, told, path):
    """`from live.x import module` and its uses; names that were renamed for a clash."""
    tree = ast.parse(text)
    starts = offsets(text)
    changes, uses, names = [], {}, {}
    for node in ast.walk(tree):
        if not isinstance(node, ast.ImportFrom) or not node.module or not node.module.startswith("live"):
            continue
        begin = starts[node.lineno - 1] + node.col_offset
        end = starts[node.end_lineno - 1] + node.end_col_offset
        indent = " " * node.col_offset
        keep, out = [], []
        for alias in node.names:
            full = f"{node.module}.{alias.name}"
            if full in replaced:
                pkg, _, base = replaced[full].rpartition(".")
                local = alias.asname or alias.name
                out.append(f"from liveNEW{pkg[4:]} import {base}")
                if local != base:
                    uses[local] = base
            elif full in told:
                pkg, _, base = told[full].rpartition(".")
                out.append(f"from liveNEW{pkg[4:]} import {base}" + (f" as {alias.asname}" if alias.asname else ""))
                if not alias.asname:
                    names[alias.name] = base
            else:
                keep.append(ast.unparse(ast.ImportFrom(node.module, [alias], 0)).partition(" import ")[2])
        if out:
            made = ([f"from {node.module} import {', '.join(keep)}"] if keep else []) + list(dict.fromkeys(out))
            changes.append((begin, end, f"\n{indent}".join(made)))
    text = edit(text, changes)
    if names:
        text = rename_names(text, names)
    for local, base in uses.items():
        bound = top_names(ast.parse(text))
        stored = {
            n.id for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)
        } | {a.arg for a in ast.walk(ast.parse(text)) if isinstance(a, ast.arg)}
        if base in stored or local in stored:
            print("shadow", path.relative_to(root), local, base)
        text = replace_module_attributes(text, local, base)
    return text


main()
