"""Checks whether this machine can run shows, with the command that installs what is missing.

The checks never raise. OpenGL is probed in a child process, since a broken driver may crash or hang.
"""

import importlib.metadata
import json
import re
import shutil
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import live
from live.app.machine.device_list import Section, audio_sections, midi_sections, monitor_section, one_line
from live.base.system.clock_discipline import clock_discipline
from live.base.system.native_stderr import suppress_native_stderr

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


def install_command(library: str) -> str:
    """Return the command that installs `library` (opengl, portaudio, alsa, x11) with this machine's package manager."""
    for manager, command in _COMMANDS.items():
        if shutil.which(manager):
            packages = _PACKAGES[library].get(manager)
            if packages is None:
                return f"{library} comes with this system"
            if manager == "apt-get" and library == "alsa" and _has_time64_names():
                packages = "libasound2t64"
            return f"{command} {packages}"
    return f"install {library} with this system's package manager"


def _package_command() -> str:
    """Return the beginning of the command that installs a package here."""
    return next((command for manager, command in _COMMANDS.items() if shutil.which(manager)), "install")


def _has_time64_names() -> bool:
    # Debian 13 and Ubuntu 24.04 renamed some libraries for 64-bit time; installed packages show which names are in use
    return any(Path("/usr/share/doc").glob("lib*t64"))


_PROBE = """
import json, moderngl
from live.base.system.features import OFFSCREEN_GL
context = moderngl.create_context(standalone=True, **OFFSCREEN_GL)
print(json.dumps([context.info["GL_RENDERER"], context.info["GL_VERSION"], context.version_code]))
"""


@dataclass(frozen=True, slots=True)
class OpenGL:
    """OpenGL without a window: the renderer's name (None: there is none, see `why`) and version."""

    renderer: str | None
    version: str = ""
    code: int = 0
    """Version as moderngl's version code: 450 is OpenGL 4.5."""
    why: str = ""

    @property
    def software(self) -> bool:
        """Whether the CPU renders (Mesa's llvmpipe and similar)."""
        from live.render.headless import is_software_name

        return self.renderer is not None and is_software_name(self.renderer)


def probe_opengl(timeout: float = 30.0) -> OpenGL:
    """Create an offscreen context as headless shows do, and return its facts; never raise. `timeout` in [s]."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE], capture_output=True, text=True, timeout=timeout, check=False
        )
        renderer, version, code = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return OpenGL(None, why=f"the driver did not answer within {timeout:g} s")
    except ValueError:
        said = done.stderr.strip().splitlines()
        return OpenGL(None, why=said[-1] if said else f"the driver crashed (exit {done.returncode})")
    return OpenGL(renderer, version, code)


State = Literal["ok", "limited", "missing"]
OSC_ADDRESS = ("127.0.0.1", 9010)
MIN_OPENGL = 410
EXTRAS: Final = {
    "camera": "no cameras that see dancers (live play --camera)",
    "cluster": "no films by a Dask cluster (live replay --cluster)",
    "link": "no Ableton Link",
    "nodes": "no render nodes (live node, live play --nodes)",
    "usd": "no USD files of a show's motion",
    "fast": "floods of messages from phones cost more",
}
"""What is missing without an extra of the package. The other extras are for those who work on the program."""
_IN_CHECKOUT: Final = (Path(live.__file__).parents[1] / "tools" / "setup.sh").exists()
_IN_ARCHIVE: Final = (Path(sys.prefix).parent / "libraries").is_dir()
"""The folder that `make archive` builds: it has its own Python, without pip."""
_INSTALL: Final = "make play" if _IN_CHECKOUT else "pip install --upgrade choreographics-live"
_OTHER_PYTHON: Final = "use Python 3.11 or 3.12" + (": make clean play PYTHON=python3.12" if _IN_CHECKOUT else "")
_MIDI_REMEDIES: Final = {
    "'rtmidi'": _OTHER_PYTHON,
    "'alsa_midi'": _INSTALL,
    "Permission denied": "sudo usermod -aG audio $USER, and log in again",
    "no ALSA sequencer": "sudo modprobe snd-seq, or start a JACK server",
}
"""What helps against a reason why there is no MIDI, by a part of it."""
_PLATFORM: Final = re.compile(r"""sys_platform (==|!=) ['"](\w+)['"]""")
_EXTRA: Final = re.compile(r"""extra == ['"]([\w-]+)['"]""")


@dataclass(frozen=True, slots=True)
class Check:
    """One line of the table of `live doctor`.

    `limited`: shows run with the limitation in `detail`. `missing` with `needed`: no show runs before `remedy` is done.
    """

    name: str
    state: State
    detail: str
    remedy: str = ""
    needed: bool = False


def check_python() -> Check:
    """Check the Python version."""
    version = ".".join(map(str, sys.version_info[:3]))
    return Check("Python", "ok", f"{version}, {sys.executable}", needed=True)  # an older one cannot read this file


def check_packages() -> Iterator[Check]:
    """Check every Python package that the installed metadata requires for shows."""
    try:
        requirements = importlib.metadata.requires("choreographics-live") or []
    except importlib.metadata.PackageNotFoundError:
        yield Check("packages", "missing", "choreographics-live is not installed", _INSTALL, needed=True)
        return
    for requirement in requirements:
        name = re.split(r"[^\w.-]", requirement, maxsplit=1)[0]
        extra, platform = _EXTRA.search(requirement), _PLATFORM.search(requirement)
        optional = extra is not None or "python_version" in requirement
        if extra is not None and extra[1] not in EXTRAS:
            continue
        if platform is not None and (sys.platform == platform[2]) != (platform[1] == "=="):
            continue
        try:
            yield Check(name, "ok", importlib.metadata.version(name), needed=not optional)
        except importlib.metadata.PackageNotFoundError:
            if extra is not None:
                remedy = f"pip install 'choreographics-live[{extra[1]}]'"
                if _IN_CHECKOUT:
                    remedy = f".venv/bin/uv sync --frozen --inexact --extra {extra[1]}"
                elif _IN_ARCHIVE:
                    remedy = f"not in the archive: pipx install 'choreographics-live[{extra[1]}]'"
                yield Check(name, "limited", f"not installed: {EXTRAS[extra[1]]}", remedy)
            elif optional:
                detail = f"not for this Python ({requirement.partition(';')[2].strip()})"
                yield Check(name, "limited", detail, _OTHER_PYTHON)
            else:
                yield Check(name, "missing", "not installed", _INSTALL, needed=True)


def check_opengl() -> Check:
    """Check OpenGL without a window, as used by headless shows and films."""
    opengl = probe_opengl()
    if opengl.renderer is None:
        return Check("OpenGL", "missing", opengl.why, install_command("opengl"), needed=True)
    detail = f"{opengl.version}, {opengl.renderer}"
    if opengl.code < MIN_OPENGL:
        return Check("OpenGL", "missing", f"{detail}: 4.1 is needed", "install a newer graphics driver", needed=True)
    if opengl.software:
        return Check("OpenGL", "ok", f"{detail} (software: the CPU renders)", needed=True)
    return Check("OpenGL", "ok", f"{detail} (GPU)", needed=True)


def check_monitors() -> Check:
    """Check for a monitor; without one, films can still be made."""
    section = monitor_section()
    if section.why is None:
        names = [f"{item['name']} {item['width']}×{item['height']}" for item in section.items]
        return Check("monitors", "ok", ", ".join(names))
    remedy = install_command("x11") if "Failed to load" in section.why else "log in to a desktop"
    return Check("monitors", "limited", f"{section.why}; shows are written as films", remedy)


def _check_section(name: str, section: Section, limitation: str, remedy: str) -> Check:
    if section.why is None:
        return Check(name, "ok", ", ".join(str(item["name"]) for item in section.items))
    return Check(name, "limited", f"{section.why}; {limitation}", remedy)


def check_audio() -> Iterator[Check]:
    """Check PortAudio, and audio inputs and outputs."""
    try:
        version = _portaudio_version()
    except OSError as error:
        detail = f"{one_line(error)}; music files are followed silently"
        yield Check("PortAudio", "limited", detail, install_command("portaudio"))
        return
    yield Check("PortAudio", "ok", version)
    inputs, outputs = audio_sections()
    remedy = "plug in a sound card, or start PulseAudio or PipeWire"
    yield _check_section("audio in", inputs, "music can come from a file, or tempo from --bpm", remedy)
    yield _check_section("audio out", outputs, "music files are followed silently", remedy)


def _portaudio_version() -> str:
    with suppress_native_stderr():
        import sounddevice

    return str(sounddevice.get_portaudio_version()[1]).partition(",")[0]


def check_midi() -> Iterator[Check]:
    """Check MIDI inputs and outputs."""
    inputs, outputs = midi_sections()
    why = inputs.why or ""
    remedy = next((act for part, act in _MIDI_REMEDIES.items() if part in why), "plug in a MIDI device")
    if "libasound" in why:
        remedy = install_command("alsa")
    yield _check_section("MIDI in", inputs, "no MIDI control", remedy)
    yield _check_section("MIDI out", outputs, "nothing is sent over MIDI", remedy)


def check_kernels() -> Check:
    """Check whether compiled kernels are cached in a writable folder."""
    from live.app.machine.kernel_warmup import is_warm
    from live.base.disk.kernel_store import cache_root
    from live.base.jit import KERNEL_STORE, KERNEL_TARGET

    wished, used = cache_root(), KERNEL_STORE.own
    if used.parent != wished:
        remedy = "make it writable by you alone, or set LIVE_CACHE_DIR to another folder"
        return Check("kernel cache", "limited", f"{wished} cannot be used; {used} is used until reboot", remedy)
    try:
        used.mkdir(mode=0o700, parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=used):
            pass
    except OSError as error:
        return Check("kernel cache", "limited", f"{used}: {one_line(error)}; every start compiles", "free some space")
    if is_warm():
        return Check("kernel cache", "ok", f"all kernels are compiled ({KERNEL_TARGET})")
    return Check("kernel cache", "limited", f"{used} is cold: the first start takes longer", "live warm")


def check_osc_port() -> Check:
    """Check whether the default OSC port is free."""
    host, port = OSC_ADDRESS
    try:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(OSC_ADDRESS)
    except OSError as error:
        detail = f"udp {host}:{port}: {one_line(error)}"
        return Check(
            "OSC port", "limited", detail, "end the other program (another show?) or play with --osc HOST:PORT"
        )
    return Check("OSC port", "ok", f"udp {host}:{port} is free")


def check_clock() -> Check:
    """Check whether the clock's rate is disciplined, which keeps render nodes together while a network fails."""
    found = clock_discipline()
    if found.programs or found.synchronised or not sys.platform.startswith("linux"):
        return Check("clock", "ok", str(found))
    detail = "neither NTP nor PTP runs: render nodes follow the leader's clock, but drift while they are cut off"
    return Check("clock", "limited", detail, f"{_package_command()} chrony, or linuxptp where network cards have PTP")


def all_checks() -> Iterator[Check]:
    """Yield every check in table order."""
    yield check_python()
    yield from check_packages()
    yield check_opengl()
    yield check_monitors()
    yield from check_audio()
    yield from check_midi()
    yield check_kernels()
    yield check_osc_port()
    yield check_clock()
