"""JsonPlace: one object of a glTF file's JSON that knows where it stands, so that every complaint names the place."""

import math
from collections.abc import Iterator
from typing import Any

from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError, shown


class JsonPlace:
    """Typed access to one JSON object; whatever is missing or of another kind is a MotionFileError."""

    def __init__(self, value: Any, where: str, file: str) -> None:
        self.where, self.file = where, file
        if not isinstance(value, dict):
            raise self.error("", f"is {_kind(value)}", "an object expected")
        self._value: dict[str, Any] = value

    def error(self, key: str, problem: str, expected: str) -> MotionFileError:
        """A complaint about `key` of this object (about the object itself if it is empty)."""
        place = ".".join(part for part in (self.where, key) if part) or "the file"
        return MotionFileError(self.file, None, f"{place} {problem}", expected)

    def has(self, key: str) -> bool:
        """Whether the object has this key."""
        return key in self._value

    def names(self) -> list[str]:
        """All keys in the order of the file."""
        return list(self._value)

    def text(self, key: str, default: str = "") -> str:
        """A text; what is no text counts as not given (names are only for people)."""
        value = self._value.get(key, default)
        return value if isinstance(value, str) else default

    def object(self, key: str) -> "JsonPlace":
        """The object under `key`."""
        if key not in self._value:
            raise self.error(key, "is missing", "an object expected")
        return JsonPlace(self._value[key], ".".join(part for part in (self.where, key) if part), self.file)

    def length(self, key: str) -> int:
        """Number of elements of the array under `key`; 0 where there is none."""
        value = self._value.get(key, [])
        if not isinstance(value, list):
            raise self.error(key, f"is {_kind(value)}", "an array expected")
        return len(value)

    def element(self, key: str, index: int) -> "JsonPlace":
        """One object of an array of objects."""
        count = self.length(key)
        if not 0 <= index < count:
            raise self.error(key, f"has {count} elements and no number {index}", "a file whose references fit expected")
        place = f"{self.where}.{key}" if self.where else key
        return JsonPlace(self._value[key][index], f"{place}[{index}]", self.file)

    def elements(self, key: str) -> "Iterator[JsonPlace]":
        """All objects of an array of objects, none where there is no such array."""
        for index in range(self.length(key)):
            yield self.element(key, index)

    def whole(self, key: str, default: int | None = None, *, below: int) -> int:
        """A whole number of at least 0 and less than `below`."""
        value = self._value.get(key, default)
        if value is None:
            raise self.error(key, "is missing", "a whole number expected")
        return self._whole(value, key, below)

    def wholes(self, key: str, *, below: int) -> list[int]:
        """An array of whole numbers, each at least 0 and less than `below`; empty where there is none."""
        self.length(key)
        return [self._whole(value, f"{key}[{n}]", below) for n, value in enumerate(self._value.get(key, []))]

    def _whole(self, value: Any, key: str, below: int) -> int:
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(key, f"is {_kind(value)}", "a whole number expected")
        if not 0 <= value < below:
            read = str(value) if abs(value) < 10**18 else "far"
            raise self.error(key, f"is {read}, out of range", f"less than {below}, from 0 on, expected")
        return value

    def numbers(self, key: str, count: int, default: tuple[float, ...]) -> tuple[float, ...]:
        """An array of `count` finite numbers."""
        if key not in self._value:
            return default
        value = self._value[key]
        if not isinstance(value, list) or len(value) != count:
            raise self.error(key, f"is {_kind(value)}", f"{count} numbers expected")
        for number in value:
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise self.error(key, f"holds {_kind(number)}", f"{count} numbers expected")
            if not math.isfinite(number) or abs(number) > MAGNITUDE_LIMIT:
                raise self.error(key, "holds a number out of range", "finite numbers, at most 1e7, expected")
        return tuple(float(number) for number in value)

    def number(self, key: str, default: float) -> float:
        """One finite number."""
        value = self._value.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(key, f"is {_kind(value)}", "a number expected")
        if not math.isfinite(value) or abs(value) > MAGNITUDE_LIMIT:
            raise self.error(key, "is out of range", "a finite number, at most 1e7, expected")
        return float(value)

    def texts(self, key: str) -> list[str]:
        """The texts of an array; empty where there is none."""
        value = self._value.get(key, [])
        return [one for one in value if isinstance(one, str)] if isinstance(value, list) else []

    def flag(self, key: str) -> bool:
        """Whether the key is there and true."""
        return self._value.get(key) is True


def _kind(value: Any) -> str:
    if isinstance(value, str):
        return f"the text {shown(value)}"
    if isinstance(value, list):
        return f"an array of {len(value)}"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return "an object" if isinstance(value, dict) else "a number"
