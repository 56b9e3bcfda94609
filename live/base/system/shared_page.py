"""A page of memory that two processes share: an anonymous file whose descriptor is inherited, or a temporary file."""

import contextlib
import mmap
import os
import tempfile
from typing import Final

from live.base.system.features import LINUX

SIZE: Final = 4096


class SharedPage:
    """A page of zeros, or the one that another process made. Thread: any."""

    def __init__(self, memory: mmap.mmap, descriptor: int, path: str = "") -> None:
        self.memory = memory
        self.descriptor = descriptor
        """Descriptor of the file, to be inherited or handed on (Linux)."""
        self._path = path

    @classmethod
    def create(cls) -> "SharedPage":
        """Make a page; OSError without resources."""
        path = ""
        if LINUX:
            descriptor = os.memfd_create("heartbeat", 0)
        else:
            descriptor, path = tempfile.mkstemp(prefix="live-", suffix=".page")  # for this user alone
        os.ftruncate(descriptor, SIZE)
        return cls(mmap.mmap(descriptor, SIZE), descriptor, path)

    @classmethod
    def of_descriptor(cls, descriptor: int) -> "SharedPage":
        """Map the page of an inherited descriptor."""
        return cls(mmap.mmap(descriptor, SIZE), descriptor)

    @classmethod
    def of_argument(cls, argument: str) -> "SharedPage":
        """Map the page that the parent named; OSError if it has gone."""
        if argument.isdecimal():
            return cls.of_descriptor(int(argument))
        return cls.of_descriptor(os.open(argument, os.O_RDWR | getattr(os, "O_BINARY", 0)))

    @property
    def argument(self) -> str:
        """How a child finds it: a word for its command line."""
        return self._path or str(self.descriptor)

    @property
    def inherit(self) -> tuple[int, ...]:
        """The descriptors that a child has to inherit for it."""
        return () if self._path else (self.descriptor,)

    def close(self) -> None:
        """Release the memory; the one who made it also removes the file."""
        self.memory.close()
        os.close(self.descriptor)
        if self._path:
            with contextlib.suppress(OSError):  # Windows keeps it while a child still maps it
                os.unlink(self._path)
