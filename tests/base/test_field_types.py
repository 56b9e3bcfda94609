"""Plain values become the fields of a dataclass, or are refused with the field's name."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pytest

from live.base.field_types import build_dataclass


@dataclass(frozen=True)
class Point:
    x: float
    z: float = 0.0


@dataclass(frozen=True)
class Row:
    name: str
    count: int = 0
    on: bool = False
    size: tuple[int, int] = (1, 2)
    many: tuple[tuple[str, float], ...] = ()
    path: Path | None = None
    side: Literal["left", "right"] = "left"
    secret: bytes = b""
    at: Point | None = None


def test_values_are_converted_by_their_annotations():
    values = {"name": "a", "size": [3, 4], "many": [["b", 1]], "path": "x/y", "side": "right", "at": {"x": 1}}
    assert build_dataclass(Row, values) == Row(
        "a", 0, False, (3, 4), (("b", 1.0),), Path("x/y"), "right", b"", Point(1.0)
    )


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("name", 1),
        ("name", None),
        ("count", 1.0),
        ("count", True),
        ("on", 1),
        ("size", [1]),
        ("size", [1, 2, 3]),
        ("size", "12"),
        ("many", [["b"]]),
        ("many", [["b", "c"]]),
        ("path", 3),
        ("side", "up"),
        ("secret", "text"),
        ("at", {"y": 1.0}),
        ("at", {"z": 1.0}),
        ("at", [1.0]),
        ("__class__", "x"),
    ],
)
def test_value_of_another_type_is_refused_with_field_name(name, value):
    with pytest.raises(ValueError, match=f"{name}|Point"):
        build_dataclass(Row, {"name": "a"} | {name: value})


def test_missing_field_is_refused_with_its_name():
    with pytest.raises(ValueError, match="name"):
        build_dataclass(Row, {})
