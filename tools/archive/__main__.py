"""Build the archive for machines without Python and network into dist/: `make archive`.

The interpreter is a relocatable one from `uv python install`, which needs the network, or with `--python own` a copy of
that of .venv; the libraries are this machine's, with their licences (Debian's packages). So the archive needs the C
library of the machine that builds it, or a later one.
"""

import argparse
import gzip
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from live.base.errors import PersonError  # noqa: E402
from tools.release import artifacts, licences  # noqa: E402
from tools.release.version import read_version  # noqa: E402

HERE: Final = Path(__file__).parent
LDCONFIG: Final = "/sbin/ldconfig"
EXTRAS: Final = ("--extra=link", "--extra=fast")
LOADED: Final = (
    *("libportaudio.so.2", "libX11.so.6", "libXcursor.so.1", "libXi.so.6", "libXinerama.so.1", "libXrandr.so.2"),
    *("libXss.so.1", "libatomic.so.1", "libstdc++.so.6", "libgcc_s.so.1", "libz.so.1"),
)
"""Libraries that are loaded by name at run time, by this program, GLFW, sounddevice or wheels."""
SYSTEM: Final = re.compile(
    r"(ld-linux-x86-64|libc|libm|libmvec|libdl|librt|libpthread|libutil|libresolv|libnsl"
    r"|libGL|libEGL|libGLX|libGLdispatch|libOpenGL|libgbm|libdrm)\.so"
)
"""Libraries that are always the system's: the C library, and the graphics driver."""
ALSA_FOLDER: Final = Path("/usr/share/alsa")
ALSA: Final = ("alsa.conf", "cards", "pcm")
"""Configuration of ALSA, of the library's own source."""
NOT_NEEDED: Final = ("test", "tests", "idlelib", "tkinter", "turtledemo", "ensurepip", "lib2to3", "site-packages")
"""Folders of Python's own library that no show needs."""
TESTED: Final = ("numba", "numpy", "scipy", "llvmlite", "shapely", "pygltflib", "sacn")
"""Packages whose tests are left out."""


def run(*command: str | Path, **environment: str) -> str:
    """Return what a command prints; PersonError with its message if it fails."""
    done = subprocess.run(
        [str(part) for part in command],
        cwd=ROOT,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise PersonError(f"{command[0]} {command[1]}: {done.stderr.strip() or done.stdout.strip()}")
    return done.stdout


def check_start() -> None:
    """PersonError unless an archive may begin: a command is missing, or the documentation is not built."""
    lacking = [name for name in ("dpkg", "ldd", LDCONFIG) if shutil.which(name) is None]
    if lacking:
        raise PersonError(f"this machine lacks {', '.join(lacking)}", "build on Debian or Ubuntu")
    absent = [name for name in sorted(artifacts.SITE) if not (ROOT / name).is_file()]
    if absent:
        raise PersonError(f"the documentation is not built: {absent[0]} is missing", "make docs")


def find_interpreter(own: bool, minor: str, uv: Path, scratch: Path) -> tuple[Path, Path]:
    """Return a Python of this minor version and the folder of its library: that of .venv, or uv's, installed there."""
    if own:
        return Path(sys.executable).resolve(), Path(sysconfig.get_path("stdlib"))
    try:
        run(uv, "python", "install", "--no-bin", "--install-dir", scratch, minor)
    except PersonError as error:
        raise PersonError(error.message, 'ARGS="--python own" copies the Python of .venv instead') from None
    for prefix in scratch.glob("cpython-*"):
        if not prefix.is_symlink():
            return prefix / "bin" / f"python{minor}", prefix / "lib" / f"python{minor}"
    raise PersonError(f"uv installed no Python {minor} into {scratch}", 'ARGS="--python own" copies that of .venv')


def copy_interpreter(target: Path, own_python: bool, uv: Path, scratch: Path) -> Path:
    """Make `target` a Python of this minor version that can lie anywhere; return its licence."""
    minor = f"{sys.version_info.major}.{sys.version_info.minor}"
    binary, library = find_interpreter(own_python, minor, uv, scratch)
    print(f"{run(binary, '--version').strip()} of {'.venv' if own_python else 'uv'}", flush=True)
    ignore = shutil.ignore_patterns(
        *NOT_NEEDED, "__pycache__", "config-*", "_test*.so", "_tkinter*.so", "nis.*.so", "*.a", "sitecustomize.py",
        "dist-packages", "EXTERNALLY-MANAGED",
    )  # fmt: skip
    own = target / "lib" / f"python{minor}"
    shutil.copytree(library, own, ignore=ignore)
    (target / "bin").mkdir()
    shutil.copy(binary, target / "bin" / f"python{minor}")
    (target / "bin" / "python3").symlink_to(f"python{minor}")
    name = f"libpython{minor}.so.1.0"
    if name in run("ldd", binary):
        shutil.copy(libraries_of([binary])[name], target / "lib" / name)
    for licence in (library / "LICENSE.txt", Path(f"/usr/share/doc/libpython{minor}-minimal/copyright")):
        if licence.exists():
            return licence
    raise PersonError(f"no licence of Python beside {library}")


def libraries_of(files: Iterable[Path]) -> dict[str, Path]:
    """Return the libraries that files need, and those that these need in turn: name and path on this machine."""
    found: dict[str, Path] = {}
    for path in files:
        done = subprocess.run(["ldd", str(path)], capture_output=True, text=True, check=False)
        for name, where in re.findall(r"^\s*(\S+) => (/\S+) ", done.stdout, re.MULTILINE):
            found.setdefault(name, Path(where))
    return found


def find_loaded() -> dict[str, Path]:
    """Return name and path of the libraries that are loaded by name; PersonError if this machine lacks one."""
    known = dict(re.findall(r"^\s*(\S+) \(libc6,x86-64[^)]*\) => (\S+)$", run(LDCONFIG, "-p"), re.MULTILINE))
    lacking = [name for name in LOADED if name not in known]
    if lacking:
        raise PersonError(f"this machine lacks {', '.join(lacking)}", "install Debian's packages of them")
    return {name: Path(known[name]) for name in LOADED}


def copy_libraries(target: Path, tree: Path, texts: Path) -> list[str]:
    """Copy the libraries that the tree and `LOADED` need, each into a folder of its name; return the names.

    Libraries inside the tree (in wheels) stay where they are. `texts` gets the licences.
    """
    loaded = find_loaded()
    wanted = {**libraries_of([*tree.rglob("*.so"), *tree.rglob("*.so.*"), *loaded.values()]), **loaded}
    target.with_name("alsa").mkdir()
    names = []
    for name, path in sorted(wanted.items()):
        if SYSTEM.match(name) or path.is_relative_to(tree) or (tree / "lib" / name).exists():
            continue
        (target / name).mkdir(parents=True)
        shutil.copy(path.resolve(), target / name / name)
        owners = run("dpkg", "-S", path if owned(path) else path.resolve())
        package = owners.partition(":")[0]
        shutil.copy(f"/usr/share/doc/{package}/copyright", texts / f"{package}.txt")
        names.append(name)
    for part in ALSA:  # without its configuration ALSA ends the process
        copy = shutil.copytree if (ALSA_FOLDER / part).is_dir() else shutil.copy
        copy(ALSA_FOLDER / part, target.with_name("alsa") / part)
    return names


def owned(path: Path) -> bool:
    """Return whether a Debian package names the file under this path."""
    return subprocess.run(["dpkg", "-S", str(path)], capture_output=True, check=False).returncode == 0


def built_wheels(version: str, uv: Path, scratch: Path) -> list[Path]:
    """Build the program's wheel, and that of kernels unless dist/ has it; return both."""
    run(uv, "build", "--wheel", "--out-dir", scratch)  # not into dist/, where the release's own may lie
    tag = f"cp{sys.version_info.major}{sys.version_info.minor}"
    pattern = f"choreographics_live_kernels-{version}-{tag}-*.whl"
    if not list((ROOT / "dist").glob(pattern)):
        run(sys.executable, "tools/build_kernel_wheel.py")
    return [*scratch.glob("choreographics_live-*.whl"), *(ROOT / "dist").glob(pattern)]


def install_packages(python: Path, version: str, uv: Path, scratch: Path) -> Path:
    """Install the locked packages and the program for the interpreter; return the folder.

    PersonError if the wheel of kernels is not of these sources.
    """
    site = Path(run(python, "-c", "import site; print(site.getsitepackages()[0])").strip())
    locked = scratch / "requirements.txt"
    run(uv, "export", "-q", "--frozen", "--no-dev", "--no-emit-project", *EXTRAS, "-o", locked)
    install = (uv, "pip", "install", "--python", python, "--target", site, "--no-deps", "--link-mode=copy")
    run(*install, "--require-hashes", "--only-binary=:all:", "-r", locked)
    run(*install, *built_wheels(version, uv, scratch))
    shutil.rmtree(site / "bin", ignore_errors=True)
    for name in (
        "RECORD",
        "direct_url.json",
        "uv_cache.json",
    ):  # they tell of this machine's folders; no pip needs them
        for path in site.glob(f"*.dist-info/{name}"):
            path.unlink()
    for package in TESTED:
        for folder in (site / package).rglob("tests"):
            shutil.rmtree(folder, ignore_errors=True)
    shutil.copy(HERE / "sitecustomize.py", site)
    complete = (
        "from live.base.jit import KERNEL_SET as k; from live.base.disk.kernel_store import *; print(shipped_folder(k))"
    )
    if run(python, "-c", complete, LIVE_CACHE_DIR=str(scratch), PYTHONDONTWRITEBYTECODE="1").strip() == "None":
        raise PersonError("the wheel of kernels in dist/ is of other sources", "rm dist/choreographics_live_kernels-*")
    run(
        python,
        "-m",
        "compileall",
        "-q",
        "-f",
        "--invalidation-mode",
        "unchecked-hash",
        "-s",
        python.parents[2],
        site.parents[1],
    )
    return site


def write_licences(texts: Path, version: str, uv: Path, epoch: int) -> None:
    """Write the licence of the program and the report of those of its packages."""
    exported = run(uv, "export", "-q", "--frozen", "--no-dev", *EXTRAS, "--format", "cyclonedx1.5")
    packages = artifacts.sbom_packages(artifacts.steady_sbom(exported, epoch))
    found = licences.find_licences(packages, licences.ask_pip_licenses(Path(sys.executable)))
    (texts.parent / "licences.md").write_text(licences.licence_report(version, found), encoding="utf-8")
    shutil.copy(ROOT / "LICENSE", texts)


def pack(folder: Path, archive: Path, epoch: int) -> None:
    """Pack a folder in a fixed order, with one date and no owner."""

    def plain(member: tarfile.TarInfo) -> tarfile.TarInfo:
        member.uid = member.gid = 0
        member.uname = member.gname = ""
        member.mtime = epoch
        member.mode = 0o755 if member.isdir() or member.mode & 0o100 else 0o644
        return member

    with (
        archive.open("wb") as raw,
        gzip.GzipFile("", "wb", 6, raw, epoch) as packed,
        tarfile.open(fileobj=packed, mode="w") as tar,
    ):
        for path in [folder, *sorted(folder.rglob("*"))]:
            tar.add(path, f"{folder.name}/{path.relative_to(folder)}".removesuffix("/."), False, filter=plain)


def build(keep: Path | None, own_python: bool) -> Path:
    """Build the archive; return its path."""
    check_start()
    version, uv = read_version(ROOT), Path(sys.executable).with_name("uv")
    epoch = int(os.environ.get("SOURCE_DATE_EPOCH") or run("git", "log", "-1", "--format=%ct"))
    name = f"choreographics-live-{version}-linux-x86_64"
    with tempfile.TemporaryDirectory() as scratch_name:
        scratch = Path(scratch_name)
        folder = (keep or scratch) / name
        texts = folder / "licences"
        texts.mkdir(parents=True)
        shutil.copy(copy_interpreter(folder / "python", own_python, uv, scratch / "uv"), texts / "Python.txt")
        install_packages(folder / "python" / "bin" / "python3", version, uv, scratch)
        names = copy_libraries(folder / "libraries", folder / "python", texts)
        print(f"libraries: {' '.join(names)}", flush=True)
        write_licences(texts, version, uv, epoch)
        shutil.copy(HERE / "launcher.sh", folder / "live")
        readme = (HERE / "README.txt").read_text(encoding="utf-8")
        readme = readme.replace("{version}", version).replace("{glibc}", platform.libc_ver()[1])
        (folder / "README.txt").write_text(readme, encoding="utf-8")
        archive = ROOT / "dist" / f"{name}.tar.gz"
        pack(folder, archive, epoch)
    artifacts.write_sums(ROOT / "dist")
    return archive


def main() -> int:
    """Build; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="make archive", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="leave the unpacked files here, too")
    parser.add_argument(
        "--python", choices=("uv", "own"), default="uv", help="uv's Python, from the network, or that of .venv"
    )
    if sys.platform != "linux" or platform.machine() != "x86_64":
        print("archive: archives are made on and for Linux on x86-64", file=sys.stderr)
        return 2
    asked = parser.parse_args()
    try:
        archive = build(asked.keep, asked.python == "own")
    except PersonError as error:
        print(f"archive: {error}", file=sys.stderr)
        return 2
    print(f"{archive.relative_to(ROOT)}: {archive.stat().st_size / 1e6:.0f} MB")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
