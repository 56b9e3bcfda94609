"""Safe reader for untrusted NumPy archives (.npz): no pickles, no zip bombs, bounded allocation."""

import io
import zipfile
import zlib
from typing import Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.motion.formats.file_error import MotionFileError, quoted

Real = npt.NDArray[np.floating] | npt.NDArray[np.integer]

MEMBER_LIMIT: Final = 1000
_BASE_BYTES: Final = 16_000_000
"""Bytes always allowed for an array; more in larger files."""
_HEADER_LIMIT: Final = 10_000
_SUPPORTED_COMPRESSION: Final = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)


def as_float64(array: Real) -> Float64:
    """Return a copy as float64; NaNs are kept without warnings."""
    with np.errstate(invalid="ignore"):
        return array.astype(np.float64)


class Archive:
    """The arrays of one archive by name, unpacked on demand within size limits."""

    def __init__(self, data: bytes, file: str) -> None:
        self._file = file
        self._limit = _BASE_BYTES + 5 * len(data)
        try:
            self._zip = zipfile.ZipFile(io.BytesIO(data))
            members = self._zip.infolist()
        except (zipfile.BadZipFile, ValueError, NotImplementedError, OSError):
            raise MotionFileError(
                file, None, "no zip archive, or cut off", "an archive of NumPy arrays (.npz)"
            ) from None
        if len(members) > MEMBER_LIMIT:
            raise MotionFileError(file, None, f"{len(members)} arrays", f"at most {MEMBER_LIMIT} expected")
        self._members = {member.filename.removesuffix(".npy"): member for member in members}

    @property
    def keys(self) -> list[str]:
        """Names of the arrays, shortened for messages."""
        return [key[:40] for key in self._members]

    def has(self, key: str) -> bool:
        """Whether there is an array of this name."""
        return key in self._members

    def table(self, key: str, width: int, rows: int | None = None) -> Float64:
        """Return an array of shape (rows, width); any number of rows if `rows` is None."""
        array = self.array(key)
        if array.ndim != 2 or array.shape[1] != width or (rows is not None and len(array) != rows):
            expected = f"({'frames' if rows is None else rows}, {width}) expected"
            raise MotionFileError(self._file, None, f"{key} has the shape {array.shape}", expected)
        return as_float64(array)

    def number(self, key: str) -> float:
        """Return the value of an array of one number."""
        array = self.array(key)
        if array.size != 1:
            raise MotionFileError(self._file, None, f"{key} has the shape {array.shape}", "one number expected")
        return float(array.reshape(()))

    def array(self, key: str) -> Real:
        """Return the array as stored; raises MotionFileError if it is missing or holds other data than real numbers."""
        if key not in self._members:
            raise MotionFileError(self._file, None, f"there is no array {key!r}", f"arrays there: {self.keys[:8]}")
        content = self._unpack(key, self._members[key])
        stream = io.BytesIO(content)
        try:
            version = np.lib.format.read_magic(stream)
            read_header = {
                (1, 0): np.lib.format.read_array_header_1_0,
                (2, 0): np.lib.format.read_array_header_2_0,
            }[version]
            shape, columns_first, dtype = read_header(stream, _HEADER_LIMIT)
        except Exception:  # the header is a Python expression, which can fail in many ways
            raise MotionFileError(self._file, None, f"{key} is no NumPy array", "a file saved by numpy.savez") from None
        if dtype.kind not in "fiu" or dtype.itemsize > 8:
            raise MotionFileError(
                self._file, None, f"{key} has the type {quoted(str(dtype))}", "an array of numbers (float32 or float64)"
            )
        count = 1
        for length in shape:
            count *= length
        left = len(content) - stream.tell()
        if min(shape, default=0) < 0 or count * dtype.itemsize != left:
            words = f"{key} says {count} numbers of {dtype.itemsize} bytes and holds {left} bytes"
            raise MotionFileError(self._file, None, words, "the whole array expected")
        array: Real = np.frombuffer(content, dtype, count, stream.tell())
        return array.reshape(shape, order="F" if columns_first else "C")

    def _unpack(self, key: str, member: zipfile.ZipInfo) -> bytes:
        """Return the member's bytes; its size is checked first and never exceeded."""
        if member.compress_type not in _SUPPORTED_COMPRESSION or member.flag_bits & 1:
            raise MotionFileError(self._file, None, f"{key} is encrypted or unsupported", "save it with numpy.savez")
        if member.file_size > self._limit:
            words = f"{key} has {member.file_size} bytes unpacked"
            raise MotionFileError(self._file, None, words, f"at most {self._limit} in a file of this size expected")
        try:
            with self._zip.open(member) as stream:
                return stream.read(self._limit + 1)
        except (zipfile.BadZipFile, zlib.error, EOFError, ValueError, OSError, RuntimeError, NotImplementedError):
            raise MotionFileError(self._file, None, f"{key} cannot be unpacked", "copy the file again") from None
