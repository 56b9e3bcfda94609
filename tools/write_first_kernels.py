"""Write live/app/machine/first_kernels.txt: the kernels that the default show uses in its first two minutes.

A machine without compiled kernels compiles these before its first show, and all others behind it.
"""

import sys
import tempfile
from pathlib import Path
from typing import Final

from rich.console import Console

ROOT: Final = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from live.app.film.show_film import film_show  # noqa: E402
from live.app.launch_options import LaunchOptions  # noqa: E402
from live.app.machine.kernel_build import FIRST_KERNELS, all_kernels, kernel_name  # noqa: E402
from live.app.session_audio import choose_audio  # noqa: E402
from live.base.jit import Kernel, kernels  # noqa: E402

SECONDS: Final = 120.0
FPS: Final = 2.0
"""Pictures a second; ticks and decisions are those of a show at any rate."""


def used_kernels(seconds: float = SECONDS) -> list[str]:
    """Return the names of the kernels that this process has used after `seconds` of the default show.

    Those that follow music are added: whether they run depends on the sound device. Those that build bodies, too: a
    machine without compiled kernels has no bodies either.
    """
    options = LaunchOptions(size=(320, 180), fps=FPS)
    loaded, console = options.load(), Console(stderr=True)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.mp4"
        film_show(options, loaded, choose_audio(options, loaded), path=path, seconds=seconds, console=console)
    used = {kernel_name(each) for each in kernels if each.ready}
    return sorted(used | {kernel_name(each) for each in all_kernels() if _always_needed(each)})


def _always_needed(kernel: Kernel) -> bool:
    return str(kernel.py_func.__module__).startswith(("live.clock.", "live.render.body."))


if __name__ == "__main__":
    FIRST_KERNELS.write_text("\n".join(used_kernels()) + "\n", encoding="utf-8")
