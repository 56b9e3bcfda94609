"""The numba wrapper: cache names, kernel counts, and refusal of wrong arrays without recompilation."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from live.base import jit
from live.base import scalar_kernels as kernels
from live.motion.pose.foot_lock_kernels import update_lock


def test_cache_name_depends_on_file_and_its_imports(tmp_path, monkeypatch):
    """An edit renames the cache folders of its importers only."""
    package = tmp_path / "live"
    texts = {
        "a/kernels.py": "from live.b.kernels import part_of\n",
        "b/kernels.py": "from live.c import NUMBER\n",
        "c.py": "from live.d import OTHER\nNUMBER = 1\n",
        "d.py": "OTHER = 1\n",
        "e/kernels.py": "import math\n",
    }
    for name, text in texts.items():
        (package / name).parent.mkdir(parents=True, exist_ok=True)
        (package / name).write_text(text)
    monkeypatch.setattr(jit, "_PACKAGE", package)

    def names() -> dict[str, str]:
        jit.cache_name.cache_clear()
        return {folder: jit.cache_name(package / folder / "kernels.py") for folder in "abe"}

    before = names()
    (package / "c.py").write_text("from live.d import OTHER\nNUMBER = 2\n")
    after = names()
    assert {folder for folder in "abe" if after[folder] != before[folder]} == {"a", "b"}
    (package / "e/kernels.py").write_text("import numpy\n")
    again = names()
    assert {folder for folder in "abe" if again[folder] != after[folder]} == {"e"}


def test_kernels_are_cached_in_the_folder_of_their_file():
    folder = jit.KERNEL_CACHE_DIR / jit.cache_name(Path(kernels.__file__).resolve())
    assert jit.JIT_DISABLED or list(folder.rglob("*.nbi"))


def test_a_kernel_outside_of_the_package_is_cached_by_its_own_name(tmp_path):
    """Those of a bench, for example."""
    file = tmp_path / "bench.py"
    file.write_text("")
    assert re.fullmatch(r"bench-[0-9a-f]{16}", jit.cache_name(file))


def test_every_kernel_file_is_counted():
    assert kernels.__file__ in [str(path) for path in jit.kernel_files()]
    assert jit.kernel_count() >= 20


@pytest.mark.skipif(jit.JIT_DISABLED, reason="plain Python functions take any array")
def test_wrong_array_raises_type_error_without_compilation():
    good, contact = np.zeros((1, 2, 8), np.float32), np.ones((1, 2), np.bool_)
    with pytest.raises(TypeError):
        update_lock(good, np.zeros((1, 9, 3)), contact, 0.1, 0.1, 0.01)


def test_unwritable_cache_does_not_prevent_start(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    environment = {**os.environ, "LIVE_CACHE_DIR": str(blocked), "TMPDIR": str(tmp_path), "NUMBA_DISABLE_JIT": "1"}
    code = "import live.base.jit; print(live.base.jit.KERNEL_CACHE_DIR)"
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert Path(result.stdout.strip()).parent == tmp_path


def test_kernels_import_their_sources_by_full_name():
    """`sources_of` reads ``from live.… import …`` at the beginning of a line: other import forms are not allowed."""
    for path in jit.kernel_files():
        text = path.read_text(encoding="utf-8")
        for line in re.findall(r"^.*\blive[.\w]*.*\bimport\b.*$|^.*\bimport\b.*\blive\b.*$", text, re.MULTILINE):
            assert re.match(r"from live\.[\w.]+ import", line), f"{path}: {line}"
        for module in re.findall(r"^from (live\.[\w.]+) import", text, re.MULTILINE):
            source = Path(jit.__file__).parents[2].joinpath(*module.split(".")).with_suffix(".py")
            assert source in jit.sources_of(path), f"{path}: {module} is a package or missing"
