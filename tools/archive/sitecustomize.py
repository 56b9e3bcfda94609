"""Part of the archive: where the system has no library, ctypes finds that of the archive by its plain name, too.

The launcher put those folders into LD_LIBRARY_PATH. ctypes looks there only on machines with a linker.
"""

import ctypes.util
import os
from pathlib import Path
from typing import Final

_find: Final = ctypes.util.find_library


def find_library(name: str) -> str | None:
    """Return the name of the system's library, or the path of the archive's, or None."""
    found = _find(name)
    if found is None:
        for folder in os.environ.get("LD_LIBRARY_PATH", "").split(":"):
            if folder and Path(folder).name.startswith(f"lib{name}.so"):
                return str(Path(folder, Path(folder).name))
    return found


ctypes.util.find_library = find_library
