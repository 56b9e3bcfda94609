"""Clips as text: what a journal needs so that a step whose file has changed, or is gone, can be danced again.

Every bit is kept. Motion is smooth: the differences from sample to sample, the first bytes of all numbers first, are a
fifth as long when they are compressed.
"""

import base64
import io
import zipfile
import zlib
from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from live.library.disk_cache import arrays_of, clips_of
from live.motion.step_clip import StepClip

LARGEST: Final = 64_000_000
"""Bytes of clips that a text may hold: a damaged one asks for no more memory."""
_NUMBERS: Final = ("root", "rotation")


def clips_to_text(clips: Sequence[StepClip]) -> str:
    """The clips, bit by bit, as letters; none are an empty text."""
    if not clips:
        return ""
    arrays = arrays_of(clips)
    for name in _NUMBERS:
        arrays[f"{name}_shape"] = np.array(arrays[name].shape)
        arrays[name] = _planes(arrays[name])
    file = io.BytesIO()
    np.savez(file, **arrays)
    return base64.b64encode(zlib.compress(file.getvalue(), 6)).decode("ascii")


def clips_from_text(text: str) -> list[StepClip]:
    """The clips that `clips_to_text` wrote; ValueError for anything else."""
    if not text:
        return []
    try:
        worker = zlib.decompressobj()
        data = worker.decompress(base64.b64decode(text, validate=True), LARGEST)
        if not worker.eof:
            raise ValueError("they are cut off or too long")
        with zipfile.ZipFile(io.BytesIO(data)) as members:
            if sum(member.file_size for member in members.infolist()) > LARGEST:
                raise ValueError("they would become too long")
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            arrays: dict[str, Any] = dict(found)
        for name in _NUMBERS:
            arrays[name] = _numbers(arrays[name], tuple(arrays[f"{name}_shape"].tolist()))
        return clips_of(arrays)
    except Exception as error:  # broken bytes break base64, zlib, zipfile, numpy, json and our checks in their own ways
        raise ValueError(f"steps in a text are damaged: {error}") from None


def _planes(values: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """Differences along the first axis of `values` (T, ...), taken as whole numbers, by bytes: (4, N)."""
    whole = np.ascontiguousarray(values, np.float32).reshape(len(values), -1).view(np.uint32)
    whole[1:] -= whole[:-1].copy()
    return np.ascontiguousarray(np.ascontiguousarray(whole.T).view(np.uint8).reshape(-1, 4).T)


def _numbers(planes: npt.NDArray[np.uint8], shape: tuple[int, ...]) -> npt.NDArray[np.float32]:
    """The values of this `shape` whose `_planes` these are."""
    whole = np.ascontiguousarray(planes.T).reshape(-1).view(np.uint32).reshape(-1, shape[0]).T
    summed = np.add.accumulate(whole, axis=0, dtype=np.uint32)
    return np.ascontiguousarray(summed).view(np.float32).reshape(shape)
