"""All modules can be imported where a system has no more than Windows has."""

import subprocess
import sys

import pytest

from tests.base.system.foreign_system import foreign_environment

IMPORT_ALL = """
import importlib, pkgutil, live
for module in pkgutil.walk_packages(live.__path__, "live."):
    if ".test_" not in module.name and module.name != "live.__main__":
        importlib.import_module(module.name)
"""
AS_THE_PROGRAM = """
import os, fcntl
exec({!r}, {{"__name__": "live.x"}})
"""


def run_foreign(program):
    return subprocess.run(
        [sys.executable, "-c", program], env=foreign_environment(), capture_output=True, text=True, timeout=300
    )


@pytest.mark.long
def test_every_module_can_be_imported_on_a_system_like_windows():
    done = run_foreign(IMPORT_ALL)
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.parametrize(("source", "lacks"), [("import os; os.fork", "fork"), ("import fcntl", "module fcntl")])
def test_what_is_hidden_is_hidden_from_the_program_alone(source, lacks):
    assert run_foreign(AS_THE_PROGRAM.format(source)).stderr.strip().endswith(f"Error: this system has no {lacks}")
