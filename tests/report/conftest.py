"""The synthetic runs, written once, and a headless browser where the machine has one."""

import shutil

import pytest

from pipeline.report.page import write_page
from pipeline.report.record import write_run
from tests.report import synthetic


@pytest.fixture(scope="session")
def runs(tmp_path_factory):
    """`runs(name)`: folder of the synthetic run "scara" or "emps" with its page."""
    root, made = tmp_path_factory.mktemp("reports"), {}

    def folder(name):
        if name not in made:
            made[name] = write_run(root / name, *getattr(synthetic, name)())
            write_page(made[name])
        return made[name]

    return folder


@pytest.fixture(scope="session")
def browser():
    """Headless Chromium, driven by playwright."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        pytest.skip("no Chromium on the PATH: install the package chromium to test the page in a browser")
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(
            executable_path=chromium, args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
        )
        yield started
        started.close()


@pytest.fixture
def open_page(browser, runs):
    """`open_page(name, **options)`: the page of a run in a new context that lets nothing out and notes what tried."""
    contexts = []

    def opened(name, **options):
        context = browser.new_context(**{"viewport": {"width": 1280, "height": 900}, **options})
        contexts.append(context)
        page = context.new_page()
        page.requests, page.errors = [], []
        address = (runs(name) if isinstance(name, str) else name).joinpath("index.html").as_uri()
        context.route("**/*", lambda route: route.continue_() if route.request.url == address else route.abort())
        page.on("request", lambda request: page.requests.append(request.url))
        page.on("console", lambda message: page.errors.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: page.errors.append(str(error)))
        page.goto(address)
        return page

    yield opened
    for context in contexts:
        context.close()
