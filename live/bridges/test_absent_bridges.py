"""Without any one of the bridges the command line works, and a show plays to its end, with the bridge's tables too."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from live.app.bridges import GROUP, UNREAD, installed_bridges
from live.show.patch.patch_search_path import DEFAULT_PATCH
from tests.fixtures.mostly_long import mostly_long

FOLDER = Path(__file__).parent
NAMES = sorted(path.parent.name for path in FOLDER.glob("*/__init__.py"))
COMMANDS = {
    "help": ["--help"],
    "play help": ["play", "--help"],
    "play": ["play", "PATCH", "--alone", "--headless", "--osc", "127.0.0.1:0", "--bpm", "120", "--seconds", "0.2"],
}
SCRIPT = f"""
import json, os, pathlib, sys, tempfile
import live.bridges
from live.app import headless_loop, session  # all that is heavy, once

early = [name for name in sys.modules if name.startswith("{GROUP}.")]
assert not early, f"the program itself imports {{early}}"
folder, every, commands, patches = json.loads(sys.argv[1])


def exit_code(words):
    sys.argv = ["live", *words]
    try:
        from live.cli.main import main
        main()
    except SystemExit as end:
        return end.code or 0
    except BaseException as error:
        print(repr(error))
        return 1
    return 0


results = {{}}
for name, patch in patches.items():
    others = pathlib.Path(tempfile.mkdtemp())
    for other in set(every) - {{name}}:
        os.symlink(pathlib.Path(folder, other), others / other)
    child = os.fork()
    if not child:
        live.bridges.__path__[:] = [str(others)]
        told = {{}}
        for title, words in commands.items():
            descriptor = os.open(others / "out.txt", os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
            os.dup2(descriptor, 1)
            os.dup2(descriptor, 2)
            code = exit_code([patch if word == "PATCH" else word for word in words])
            sys.stdout.flush()
            told[title] = [code, (others / "out.txt").read_text()]
        (others / "told.json").write_text(json.dumps(told))
        os._exit(0)
    os.waitpid(child, 0)
    results[name] = json.loads((others / "told.json").read_text())
print(json.dumps(results))
"""
"""Loads the program once, and forks a process for each bridge, in which the bridge's folder is not there."""


def tables_of(name):
    """The tables of a bridge in a patch, as nobody but the bridge could read them."""
    (bridge,) = (each for each in installed_bridges().bridges if each.name == name)
    fields = () if bridge.patch_tables is None else bridge.patch_tables().model_fields
    return "".join(f"\n[[{field}]]\nunknown_to_all = true\n" for field in fields)


@pytest.fixture(scope="module")
def results(request, tmp_path_factory):
    """By absent bridge and command, the exit code and what was printed, for the bridges that are asked for."""
    patches = {}
    for name in sorted({item.callspec.params["name"] for item in request.session.items if item.path == request.path}):
        path = tmp_path_factory.mktemp(name) / "show.toml"
        path.write_text(DEFAULT_PATCH.read_text(encoding="utf-8") + tables_of(name), encoding="utf-8")
        patches[name] = str(path)
    asked = json.dumps([str(FOLDER), NAMES, COMMANDS, patches])
    done = subprocess.run([sys.executable, "-c", SCRIPT, asked], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@mostly_long("name", NAMES, quick=[2])
def test_program_works_without_this_bridge(results, name):
    for code, printed in results[name].values():
        assert code == 0, printed
    (bridge,) = (each for each in installed_bridges().bridges if each.name == name)
    for option in bridge.options.__dataclass_fields__:
        assert f"--{option.replace('_', '-')} " not in results[name]["play help"][1]
    assert results[name]["play"][1].count(UNREAD) == tables_of(name).count("[[")
