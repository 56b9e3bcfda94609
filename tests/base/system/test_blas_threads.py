"""Linear algebra in one thread, unless the user says otherwise."""

import os

import pytest

from live.base.system.blas_threads import VARIABLES, use_one_blas_thread


def test_one_thread_unless_user_says_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in VARIABLES:
        monkeypatch.setenv(name, "3")  # restored after the test
        monkeypatch.delenv(name)
    monkeypatch.setenv(VARIABLES[0], "3")
    use_one_blas_thread()
    assert [os.environ[name] for name in VARIABLES] == ["3", "1", "1", "1"]
