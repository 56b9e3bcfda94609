"""How to get a missing system library on this machine: the exact apt, dnf or brew line."""

import shutil
from pathlib import Path

_PACKAGES = {
    "opengl": {"apt-get": "libegl1 libgl1", "dnf": "mesa-libEGL mesa-libGL mesa-dri-drivers"},
    "portaudio": {"apt-get": "libportaudio2", "dnf": "portaudio", "brew": "portaudio"},
    "alsa": {"apt-get": "libasound2", "dnf": "alsa-lib"},
    "x11": {
        "apt-get": "libx11-6 libxcursor1 libxi6 libxinerama1 libxrandr2",
        "dnf": "libX11 libXcursor libXi libXinerama libXrandr",
    },
}
_COMMANDS = {
    "apt-get": "sudo apt-get install --no-install-recommends",
    "dnf": "sudo dnf install",
    "brew": "brew install",
}


def install_line(library: str) -> str:
    """What to type for `library` (opengl, portaudio, alsa or x11) with the first package manager found here."""
    for manager, command in _COMMANDS.items():
        if shutil.which(manager):
            packages = _PACKAGES[library].get(manager)
            if packages is None:
                return f"{library} comes with this system"
            if manager == "apt-get" and library == "alsa" and _has_time64_names():
                packages = "libasound2t64"
            return f"{command} {packages}"
    return f"install {library} with this system's package manager"


def _has_time64_names() -> bool:
    # Debian 13 and Ubuntu 24.04 renamed some libraries for 64-bit time; libc's own marks show which naming is in use
    return any(Path("/usr/share/doc").glob("lib*t64"))
