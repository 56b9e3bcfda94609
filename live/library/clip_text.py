"""Lossless text encoding of clips, so that a journal can replay steps whose files have changed or are gone.

Motion is smooth: differences from sample to sample, grouped by byte position, compress to a fifth of the size.
"""

import base64
import io
import zipfile
import zlib
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.library.disk_cache import clips_from_arrays, clips_to_arrays
from live.motion.step_clip import StepClip

MAX_DECODED_BYTES: Final = 64_000_000
"""Largest decoded size in bytes; limits the memory for a damaged text."""
_FLOAT_ARRAYS: Final = ("root", "rotation")


def clips_to_text(clips: Sequence[StepClip]) -> str:
    """Encode the clips losslessly as ASCII; no clips give an empty text."""
    if not clips:
        return ""
    arrays = clips_to_arrays(clips)
    for name in _FLOAT_ARRAYS:
        arrays[f"{name}_shape"] = np.array(arrays[name].shape)
        arrays[name] = _byte_planes(arrays[name])
    file = io.BytesIO()
    np.savez(file, **arrays)
    return base64.b64encode(zlib.compress(file.getvalue(), 6)).decode("ascii")


def clips_from_text(text: str) -> list[StepClip]:
    """Decode the clips that `clips_to_text` wrote; ValueError for anything else."""
    if not text:
        return []
    try:
        worker = zlib.decompressobj()
        data = worker.decompress(base64.b64decode(text, validate=True), MAX_DECODED_BYTES)
        if not worker.eof:
            raise ValueError("they are cut off or too long")
        with zipfile.ZipFile(io.BytesIO(data)) as members:
            if sum(member.file_size for member in members.infolist()) > MAX_DECODED_BYTES:
                raise ValueError("they would become too long")
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            arrays: dict[str, Any] = dict(found)
        for name in _FLOAT_ARRAYS:
            arrays[name] = _from_byte_planes(arrays[name], tuple(arrays[f"{name}_shape"].tolist()))
        return clips_from_arrays(arrays)
    except Exception as error:  # broken bytes break base64, zlib, zipfile, numpy, json and our checks in their own ways
        raise ValueError(f"steps in a text are damaged: {error}") from None


def _byte_planes(values: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """Differences along the first axis of `values` (T, ...), as integers, split by byte: (4, N)."""
    whole = np.ascontiguousarray(values, np.float32).reshape(len(values), -1).view(np.uint32)
    whole[1:] -= whole[:-1].copy()
    return np.ascontiguousarray(np.ascontiguousarray(whole.T).view(np.uint8).reshape(-1, 4).T)


def _from_byte_planes(planes: npt.NDArray[np.uint8], shape: tuple[int, ...]) -> npt.NDArray[np.float32]:
    """Inverse of `_byte_planes` for values of this `shape`."""
    whole = np.ascontiguousarray(planes.T).reshape(-1).view(np.uint32).reshape(-1, shape[0]).T
    summed = np.add.accumulate(whole, axis=0, dtype=np.uint32)
    return np.ascontiguousarray(summed).view(np.float32).reshape(shape)
