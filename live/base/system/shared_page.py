"""A page of memory that two processes share: an anonymous file whose descriptor is inherited (Linux), named memory
(Windows), or a file that is in memory where the system has a folder for such files."""

import contextlib
import mmap
import os
import sys
import tempfile
from typing import Final

from live.base.system.features import LINUX
from live.base.system.files import memory_folder

SIZE: Final = 4096


class SharedPage:
    """A page of zeros, or the one that another process made. Thread: any."""

    def __init__(self, memory: mmap.mmap, descriptor: int, name: str = "") -> None:
        self.memory = memory
        self.descriptor = descriptor
        """Descriptor of the file, to be inherited or handed on (Linux); -1 on Windows."""
        self._name = name

    @classmethod
    def create(cls) -> "SharedPage":
        """Make a page; OSError without resources."""
        if sys.platform == "win32":
            import secrets

            name = f"live-{secrets.token_hex(16)}"
            return cls(mmap.mmap(-1, SIZE, tagname=name), -1, name)
        name = ""
        if LINUX:
            descriptor = os.memfd_create("heartbeat", 0)
        else:
            descriptor, name = tempfile.mkstemp(".page", "live-", memory_folder())  # for this user alone
        os.ftruncate(descriptor, SIZE)
        return cls(mmap.mmap(descriptor, SIZE), descriptor, name)

    @classmethod
    def of_descriptor(cls, descriptor: int) -> "SharedPage":
        """Map the page of an inherited descriptor."""
        return cls(mmap.mmap(descriptor, SIZE), descriptor)

    @classmethod
    def of_argument(cls, argument: str) -> "SharedPage":
        """Map the page that the parent named; OSError if it has gone. Its file has no name any more after that: none
        stays when both are killed."""
        if argument.isdecimal():
            return cls.of_descriptor(int(argument))
        if sys.platform == "win32":
            return cls(mmap.mmap(-1, SIZE, tagname=argument), -1)
        descriptor = os.open(argument, os.O_RDWR)
        os.unlink(argument)
        return cls.of_descriptor(descriptor)

    @property
    def argument(self) -> str:
        """How a child finds it: a word for its command line."""
        return self._name or str(self.descriptor)

    @property
    def inherit(self) -> tuple[int, ...]:
        """The descriptors that a child has to inherit for it."""
        return () if self._name else (self.descriptor,)

    def close(self) -> None:
        """Release the memory; the one who made it also removes a file that no child has mapped."""
        self.memory.close()
        if self.descriptor >= 0:
            os.close(self.descriptor)
        if self._name:
            with contextlib.suppress(OSError):
                os.unlink(self._name)
