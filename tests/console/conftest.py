"""What the tests of the operator's page share."""

import os
import pathlib
import shutil
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import sync_playwright

import mock
import stack as stacks

PROGRAMS = ["ppnpack", *(f"ppnpack-{name}" for name in ("router", "heuristic", "perception", "bridge", "planner", "console"))]
DESKTOP = {"width": 1440, "height": 900}
PORTRAIT = {"width": 834, "height": 1194}
LANDSCAPE = {"width": 1194, "height": 834}
PHONE = {"width": 390, "height": 844}


def pytest_addoption(parser):
    parser.addoption("--pictures", type=pathlib.Path, help="a folder for screenshots")


@pytest.fixture(scope="session")
def programs():
    """The folder of the programs."""
    folder = pathlib.Path(os.environ.get("PPNPACK_PROGRAMS", ""))
    missing = [name for name in PROGRAMS if not (folder / name).is_file()]
    assert not missing, f"PPNPACK_PROGRAMS ({folder}) lacks {', '.join(missing)}: cargo build --workspace --bins"
    return folder


@pytest.fixture(scope="session")
def browser():
    program = os.environ.get("PPNPACK_CHROMIUM") or shutil.which("chromium")
    assert program, "missing: chromium; get it with: apt-get install chromium"
    # Software draws WebGL. The sandbox needs rights that root in a container has not.
    options = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", *(["--no-sandbox"] if os.geteuid() == 0 else [])]
    with sync_playwright() as playwright:
        made = playwright.chromium.launch(executable_path=program, args=options)
        yield made
        made.close()


@pytest.fixture
def open_page(browser):
    """Opens the page at an address. Whatever the test is of: nothing is fetched from elsewhere, and no script fails."""
    contexts, faults = [], []

    def opened(url, viewport=DESKTOP, **options):
        context = browser.new_context(viewport=viewport, reduced_motion="reduce", **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(10_000)
        origin = urlsplit(url).netloc

        def asked(request):
            if urlsplit(request.url).scheme != "data" and urlsplit(request.url).netloc != origin:
                faults.append(f"asked for {request.url}")

        def said(message):
            # What the server refuses, and what is not there while it is away, is said there too.
            if message.type == "error" and "Failed to load resource" not in message.text:
                faults.append(message.text)

        page.on("request", asked)
        page.on("console", said)
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.goto(url)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert faults == []


@pytest.fixture
def picture(request):
    """Keeps a screenshot, where a folder is given for them."""
    folder = request.config.getoption("--pictures")

    def taken(page, name):
        if folder:
            folder.mkdir(parents=True, exist_ok=True)
            page.evaluate("new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
            page.screenshot(path=folder / f"{name}.png")

    return taken


@pytest.fixture
def console():
    """A console that says what the test says."""
    with mock.Console() as made:
        yield made


@pytest.fixture(scope="module")
def stack(programs, tmp_path_factory):
    """Services as processes of their own, with a console that has a token."""
    made = stacks.Stack(programs, tmp_path_factory.mktemp("stack"))
    try:
        made.start()
        yield made
    finally:
        made.end()


@pytest.fixture(scope="module")
def up(programs, tmp_path_factory):
    """All in one process, without controls."""
    made = stacks.Up(programs, tmp_path_factory.mktemp("up"))
    yield made
    made.end()
