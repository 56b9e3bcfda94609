"""Real recordings for tests: ../shared/mocap beside the repository; tests that need them skip where it is absent."""

import json
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from live.motion.formats.bvh_reader import BvhMotion, bvh_to_source_motion, parse_bvh
from live.motion.formats.source_motion import SourceMotion
from tests.places import SHARED

MOCAP = SHARED / "mocap"


def mocap_file(name: str) -> Path:
    """Path of a recording, e.g. "salsa/60_01.bvh"; skips the test if it is not there."""
    path = MOCAP / name
    if not path.is_file():
        pytest.skip(f"needs the recording {path}")
    return path


def mocap_text(name: str) -> str:
    """Text of a recording as it is on disk (line ends kept)."""
    return mocap_file(name).read_bytes().decode("utf-8")


@cache
def _parsed(name: str) -> BvhMotion:
    return parse_bvh(mocap_text(name), name)


def mocap_bvh(name: str) -> BvhMotion:
    """A BVH file as it is written, parsed once per test run."""
    mocap_file(name)
    return _parsed(name)


@cache
def mocap_motion(name: str) -> SourceMotion:
    """The motion of a BVH file."""
    return bvh_to_source_motion(mocap_bvh(name))


def mocap_index() -> list[dict[str, Any]]:
    """What is known about the BVH recordings; empty where they are absent."""
    path = MOCAP / "index.json"
    if not path.is_file():
        return []
    return [row for row in json.loads(path.read_text()) if row["file"].endswith(".bvh")]
