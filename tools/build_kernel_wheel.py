"""Build the companion wheel `choreographics-live-kernels` for this Python and platform into dist/.

It holds the compiled kernels for each level of processors that this machine has, so that a first show starts in
seconds. It pins what the code depends on: the version of this program, numba, the minor version of Python. What does
not match is ignored by `live.base.jit`, and kernels are compiled.
"""

import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from live import __version__  # noqa: E402
from live.base import jit  # noqa: E402
from live.base.disk.kernel_store import SHIPPED_PACKAGE, KernelStore, processor_levels  # noqa: E402

PROJECT: Final = """
[project]
name = "choreographics-live-kernels"
version = "{version}"
description = "Compiled kernels of ChoreoGraphics Live."
license = "GPL-3.0-or-later"
requires-python = "=={python}.*"
dependencies = ["choreographics-live=={version}", "numba=={numba}", "llvmlite=={llvmlite}"]

[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"

[tool.hatch.build.targets.wheel]
packages = ["{package}"]

[tool.hatch.build.hooks.custom]
"""
HOOK: Final = """
from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PlatformTag(BuildHookInterface):
    def initialize(self, version, build_data):
        build_data["pure_python"] = False
        build_data["tag"] = "{tag}"
"""


def compile_set(level: str, folder: Path) -> Path:
    """Compile all kernels for a level of processors into `folder`; return the folder of the set."""
    environment = {**os.environ, "LIVE_KERNEL_TARGET": level, "LIVE_CACHE_DIR": str(folder), "PYTHONPATH": str(ROOT)}
    subprocess.run([sys.executable, "-m", "live", "warm"], env=environment, check=True)
    made = folder / "kernels" / jit.set_name(level)
    if not KernelStore((made,)).is_complete():
        raise SystemExit(f"{made}: not complete")
    return made


def main() -> None:
    """Build the wheel; print its path."""
    levels = processor_levels(jit.host_processor()[2])
    if not levels:
        raise SystemExit("kernels are shipped for no level of this processor")
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    tag = "-".join(
        (*[f"cp{python.replace('.', '')}"] * 2, sysconfig.get_platform().replace("-", "_").replace(".", "_"))
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        package = folder / SHIPPED_PACKAGE
        package.mkdir()
        (package / "__init__.py").write_text('"""Compiled kernels of ChoreoGraphics Live, a folder for each set."""\n')
        for level in levels:
            made = compile_set(level, folder / level)
            shutil.copytree(made, package / made.name, ignore=shutil.ignore_patterns("locks", ".*"))
        (folder / "pyproject.toml").write_text(
            PROJECT.format(
                version=__version__,
                python=python,
                package=SHIPPED_PACKAGE,
                numba=version("numba"),
                llvmlite=version("llvmlite"),
            )
        )
        (folder / "hatch_build.py").write_text(HOOK.format(tag=tag))
        uv = ROOT / ".venv" / "bin" / "uv"
        subprocess.run([str(uv), "build", "--wheel", "--out-dir", str(ROOT / "dist"), str(folder)], check=True)


if __name__ == "__main__":
    main()
