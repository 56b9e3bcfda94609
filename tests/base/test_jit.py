"""The door to numba: names of the cache, counts, and that wrong arrays are refused rather than compiled anew."""

import os
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
