"""Reader for glTF accessors as arrays: buffers, strides, normalized integers, sparse values (specification, 3.6)."""

import base64
import binascii
import re
from collections.abc import Callable
from typing import Final
from urllib.parse import unquote

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion.formats.file_error import MAGNITUDE_LIMIT, MotionFileError, quoted
from live.motion.formats.gltf_document import GltfFile, JsonObject

Resolve = Callable[[str], bytes]
"""Returns the content of a file next to the glTF file, by its bare name; may raise OSError."""

FILE_LIMIT: Final = 4
"""Maximum number of other files that a glTF file may reference."""
_COMPONENTS: Final = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS: Final = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_MAX_OFFSET: Final = 1 << 40
_DATA_URI: Final = re.compile(r"data:[^,]{0,200};base64,")
_BARE_NAME: Final = re.compile(r"(?!\.)[^/\\:\0]{1,255}")
_RELATIVE_PATH: Final = re.compile(r"(?:(?!\.)[^/\\:\0]{1,255}/){0,4}(?!\.)[^/\\:\0]{1,255}")
_COMPRESSION: Final = ("EXT_meshopt_compression", "KHR_meshopt_compression")


class AccessorReader:
    """Reads the accessors of one file by index.

    The total work is bounded, because a hostile file may reference the same bytes a thousand times: one accessor has at
    most as many numbers as a file of that size can hold, and all together take time linear in the file size.
    """

    def __init__(
        self, gltf: GltfFile, resolve: Resolve | None = None, *, files: int = FILE_LIMIT, folders: bool = False
    ) -> None:
        """`files` is how many other files it may reference, `folders` whether these may be in subfolders."""
        self._file_limit, self._name_pattern = files, _RELATIVE_PATH if folders else _BARE_NAME
        self._root = JsonObject(gltf.json, "", gltf.file)
        self._chunk, self._resolve = gltf.chunk, resolve
        self._buffers: dict[int, memoryview] = {}
        self._files: dict[str, bytes] = {}
        self._budget = 16_000_000 + 16 * gltf.size
        self._max_accessor_size = 1_000_000 + gltf.size // 2

    def read(self, index: int, kind: str) -> Float64:
        """All elements of an accessor of the given type ("SCALAR", "VEC3", "VEC4", "MAT4"), float64 (count, width).

        Normalized integers become -1..1 or 0..1. Raises MotionFileError for NaN and values out of range.
        """
        accessor = self._root.element("accessors", index)
        if accessor.text("type") != kind:
            raise accessor.error("type", f"is {quoted(accessor.text('type'))}", f"{kind} expected")
        count, width = accessor.integer("count", below=_MAX_OFFSET), _WIDTHS[kind]
        component = accessor.integer("componentType", below=_MAX_OFFSET)
        if component not in _COMPONENTS:
            raise accessor.error("componentType", f"is {component}", "5120 to 5126 expected")
        stored = np.dtype(_COMPONENTS[component])
        if accessor.has("bufferView"):
            values = self._view(accessor, stored, count, width)
            self._consume_budget(accessor, count * width)
        else:
            self._consume_budget(accessor, count * width)
            values = np.zeros((count, width), stored)
        if accessor.has("sparse"):
            values = self._apply_sparse(accessor.object("sparse"), values, stored)
        with np.errstate(invalid="ignore"):  # casting some NaNs warns; they are refused below
            result = values.astype(np.float64)
        if accessor.flag("normalized") and stored.kind in "iu":
            result = np.maximum(result / float(np.iinfo(stored).max), -1.0)
        strange = np.flatnonzero(~(np.abs(result) <= MAGNITUDE_LIMIT).all(axis=1))
        if strange.size:
            raise accessor.error("", f"element {strange[0]} is not usable", "finite numbers, at most 1e7, expected")
        return result

    def content(self, place: JsonObject) -> memoryview:
        """Bytes of an image from a buffer view, a data URI or a file next to this one; raises MotionFileError."""
        if not place.has("bufferView"):
            return memoryview(self._content(place, -1))
        view = self._root.element("bufferViews", place.integer("bufferView", below=self._root.length("bufferViews")))
        buffer = self._buffer(view.integer("buffer", below=self._root.length("buffers")))
        start, length = view.integer("byteOffset", 0, below=_MAX_OFFSET), view.integer("byteLength", below=_MAX_OFFSET)
        if start + length > len(buffer):
            raise view.error("", f"ends at byte {start + length} of {len(buffer)}", "the whole file expected")
        return buffer[start : start + length]

    def _consume_budget(self, accessor: JsonObject, numbers: int) -> None:
        self._budget -= numbers
        if numbers > self._max_accessor_size or self._budget < 0:
            raise accessor.error("count", f"asks for {numbers} numbers", "as many as the file can hold expected")

    def _view(
        self, accessor: JsonObject, stored: "np.dtype[np.generic]", count: int, width: int
    ) -> npt.NDArray[np.generic]:
        """Return the accessor's elements (count, width) without a copy."""
        index = accessor.integer("bufferView", below=self._root.length("bufferViews"))
        view = self._root.element("bufferViews", index)
        if view.has("extensions") and any(view.object("extensions").has(name) for name in _COMPRESSION):
            raise view.error("", "is compressed (meshopt)", "export without compression, or convert it in Blender")
        buffer = self._buffer(view.integer("buffer", below=self._root.length("buffers")))
        start, length = view.integer("byteOffset", 0, below=_MAX_OFFSET), view.integer("byteLength", below=_MAX_OFFSET)
        if start + length > len(buffer):
            raise view.error("", f"ends at byte {start + length} of {len(buffer)}", "the whole file expected")
        size = stored.itemsize * width
        stride = view.integer("byteStride", size, below=_MAX_OFFSET)
        if stride < size:
            raise view.error("byteStride", f"is {stride}", f"at least {size} expected")
        offset = accessor.integer("byteOffset", 0, below=_MAX_OFFSET)
        if count and offset + stride * (count - 1) + size > length:
            raise accessor.error(
                "", f"has {count} elements that exceed its bufferView of {length} bytes", "the whole file expected"
            )
        if count == 0:
            return np.zeros((0, width), stored)
        return np.ndarray((count, width), stored, buffer, start + offset, (stride, stored.itemsize))

    def _apply_sparse(
        self, sparse: JsonObject, values: npt.NDArray[np.generic], stored: "np.dtype[np.generic]"
    ) -> npt.NDArray[np.generic]:
        count = sparse.integer("count", below=len(values) + 1)
        self._consume_budget(sparse, count * (1 + values.shape[1]))
        places, news = sparse.object("indices"), sparse.object("values")
        component = places.integer("componentType", below=_MAX_OFFSET)
        if component not in (5121, 5123, 5125):
            raise places.error("componentType", f"is {component}", "5121, 5123 or 5125 expected")
        indices = self._view(places, np.dtype(_COMPONENTS[component]), count, 1)[:, 0].astype(np.int64)
        if count and not int(indices.max()) < len(values):
            raise places.error("", f"names the element {indices.max()}", f"0 to {len(values) - 1} expected")
        result = values.copy()
        result[indices] = self._view(news, stored, count, values.shape[1])
        return result

    def _buffer(self, index: int) -> memoryview:
        if index not in self._buffers:
            place = self._root.element("buffers", index)
            content = self._content(place, index)
            length = place.integer("byteLength", below=_MAX_OFFSET)
            if length > len(content):
                raise place.error("", f"has {len(content)} bytes of {length}: it is cut off", "the whole file expected")
            self._buffers[index] = memoryview(content)[:length]
        return self._buffers[index]

    def _content(self, place: JsonObject, index: int) -> bytes | memoryview:
        uri = place.text("uri")
        if not uri:
            if index != 0 or self._chunk is None:
                raise place.error("", "has no content", "a uri or a GLB's binary chunk expected")
            return self._chunk
        if uri.startswith("data:"):
            head = _DATA_URI.match(uri)
            try:
                if head is None:
                    raise ValueError
                return base64.b64decode(uri[head.end() :], validate=True)
            except (ValueError, binascii.Error):
                raise place.error("uri", "holds no base64 data", "data:application/octet-stream;base64,...") from None
        return self._external_file(place, unquote(uri))

    def _external_file(self, place: JsonObject, name: str) -> bytes:
        """Return the content of a file in the same folder (or a subfolder if allowed)."""
        if not self._name_pattern.fullmatch(name):
            raise place.error("uri", f"is {quoted(name)}", "a file in the same folder expected; or export as .glb")
        if self._resolve is None:
            raise place.error("uri", f"names another file, {quoted(name)}", "one file expected: export as .glb")
        if name in self._files:
            return self._files[name]
        if len(self._files) >= self._file_limit:
            raise place.error("uri", f"is the file number {self._file_limit + 1}", "one file expected: export as .glb")
        try:
            content = self._resolve(name)
        except MotionFileError:
            raise
        except (OSError, ValueError) as error:
            words = getattr(error, "strerror", None) or str(error)
            raise place.error(
                "uri", f"{quoted(name)} cannot be read: {' '.join(words.split())}", "put it next to the file"
            ) from None
        self._files[name] = content
        self._budget += 16 * len(content)
        self._max_accessor_size += len(content) // 2
        return content
