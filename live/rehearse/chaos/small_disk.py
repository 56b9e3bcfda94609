"""Small tmpfs for the journal of a chaos run, which can be filled completely."""

import contextlib
import os
import shutil
import subprocess
from pathlib import Path
from typing import Final

SIZE_MB: Final = 64
FILLER: Final = "filler"
CHUNK_SIZE: Final = 1 << 16


class SmallDisk:
    """A folder on a tmpfs if that can be mounted (as root), else a plain folder, which is never filled. Thread: one."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.is_mounted = False
        """Whether it is a separate file system."""

    def open(self) -> None:
        """Create it, empty."""
        shutil.rmtree(self.path, ignore_errors=True)
        self.path.mkdir(parents=True, exist_ok=True)
        if os.geteuid() == 0:
            command = ["mount", "-t", "tmpfs", "-o", f"size={SIZE_MB}m", "live-chaos", str(self.path)]
            with contextlib.suppress(OSError):
                self.is_mounted = subprocess.run(command, capture_output=True, check=False).returncode == 0

    def fill(self) -> bool:
        """Fill it to the last byte; False if it is a plain folder."""
        if not self.is_mounted:
            return False
        with (self.path / FILLER).open("ab", buffering=0) as file, contextlib.suppress(OSError):
            for size in (CHUNK_SIZE, 4096, 1):
                with contextlib.suppress(OSError):
                    while True:
                        file.write(bytes(size))
                        if size == 1:
                            break
        return True

    def free(self) -> None:
        """Free the space again."""
        (self.path / FILLER).unlink(missing_ok=True)

    def copy_to(self, folder: Path) -> None:
        """Copy its files into `folder`."""
        self.free()
        for file in self.path.iterdir():
            if file.is_file():
                shutil.copy(file, folder / file.name)

    def close(self) -> None:
        """Unmount it."""
        if self.is_mounted:
            subprocess.run(["umount", "-l", str(self.path)], capture_output=True, check=False)
            self.is_mounted = False
