"""The studio's sources: types, their own tests, and the built page, which is in the repository byte by byte."""

import shutil
import subprocess
from pathlib import Path

import pytest

STUDIO = Path(__file__).resolve().parents[3] / "studio"
needs_node = pytest.mark.skipif(
    shutil.which("node") is None or not (STUDIO / "node_modules" / "esbuild").is_dir(),
    reason="needs Node and the packages of studio/ (make test installs them where npm is)",
)


def node(*command: str) -> None:
    done = subprocess.run(command, cwd=STUDIO, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.long
@needs_node
def test_types() -> None:
    node("node_modules/.bin/tsc", "--noEmit")


@needs_node
def test_built_page_is_that_of_the_sources() -> None:
    node("node", "build.mjs", "--check")


@needs_node
def test_own_tests() -> None:
    node("node", "build.mjs", "--tests")
    tests = sorted(str(file.relative_to(STUDIO)) for file in (STUDIO / "out").glob("*.test.js"))
    assert tests
    node("node", "--test", *tests)
