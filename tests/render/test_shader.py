"""Shader sources: includes, constants, and the version that macOS still speaks."""

import pytest

from live.render.shader import source


def test_includes_come_once_and_constants_follow_the_version() -> None:
    text = source("dancer_fragment.glsl", (("SOFT", 1),))
    lines = text.splitlines()
    assert lines[0] == "#version 410 core"
    assert lines[1] == "#define SOFT 1"
    assert text.count("uniform Frame") == 1
    assert "#include" not in text


def test_an_unknown_shader_is_an_error() -> None:
    with pytest.raises(FileNotFoundError):
        source("no_such_shader.glsl")
