"""The outside of a glTF file: a GLB's chunks or a JSON text, parsed within bounds (glTF 2.0 specification, section 4).

pygltflib builds an object for whatever a file says there is, so a small hostile file costs it gigabytes; files that
people bring are read here, and pygltflib writes ours.
"""

import json
import struct
from dataclasses import dataclass
from typing import Any, Final

from live.motion.formats.file_error import MotionFileError, shown

MAGIC: Final = b"glTF"
VALUE_LIMIT: Final = 1_000_000
"""Objects, arrays and elements of the JSON at most: each may cost 150 bytes of memory."""
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
    """Take a .glb, .vrm, .vrma or .gltf file apart; raises MotionFileError for whatever else it may be."""
    if data[:4] == MAGIC:
        text, chunk = _chunks(data, file)
    else:
        text, chunk = memoryview(data), None
        if not data[:64].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
            raise MotionFileError(
                file, None, f"{shown(data[:12].decode('latin-1'))} was read", "a glTF file begins with 'glTF' or '{'"
            )
    content = _parse_json(bytes(text), file)
    version = content.get("asset", {}).get("version") if isinstance(content.get("asset"), dict) else None
    if not isinstance(version, str) or not version.startswith("2."):
        words = "no asset.version" if version is None else f"glTF version {shown(str(version))}"
        raise MotionFileError(file, None, words, "glTF 2.0 expected; export it again")
    return GltfFile(file, content, chunk, len(data))


def _chunks(data: bytes, file: str) -> tuple[memoryview, memoryview | None]:
    """The JSON chunk and the binary one; chunks of other kinds are passed over as the specification says."""
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
                file, None, f"the chunk at byte {place - 8} of {size} bytes goes beyond the end", "copy it again"
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
        raise MotionFileError(file, None, "the JSON is no object", "a glTF file expected")
    return content
