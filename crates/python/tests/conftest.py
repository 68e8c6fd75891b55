"""What the tests share."""

import os
import pathlib

import numpy as np
import pytest

import ppnpack

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]


def _fail_what_is_skipped(report):
    """What cannot be tested is a failure where CI is set."""
    if report.skipped and os.environ.get("CI"):
        report.outcome = "failed"


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    _fail_what_is_skipped(report)
    return report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector):
    report = yield
    _fail_what_is_skipped(report)
    return report


@pytest.fixture(scope="session")
def grid():
    return ppnpack.Grid.reference()


@pytest.fixture(scope="session")
def catalogue(grid):
    return ppnpack.Catalogue(grid)


@pytest.fixture(scope="session")
def block():
    """A block of 6 x 4 cells, 25 units high, at four yaws that look the same."""
    top = np.full((6, 4), 25, np.int16)
    return ppnpack.Item("block", [top] * 4, [np.zeros_like(top)] * 4)


@pytest.fixture(scope="session")
def program():
    """The command `ppnpack`, where it is built."""
    named = os.environ.get("PPNPACK_PROGRAM", "")
    if not pathlib.Path(named).is_file():
        assert "CI" not in os.environ, f"PPNPACK_PROGRAM names no program: {named!r}"
        pytest.skip(f"PPNPACK_PROGRAM names no program ({named!r}): cargo build --bin ppnpack, and run scripts/test-python")
    return named


@pytest.fixture(scope="session")
def shared():
    """The folder of data beside the repository."""
    folder = REPOSITORY.parent / "shared"
    if not folder.is_dir():
        assert "CI" not in os.environ, f"{folder} is absent"
        pytest.skip(f"{folder} is absent")
    return folder
