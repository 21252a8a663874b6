"""A daemon of its own on a free port, and Chromium in front of it."""

from __future__ import annotations

import signal
import subprocess
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Locator, Page, Request, expect, sync_playwright
from playwright.sync_api import TimeoutError as NothingHappenedError

from benchmarks.page_served import CHROMIUM, KEY, SWITCHES, started
from tests.simulated import patient_text

WAIT_S = 60.0
EXPECT_MS = 60_000
"""A busy host draws slowly; what is expected sooner says so."""
FIRST_USE_MS = 400_000
"""Of what waits for the first analysis on a machine: a busy one compiles for four minutes."""
expect.set_options(timeout=EXPECT_MS)
WIDE = {"width": 1280, "height": 800}
SIMULATED = Path(__file__).parents[2] / "config" / "simulated.toml"
OWN_EFFECT = """\
from dataclasses import replace

from analysis.effects.effect import ContactEffect, Parameter


def wrap(operator, values):
    def changed(encounter):
        warmth = encounter.covariates["temperature_c"] - 23.0
        return operator(replace(encounter, e=encounter.e * (1.0 + values[0] * warmth)))

    return changed


EFFECT = ContactEffect(
    name="restitution-warmth", title="Warm nylon",
    parameters=(Parameter("a", "1/K", "change of e per kelvin", (-0.02, 0.02)),),
    formula="e = e0 [1 + a (T - 23 C)]", source="a handbook", gives_away="follows temperature_c",
    wrap=wrap,
)
"""
PLAIN = {"pressure_a_kpa": "40", "pressure_b_kpa": "40", "offset_mm": "6", "delay_us": "0"}
HEARD = "window.did_handshake"
DRAWS = """() => new Promise((answer) => {
  requestAnimationFrame(() => answer(true));
  setTimeout(() => answer(false), 20000);
})"""
LOOPBACK = {"127.0.0.1", None}


@dataclass
class Served:
    """A running daemon: its address, its folder, its process and options but for the port."""

    url: str
    folder: Path
    process: subprocess.Popen[str]
    options: tuple[str, ...] = ()

    @classmethod
    def start(cls, folder: Path, *options: str, port: int = 0) -> Served:
        """Start a daemon and wait for the address that it prints."""
        process, url = started(folder, (*options, "--port", str(port)))
        return cls(url, folder, process, options)

    def start_again(self) -> None:
        """Start a daemon at the same address once this one has ended."""
        self.end()
        again = self.start(self.folder, *self.options, port=urlsplit(self.url).port or 0)
        self.process = again.process

    def end(self) -> None:
        """End it; a killed or halted one as well."""
        self.process.send_signal(signal.SIGCONT)
        self.process.terminate()
        self.process.communicate(timeout=WAIT_S)


def patient_configuration() -> str:
    """Return the default configuration with as long a wait for frames as a busy host needs."""
    return patient_text(SIMULATED.read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """Serve all modules that mind no shots and no fits of each other: a start costs some seconds.

    The daemon has a folder of the user's own effects, of which one is of no use, and waits for
    frames as long as a busy host needs: a shot that is aborted is one too few for a page.
    """
    folder = tmp_path_factory.mktemp("shared")
    (folder / "effects").mkdir()
    (folder / "effects" / "warmth.py").write_text(OWN_EFFECT)
    (folder / "effects" / "unfinished.py").write_text("import numpy\n\nEFFECT = numpy.nothing\n")
    (folder / "rig.toml").write_text(patient_configuration(), encoding="utf-8")
    running = Served.start(folder, "--config", "rig.toml", "--effects", "effects")
    yield running
    running.end()


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """Launch it once for these tests: while it is open, no other test can run an event loop."""
    if CHROMIUM is None:
        pytest.skip("no Chromium is installed")
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=CHROMIUM, args=SWITCHES)
        yield opened
        opened.close()


@pytest.fixture(scope="package")
def tabs(browser: Browser) -> list[Page]:
    """Open a tab; the last of them is used."""
    return [new_tab(browser)]


def new_tab(browser: Browser) -> Page:
    """Open a tab with a context of its own."""
    opened = browser.new_context(viewport=WIDE).new_page()
    opened.set_default_timeout(1e3 * WAIT_S)
    return opened


@pytest.fixture
def tab(browser: Browser, tabs: list[Page]) -> Page:
    """Return the tab that all tests use: one that has not read the page's scripts needs seconds."""
    if not tabs[-1].evaluate(DRAWS):
        tabs.append(new_tab(browser))
    return tabs[-1]


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> Generator[None, object, object]:
    """Run a test again, in another tab, if the browser has stopped drawing the one that it had.

    Of some thousands of addresses that a tab of a busy host opens, one is never drawn, nor is what
    it opens later: no page can mend that, and nothing in it can be pressed.
    """
    try:
        return (yield)
    except (AssertionError, NothingHappenedError):
        page = pyfuncitem.funcargs.get("page")
        if not isinstance(page, Page) or page.evaluate(DRAWS) or page.context.browser is None:
            raise
        names = signature(pyfuncitem.obj).parameters
        given = {name: pyfuncitem.funcargs[name] for name in names}
        own = urlsplit(page.url)
        with entered(new_tab(page.context.browser), f"{own.scheme}://{own.netloc}") as fresh:
            pyfuncitem.obj(**{**given, "page": fresh})
        return True


@contextmanager
def entered(tab: Page, url: str) -> Iterator[Page]:
    """Open an address with its key as a person who never was there."""
    tab.context.clear_cookies()
    tab.emulate_media(color_scheme="null", reduced_motion="null")
    tab.set_viewport_size(WIDE)
    visit(tab, f"{url}/?key={KEY}")
    tab.get_by_test_id("state").wait_for()
    yield tab
    if tab.url.startswith(url):
        tab.evaluate("localStorage.clear(); sessionStorage.clear()")
    for other in tab.context.pages:
        if other is not tab:
            other.close()


@pytest.fixture
def page(tab: Page, served: Served) -> Iterator[Page]:
    """Open the address that the daemon prints; whatever is asked for must come from loopback."""
    asked: list[str] = []

    def note(request: Request) -> None:
        asked.append(request.url)

    tab.on("request", note)
    with entered(tab, served.url):
        yield tab
    tab.remove_listener("request", note)
    assert asked
    strangers = [
        url
        for url in asked
        if urlsplit(url).scheme not in {"data", "blob"} and urlsplit(url).hostname not in LOOPBACK
    ]
    assert strangers == []


def visit(page: Page, url: str) -> None:
    """Open an address of a daemon and wait until it hears the page.

    What is clicked or typed before is kept by the page library and sent in any order once it does:
    of two texts in one field the first may be the one that counts.
    """
    page.goto(url)
    page.wait_for_function(HEARD)


def fire(page: Page) -> None:
    """Fire a plain shot; the form begins with what the rig was set to by whoever used it before."""
    for field, value in PLAIN.items():
        type_in(page.get_by_test_id(field), value)
    page.get_by_test_id("arm").click()
    page.get_by_test_id("fire").click()


def type_in(field: Locator, text: str) -> None:
    """Fill a field until it shows the text, as a person looks at what came of the keys.

    Keys may be lost as a press is: they go to what has the focus, which a busy host may take away.
    """
    field.page.wait_for_function(HEARD)
    field.fill(text)
    try:
        expect(field).to_have_value(text, timeout=0.1 * EXPECT_MS)
    except AssertionError:
        field.fill(text)


def answer(page: Page, testid: str) -> None:
    """Press the button of a dialog that does what it asks about, until the dialog has closed.

    A press may be lost, and a person presses again: a browser drops one whose button a busy host
    redraws, or covers, between its two halves. The dialog stays open then.
    """
    button = page.get_by_test_id(testid)
    button.click()
    try:
        button.wait_for(state="detached", timeout=0.5 * EXPECT_MS)
    except NothingHappenedError:
        button.click()


def abort_sweep(page: Page) -> None:
    """Press what aborts a sweep, and what its dialog asks for."""
    page.get_by_test_id("abort").click()
    answer(page, "abort-now")
