"""The pose models: taken from a package by their hashes, once, into the user's folder; nothing is downloaded later.

The models are MediaPipe's (Apache-2.0). One npm package holds them for the camera process and for phones, together
with the program that runs them in a phone's browser.
"""

import base64
import hashlib
import io
import os
import tarfile
import tempfile
import urllib.error
import urllib.request
import zipfile
from pathlib import Path
from typing import Final

import platformdirs

from live.base.errors import PersonError

PACKAGE: Final = "@mediapipe/pose 0.5.1675469404"
PACKAGE_PATH: Final = "/@mediapipe/pose/-/pose-0.5.1675469404.tgz"
REGISTRY: Final = "https://registry.npmjs.org"
_NPM_VARIABLE: Final = "npm_config_registry"
PACKAGE_SHA512: Final = "DFZsNWTsSphRIZppnUCuunzBiHP2FdJXR9ehc7mMi4KG+oPaOH0Em3d6kr7Py+TSyTXC1doH88KcF28k2sBxsQ=="
"""As npm writes it: base64."""
MOST_BYTES: Final = 100_000_000
"""Largest file that is read as a package."""
FOLDER_VARIABLE: Final = "LIVE_POSE_MODELS"
"""Environment variable: another folder with the models."""

DETECTOR: Final = "pose_detection.tflite"
FULL: Final = "pose_landmark_full.tflite"
LITE: Final = "pose_landmark_lite.tflite"
PHONE_FILES: Final = (
    "pose.js", "pose_web.binarypb", "pose_solution_packed_assets.data", "pose_solution_packed_assets_loader.js",
    "pose_solution_simd_wasm_bin.data", "pose_solution_simd_wasm_bin.js", "pose_solution_simd_wasm_bin.wasm",
    "pose_solution_wasm_bin.js", "pose_solution_wasm_bin.wasm", LITE, FULL,
)  # fmt: skip
"""What a phone's browser loads."""
FILES: Final = {
    DETECTOR: "a63c614bef30d35947f13be361820b1e4e3bec9cfeebf4d11216a18373108e85",
    "pose.js": "fcb703afcce65d0a1c540f6a70c3bb45fc84521498c21a9d4160265dde648ab4",
    "pose_web.binarypb": "dc8efd1c2d62007b34278467407fda5f70847f41310e0e39f0f59fc17b1d01f7",
    "pose_solution_packed_assets.data": "a63c614bef30d35947f13be361820b1e4e3bec9cfeebf4d11216a18373108e85",
    "pose_solution_packed_assets_loader.js": "d7aa29b7d8e11b5c97a58d719e982dd15c2de72995d95112d60492b854840a36",
    "pose_solution_simd_wasm_bin.data": "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
    "pose_solution_simd_wasm_bin.js": "3983d1dca31d945d81abb70b18dd61f28ef4736e112463d7cfb1cbadef588127",
    "pose_solution_simd_wasm_bin.wasm": "195a929430e2ce130b3efb82e64ba27c8e68cb0f6bad870b715688060ea6f7e2",
    "pose_solution_wasm_bin.js": "3fcfd9574a04fcf4a0b9271b9b4429c6b9a70278300a5e54c45ddf2001e41422",
    "pose_solution_wasm_bin.wasm": "a5589369289e1f1e007c106e8ffb26e85a5be762c6db9551ed36213f8f58378d",
    LITE: "f17bfbecadb61c3be1baa8b8d851cc6619c870a87167b32848ad20db306b9d61",
    FULL: "e9a5c5cb17f736fafd4c2ec1da3b3d331d6edbe8a0d32395855aeb2cdfd64b9f",
}
"""SHA-256 of each file."""
_WHEEL_DETECTOR: Final = "9ba9dd3d42efaaba86b4ff0122b06f29c4122e756b329d89dca1e297fd8f866c"
"""SHA-256 of the same detector as the `mediapipe` 0.10.21 wheel holds it."""
_WHEEL_FILES: Final = {
    "mediapipe/modules/pose_detection/pose_detection.tflite": DETECTOR,
    "mediapipe/modules/pose_landmark/pose_landmark_full.tflite": FULL,
}
NOTICE: Final = f"""BlazePose models and the program that runs them in a browser, by the MediaPipe Authors
(Copyright 2020-2023 Google LLC), from the npm package {PACKAGE} or the Python package mediapipe 0.10.21.
Licensed under the Apache License, Version 2.0: https://www.apache.org/licenses/LICENSE-2.0
Unchanged. They are distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND.
"""


def installed_folder() -> Path:
    """Return the folder in which the models lie, or are put."""
    named = os.environ.get(FOLDER_VARIABLE)
    return Path(named) if named else Path(platformdirs.user_data_dir("choreographics-live")) / "pose-models"


def model_folder() -> Path | None:
    """Return the folder with the camera's models; None if they are not installed. It reads no file."""
    folder = installed_folder()
    return folder if all((folder / name).is_file() for name in (DETECTOR, FULL)) else None


def phone_folder() -> Path | None:
    """Return the folder with what a phone's browser loads; None if it is not installed. It reads no file."""
    folder = installed_folder()
    return folder if all((folder / name).is_file() for name in PHONE_FILES) else None


def checked_model(name: str) -> Path:
    """Return the path of an installed model; PersonError if it is missing or is not the known file."""
    path = installed_folder() / name
    try:
        digest = hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        raise PersonError("the camera's pose models are not installed", "live camera models") from None
    if digest not in (FILES[name], _WHEEL_DETECTOR if name == DETECTOR else ""):
        raise PersonError(f"{path} is damaged", "live camera models --again")
    return path


def install_models(source: str | None = None) -> Path:
    """Install the models from a package and return their folder; PersonError if that is not possible.

    `source`: the package as a file (the npm package, or the `mediapipe` wheel, which has nothing for phones); left out:
    it is downloaded.
    """
    data = _download() if source is None else _read(Path(source))
    files = _wheel_files(data, source) if data[:2] == b"PK" else _npm_files(data, source)
    for name, content in files.items():
        known = (FILES[name], _WHEEL_DETECTOR if name == DETECTOR else "")
        if hashlib.sha256(content).hexdigest() not in known:
            raise PersonError(f"{name} in {source or PACKAGE} is not the known file", f"get {PACKAGE} again")
    folder = installed_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in {**files, "NOTICE": NOTICE.encode()}.items():
            _write(folder / name, content)
    except OSError as error:
        raise PersonError(f"the models cannot be written to {folder}: {error.strerror}", FOLDER_VARIABLE) from None
    return folder


def _write(path: Path, content: bytes) -> None:
    """Write a file so that another process sees it whole or not at all."""
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=".models-")
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except BaseException:
        os.unlink(name)
        raise


def _registry() -> str:
    named = os.environ.get("NPM_CONFIG_REGISTRY") or os.environ.get(_NPM_VARIABLE) or REGISTRY
    return named.rstrip("/")


def _download() -> bytes:
    address = _registry() + PACKAGE_PATH
    if not address.startswith(("https://", "http://127.0.0.1", "http://localhost")):
        raise PersonError(f"{address} is not an https address", "npm_config_registry")
    try:
        with urllib.request.urlopen(address, timeout=60) as answer:
            data: bytes = answer.read(MOST_BYTES + 1)
    except (urllib.error.URLError, OSError, ValueError) as error:
        raise PersonError(
            f"{address} cannot be downloaded: {getattr(error, 'reason', error)}",
            "download it on another machine, then: live camera models --from FILE",
        ) from None
    if base64.b64encode(hashlib.sha512(data).digest()).decode() != PACKAGE_SHA512:
        raise PersonError(f"{address} is not the known package (its hash differs)", "nothing was installed")
    return data


def _read(path: Path) -> bytes:
    try:
        if path.stat().st_size > MOST_BYTES:
            raise PersonError(f"{path} is too large for {PACKAGE}", "--from")
        return path.read_bytes()
    except OSError as error:
        raise PersonError(f"{path} cannot be read: {error.strerror}", "--from") from None


def _npm_files(data: bytes, source: str | None) -> dict[str, bytes]:
    found: dict[str, bytes] = {}
    try:
        with tarfile.open(fileobj=io.BytesIO(data), mode="r:gz") as archive:
            for entry in archive:
                name = entry.name.removeprefix("package/")
                if name in FILES and entry.isfile() and entry.size <= MOST_BYTES:
                    file = archive.extractfile(entry)
                    found[name] = b"" if file is None else file.read()
    except (tarfile.TarError, OSError, EOFError) as error:
        raise PersonError(f"{source or PACKAGE} is no package of npm: {error}", "--from") from None
    packed = found.get("pose_solution_packed_assets.data")
    if packed is not None:
        found[DETECTOR] = packed  # the browser's package of assets is this one file
    missing = sorted(FILES.keys() - found.keys())
    if missing:
        raise PersonError(f"{source or PACKAGE} lacks {missing[0]}", f"{PACKAGE} has it")
    return found


def _wheel_files(data: bytes, source: str | None) -> dict[str, bytes]:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            return {name: archive.read(path) for path, name in _WHEEL_FILES.items()}
    except (zipfile.BadZipFile, KeyError, OSError) as error:
        raise PersonError(f"{source} is no wheel of mediapipe 0.10: {error}", "--from") from None


def models_report() -> str:
    """Return what is installed, as a line for a person."""
    folder = installed_folder()
    state = "for cameras and phones" if phone_folder() else "for cameras" if model_folder() else "not installed"
    return f"pose models: {state} ({folder})"
