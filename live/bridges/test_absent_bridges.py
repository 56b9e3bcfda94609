"""Without any one of the bridges the command line works and a show plays to its end."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent
NAMES = sorted(path.parent.name for path in FOLDER.glob("*/__init__.py"))
COMMANDS = {
    "help": ["--help"],
    "play help": ["play", "--help"],
    "play": ["play", "--alone", "--headless", "--osc", "127.0.0.1:0", "--seconds", "0.3"],
}
SCRIPT = """
import json, os, pathlib, sys, tempfile
import live.bridges
from live.app import headless_loop, session  # all that is heavy, once

early = [name for name in sys.modules if name.startswith("live.bridges.")]
assert not early, f"imported by the program itself: {early}"
folder, commands, names = json.loads(sys.argv[1])
results = {}
for name in names:
    others = tempfile.mkdtemp()
    for other in names:
        if other != name:
            os.symlink(pathlib.Path(folder, other), pathlib.Path(others, other))
    for title, words in commands.items():
        out = pathlib.Path(others, "out.txt")
        child = os.fork()
        if not child:
            descriptor = os.open(out, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
            os.dup2(descriptor, 1), os.dup2(descriptor, 2)
            live.bridges.__path__[:] = [others]
            sys.argv = ["live", *words]
            code = 1
            try:
                from live.app.bridges import installed_bridges
                assert name not in [bridge.name for bridge in installed_bridges().bridges]
                assert set(installed_bridges().left_out) <= {name}, installed_bridges().left_out
                from live.cli.main import main
                main()
                code = 0
            except SystemExit as end:
                code = end.code or 0
            except BaseException as error:
                print(repr(error))
            sys.stdout.flush()
            os._exit(code)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        results[f"{name}: {title}"] = [code, out.read_text()]
print(json.dumps(results))
"""
"""Forks a process for each command, in which one bridge's folder is not there."""


@pytest.fixture(scope="module")
def results():
    """By bridge and command, the exit code and what was printed."""
    asked = json.dumps([str(FOLDER), COMMANDS, NAMES])
    done = subprocess.run([sys.executable, "-c", SCRIPT, asked], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("name", NAMES)
def test_program_works_without_this_bridge(results, name, command):
    code, printed = results[f"{name}: {command}"]
    assert code == 0, printed
