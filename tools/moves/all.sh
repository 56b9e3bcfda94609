# Usage: all.sh, in a clean checkout, with a Python that has libcst in $PY.
set -e
 sed -i 's#^build/#/build/#; s#^dist/#/dist/#' .gitignore; $PY "$(dirname "$0")/move.py" .
sed -i 's/rglob("kernels.py")/rglob("*kernels.py")/; s/if file.name == "kernels.py":/if file.stem.endswith("kernels"):/' live/base/jit.py
python3 - <<'P'
p='live/base/jit.py'; s=open(p).read()
s=s.replace('return f"{path.parent.name}-{digest','name = ".".join(path.relative_to(_PACKAGE).with_suffix("").parts)\n    return f"{name}-{digest')
open(p,'w').write(s)
P
sed -i 's/-name kernels.py/-name "*kernels.py"/g' tools/setup.sh
.venv/bin/ruff check . -q --fix >/dev/null; .venv/bin/ruff format -q .
python3 - <<'P'
p='pyproject.toml'; s=open(p).read()
s=s.replace('''  "cli",
  "rehearse",
  "alive",
  "show",
  "steps",
''','''  "cli",
  "app",
  "rehearse",
  "supervisor",
  "show",
  "library",
''')
s=s.replace('"live.steps", "live.show", "live.alive", "live.rehearse", "live.cli"','"live.library", "live.show", "live.supervisor", "live.rehearse", "live.app", "live.cli"')
open(p,'w').write(s)
p='tests/test_architecture.py'; s=open(p).read()
s=s.replace('        "alive",\n','        "app",\n').replace('        "steps",\n','        "supervisor",\n').replace('        "graph",\n','        "graph",\n        "library",\n')
s=s.replace('path.name not in ("kernels.py", "jit.py")','not path.stem.endswith("kernels")\n        and path.name != "jit.py"').replace('rglob("kernels.py")','rglob("*kernels.py")')
open(p,'w').write(s)
P
