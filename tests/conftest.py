"""What all tests share: fixed seeds, strict floating point, the path of the test data, golden pictures."""

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from PIL import Image

GOLDENS = Path(__file__).resolve().parent / "goldens"
SHARED = Path(__file__).resolve().parents[2] / "shared"

Picture = npt.NDArray[np.uint8]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regenerate-goldens", action="store_true", help="write the golden pictures anew")


@pytest.fixture(autouse=True)
def fixed_seeds() -> Iterator[None]:
    """The same random numbers for each test, whatever ran before; floating point errors raise.

    Not underflow: the square of a tiny number may be zero.
    """
    random.seed(0)
    np.random.seed(0)  # noqa: NPY002 - for libraries that still draw from the global generator
    with np.errstate(all="raise", under="ignore"):
        yield


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of shared test data beside the repository; skips where it is absent."""
    if not SHARED.is_dir():
        pytest.skip("the shared test data is not beside the repository")
    return SHARED


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[..., None]:
    """Compare a picture (H, W, 3) with `tests/goldens/NAME.png`: `golden(picture, "name", worst=..., mean=...)`.

    A step is 1 of 255. On failure the difference, eight times enlarged, is written beside the golden picture.
    """

    def compare(picture: Picture, name: str, *, mean: float = 0.5, worst: int = 48) -> None:
        path = GOLDENS / f"{name}.png"
        if request.config.getoption("--regenerate-goldens"):
            GOLDENS.mkdir(exist_ok=True)
            Image.fromarray(picture).save(path, optimize=True)
            return
        if not path.exists():
            pytest.fail(f"{path} is missing; run pytest --regenerate-goldens, look at it and commit it")
        expected = np.asarray(Image.open(path).convert("RGB"))
        assert picture.shape == expected.shape
        difference = np.abs(picture.astype(np.int16) - expected.astype(np.int16))
        if difference.mean() > mean or difference.max() > worst:
            where = GOLDENS / f"{name}.diff.png"
            Image.fromarray(np.minimum(difference * 8, 255).astype(np.uint8)).save(where)
            pytest.fail(
                f"{name}: differs by {difference.mean():.2f} steps on average (allowed {mean}), "
                f"{difference.max()} at worst (allowed {worst}); see {where}"
            )

    return compare
