"""The door to numba: names of the cache, counts, and that wrong arrays are refused rather than compiled anew."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from live.base import jit, kernels
from live.motion.legs.kernels import follow_feet


def test_the_cache_is_named_after_the_sources(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path))
    before = jit.cache_directory()
    assert before.parent == tmp_path
    changed = tmp_path / "kernels.py"
    changed.write_text("# another kernel")
    monkeypatch.setattr(jit, "kernel_files", lambda: [changed])
    assert jit.cache_directory() != before


def test_every_kernel_file_is_counted():
    assert kernels.__file__ in [str(path) for path in jit.kernel_files()]
    assert jit.kernel_count() >= 20


@pytest.mark.skipif(jit.JIT_DISABLED, reason="plain Python functions take any array")
def test_a_wrong_array_is_a_type_error_and_compiles_nothing():
    good, contact = np.zeros((1, 2, 8), np.float32), np.ones((1, 2), np.bool_)
    with pytest.raises(TypeError):
        follow_feet(good, np.zeros((1, 9, 3)), contact, 0.1, 0.1, 0.01)


def test_a_cache_that_cannot_be_written_does_not_stop_the_start(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    environment = {**os.environ, "LIVE_CACHE_DIR": str(blocked), "TMPDIR": str(tmp_path), "NUMBA_DISABLE_JIT": "1"}
    code = "import os, live.base.jit; print(os.environ['NUMBA_CACHE_DIR'])"
    result = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert Path(result.stdout.strip()).parent == tmp_path


def test_whatever_kernels_take_from_other_files_is_part_of_the_caches_name():
    package = Path(jit.__file__).resolve().parent.parent
    named = {package / name for name in jit.CONSTANTS}
    for path in [*jit.kernel_files(), *named]:
        for module in re.findall(r"^from (live\.[\w.]+) import", path.read_text(encoding="utf-8"), re.MULTILINE):
            source = package.parent / (module.replace(".", "/") + ".py")
            if source.is_file() and source.name not in ("kernels.py", "jit.py", "errors.py"):
                assert source in named, f"{path} takes numbers from {source}: name it in live.base.jit.CONSTANTS"
