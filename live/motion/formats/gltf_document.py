"""Parser for the container of a glTF file: GLB chunks or JSON, within size limits (glTF 2.0 specification, section 4).

pygltflib builds an object for everything that a file declares, so a small hostile file can cost it gigabytes. External
files are therefore read here; pygltflib only writes files.
"""

import json
import math
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError, quoted

MAGIC: Final = b"glTF"
VALUE_LIMIT: Final = 1_000_000
"""Maximum number of objects, arrays and elements in the JSON: each may cost 150 bytes of memory."""
_JSON: Final = 0x4E4F534A
_BIN: Final = 0x004E4942


@dataclass(frozen=True, slots=True, eq=False)
class GltfFile:
    """The JSON of a file and the binary chunk of a GLB."""

    file: str
    json: dict[str, Any]
    chunk: memoryview | None
    size: int
    """Bytes of the whole file."""


def open_gltf(data: bytes, file: str) -> GltfFile:
    """Parse a .glb, .vrm, .vrma or .gltf file; raises MotionFileError for any other content."""
    if data[:4] == MAGIC:
        text, chunk = _chunks(data, file)
    else:
        text, chunk = memoryview(data), None
        if not data[:64].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
            raise MotionFileError(
                file, None, f"{quoted(data[:12].decode('latin-1'))} was read", "a glTF file begins with 'glTF' or '{'"
            )
    content = _parse_json(bytes(text), file)
    version = content.get("asset", {}).get("version") if isinstance(content.get("asset"), dict) else None
    if not isinstance(version, str) or not version.startswith("2."):
        words = "no asset.version" if version is None else f"glTF version {quoted(str(version))}"
        raise MotionFileError(file, None, words, "glTF 2.0 expected; export it again")
    return GltfFile(file, content, chunk, len(data))


def _chunks(data: bytes, file: str) -> tuple[memoryview, memoryview | None]:
    """Return the JSON chunk and the binary chunk; other chunks are ignored, as specified."""
    if len(data) < 20:
        raise MotionFileError(file, None, f"the file ends after {len(data)} bytes", "a GLB header expected")
    _, version, length = struct.unpack_from("<4sII", data)
    if version != 2:
        raise MotionFileError(file, None, f"GLB version {version}", "version 2 expected; export it again")
    if length > len(data):
        raise MotionFileError(
            file, None, f"the header says {length} bytes, the file has {len(data)}: it is cut off", "copy it again"
        )
    view, place = memoryview(data)[:length], 12
    text: memoryview | None = None
    binary: memoryview | None = None
    while place + 8 <= length:
        size, kind = struct.unpack_from("<II", view, place)
        place += 8
        if place + size > length:
            raise MotionFileError(
                file, None, f"the chunk at byte {place - 8} of {size} bytes extends past the end", "copy it again"
            )
        if kind == _JSON and text is None:
            text = view[place : place + size]
        elif kind == _BIN and binary is None:
            binary = view[place : place + size]
        place += size
    if text is None:
        raise MotionFileError(file, None, "no JSON chunk", "a GLB with a JSON chunk expected")
    return text, binary


def _parse_json(text: bytes, file: str) -> dict[str, Any]:
    if sum(text.count(mark) for mark in (b"{", b"[", b",")) > VALUE_LIMIT:
        raise MotionFileError(
            file, None, f"more than {VALUE_LIMIT} values in the JSON", "export the armature and its animation only"
        )

    def refuse(word: str) -> None:
        raise MotionFileError(file, None, f"{word} in the JSON", "finite numbers expected")

    try:
        content = json.loads(text.decode("utf-8-sig"), parse_constant=refuse)
    except json.JSONDecodeError as error:
        raise MotionFileError(
            file, error.lineno, f"column {error.colno}: no valid JSON", error.msg[:1].lower() + error.msg[1:]
        ) from None
    except UnicodeDecodeError as error:
        raise MotionFileError(file, None, f"byte {error.start} of the JSON is not UTF-8", "UTF-8 expected") from None
    except RecursionError:
        raise MotionFileError(file, None, "the JSON is nested too deep", "a glTF file expected") from None
    except MotionFileError:
        raise
    except ValueError:  # a number of thousands of digits
        raise MotionFileError(file, None, "a number in the JSON is too long", "a glTF file expected") from None
    if not isinstance(content, dict):
        raise MotionFileError(file, None, "the JSON is not an object", "a glTF file expected")
    return content


class JsonObject:
    """Typed access to one JSON object and its path in the file; missing or mistyped values raise MotionFileError."""

    def __init__(self, value: Any, where: str, file: str) -> None:
        self.path, self.file = where, file
        if not isinstance(value, dict):
            raise self.error("", f"is {_describe_type(value)}", "an object expected")
        self._value: dict[str, Any] = value

    def error(self, key: str, problem: str, expected: str) -> MotionFileError:
        """Return an error about `key` of this object (about the object itself if `key` is empty)."""
        place = ".".join(part for part in (self.path, key) if part) or "the file"
        return MotionFileError(self.file, None, f"{place} {problem}", expected)

    def has(self, key: str) -> bool:
        """Whether the object has this key."""
        return key in self._value

    def names(self) -> list[str]:
        """Return all keys in file order."""
        return list(self._value)

    def text(self, key: str, default: str = "") -> str:
        """Return a string; other types count as missing (names are only for display)."""
        value = self._value.get(key, default)
        return value if isinstance(value, str) else default

    def object(self, key: str) -> "JsonObject":
        """Return the object under `key`."""
        if key not in self._value:
            raise self.error(key, "is missing", "an object expected")
        return JsonObject(self._value[key], ".".join(part for part in (self.path, key) if part), self.file)

    def length(self, key: str) -> int:
        """Return the length of the array under `key`; 0 if there is none."""
        value = self._value.get(key, [])
        if not isinstance(value, list):
            raise self.error(key, f"is {_describe_type(value)}", "an array expected")
        return len(value)

    def element(self, key: str, index: int) -> "JsonObject":
        """Return one object of an array of objects."""
        count = self.length(key)
        if not 0 <= index < count:
            raise self.error(key, f"has {count} elements and no number {index}", "valid references expected")
        place = f"{self.path}.{key}" if self.path else key
        return JsonObject(self._value[key][index], f"{place}[{index}]", self.file)

    def elements(self, key: str) -> "Iterator[JsonObject]":
        """Yield all objects of an array of objects; none if the array is missing."""
        for index in range(self.length(key)):
            yield self.element(key, index)

    def integer(self, key: str, default: int | None = None, *, below: int) -> int:
        """Return an integer of at least 0 and less than `below`."""
        value = self._value.get(key, default)
        if value is None:
            raise self.error(key, "is missing", "a whole number expected")
        return self._integer(value, key, below)

    def integers(self, key: str, *, below: int) -> list[int]:
        """Return an array of integers, each at least 0 and less than `below`; empty if missing."""
        self.length(key)
        return [self._integer(value, f"{key}[{n}]", below) for n, value in enumerate(self._value.get(key, []))]

    def _integer(self, value: Any, key: str, below: int) -> int:
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(key, f"is {_describe_type(value)}", "a whole number expected")
        if not 0 <= value < below:
            read = str(value) if abs(value) < 10**18 else "far"
            raise self.error(key, f"is {read}, out of range", f"less than {below}, from 0 on, expected")
        return value

    def numbers(self, key: str, count: int, default: tuple[float, ...]) -> tuple[float, ...]:
        """Return an array of `count` finite numbers."""
        if key not in self._value:
            return default
        value = self._value[key]
        if not isinstance(value, list) or len(value) != count:
            raise self.error(key, f"is {_describe_type(value)}", f"{count} numbers expected")
        for number in value:
            if isinstance(number, bool) or not isinstance(number, int | float):
                raise self.error(key, f"holds {_describe_type(number)}", f"{count} numbers expected")
            if not math.isfinite(number) or abs(number) > MAGNITUDE_LIMIT:
                raise self.error(key, "holds a number out of range", "finite numbers, at most 1e7, expected")
        return tuple(float(number) for number in value)

    def number(self, key: str, default: float) -> float:
        """Return one finite number."""
        value = self._value.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(key, f"is {_describe_type(value)}", "a number expected")
        if not math.isfinite(value) or abs(value) > MAGNITUDE_LIMIT:
            raise self.error(key, "is out of range", "a finite number, at most 1e7, expected")
        return float(value)

    def texts(self, key: str) -> list[str]:
        """Return the strings of an array; empty if missing."""
        value = self._value.get(key, [])
        return [one for one in value if isinstance(one, str)] if isinstance(value, list) else []

    def flag(self, key: str) -> bool:
        """Whether the key is present and true."""
        return self._value.get(key) is True


def _describe_type(value: Any) -> str:
    if isinstance(value, str):
        return f"the text {quoted(value)}"
    if isinstance(value, list):
        return f"an array of {len(value)}"
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    return "an object" if isinstance(value, dict) else "a number"
