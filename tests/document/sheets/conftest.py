"""One run of the small show for all tests of sheets, which one process runs (`xdist_group`)."""

from pathlib import Path

import pytest

from live.document.sheets.sheet_book import SheetBook
from live.show.loader import LoadedShow
from tests.document.sheets.small_show import loaded_small, small_book


@pytest.fixture(scope="session")
def small_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("small")


@pytest.fixture(scope="session")
def loaded(small_folder: Path) -> LoadedShow:
    return loaded_small(small_folder)


@pytest.fixture(scope="session")
def book(small_folder: Path) -> SheetBook:
    return small_book(small_folder)
