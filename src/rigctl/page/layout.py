"""What stands on every page: where one is, how the rig stands, and the stop."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from html import escape

from nicegui import events, ui

from rigctl.page.desk import Desk, actor
from rigctl.page.guide.rail import Rail
from rigctl.page.parts.asking import ask_reason
from rigctl.page.parts.keys import keys
from rigctl.page.parts.presence import come_back, every
from rigctl.page.parts.widgets import button
from rigctl.plain_text import require_plain
from rigctl.rig.states import LATCHED, RigState
from rigctl.rig.status import RigStatus

PLACES = (
    ("Rig", "/", "adjust"),
    ("Shots", "/shots", "smart_display"),
    ("Sweeps", "/sweeps", "timeline"),
    ("Campaigns", "/campaigns", "folder_open"),
    ("Model", "/model", "show_chart"),
)
"""Name, address, and the picture over the name where the places are tabs below a narrow screen."""
TICK_S = 0.1
BEATS = ("beat-a", "beat-b")
"""Classes that change places every 1.5 s. Each starts the same countdown anew; when none comes for
5 s, the style sheet covers the page: what it shows is not live any more."""
TICKS_A_BEAT = 15
LOOKS = ("safe", "danger", "halted")
CUT_OFF = """
const popup = document.getElementById("popup");
new MutationObserver(
  () => document.body.classList.toggle("cut-off", popup.getAttribute("aria-hidden") === "false"),
).observe(popup, { attributes: true, attributeFilter: ["aria-hidden"] });
"""
"""Marks the page while the page library says, in a window that is not shown, that it has no
connection."""
LOOK, DARK, YEAR_S = "rigctl-look", "dark", 31_536_000
"""The cookie that keeps dark or light."""
TURN = f"""(() => {{
    const dark = !document.body.classList.contains("body--dark");
    const look = dark ? "{DARK}" : "light";
    document.cookie = `{LOOK}=${{look}}; path=/; max-age={YEAR_S}; SameSite=Strict`;
    return dark;
}})()"""
"""Keeps the look that the page does not have, and returns whether it is dark."""
ANSWER_S = 20.0
"""Wait for a browser, which may be busy; after it nothing is turned."""
DANGEROUS = frozenset({RigState.ARMED, RigState.FIRING, RigState.CAPTURING})


@contextmanager
def sheet(desk: Desk, title: str, place: str) -> Iterator[Rail]:
    """Lay out a page: header, banner of a latched rig, the guide, and what the block adds."""
    desk.prepare()
    ui.page_title(f"{title} · rigctl")
    status = desk.daemon.rig.status()
    dark = ui.dark_mode(_chosen_look())
    with ui.header().classes("top deaf") as header:
        ui.label("rigctl").classes("brand")
        ui.label(title).classes("on-page").props("aria-hidden=true")
        with ui.element("nav").classes("places").props('aria-label="places"'):
            for name, target, picture in PLACES:
                link = ui.link(name, target).classes("place")
                if target == place:
                    link.classes("here").props('aria-current="page"')
                with link:
                    ui.icon(picture).classes("tab-picture")
        ui.space()
        state = ui.label().classes("chip").props("data-testid=state role=status")
        kind = "simulated rig" if status.simulated else "REAL RIG"
        about = ui.label(kind).classes("chip kind " + ("simulated" if status.simulated else "real"))
        about.props("data-testid=kind")
        about.tooltip(
            f"{status.name}: nothing real moves"
            if status.simulated
            else f"{status.name}: real spheres fly, keep clear of the tubes"
        )
        contrast = ui.button(icon="contrast", on_click=partial(_turn, dark), color=None)
        contrast.props('flat round dense aria-label="dark or light"').classes("quiet contrast")
        contrast.tooltip("dark or light")
        guide = ui.button(icon="help_outline", color=None)
        guide.props('flat round dense aria-label="guide and keys" data-testid=show-guide')
        guide.classes("quiet help").tooltip(
            "the guide: what this is and what to do, step by step; where it is shown, the keys"
        )
        stop = button("Stop", lambda: desk.stop("the page's button"), look="stop", testid="stop")
        stop.tooltip("Emergency stop: cuts the power of every actuator now. Key: Ctrl + .")
    ui.keyboard(on_key=lambda event: _on_key(desk, event), ignore=[], repeating=False)
    keys()
    come_back()
    _watchdog()
    banner = ui.element("div").classes("latched deaf").props("data-testid=latched role=alert")
    with banner:
        said = ui.label()
        button("Release …", lambda: _ask_release(desk), look="release", testid="release")

    def show() -> None:
        now = desk.daemon.rig.status()
        _show_state(state, now)
        banner.set_visibility(now.state in LATCHED)
        said.set_text(_latch(now))

    show()
    every(TICK_S, show)
    with ui.element("div").classes("sheet deaf") as below:
        ui.html(escape(title), sanitize=False, tag="h1").classes("unseen")
        rail = Rail(desk)
        guide.on_click(rail.asked)
        yield rail
    for part in (header, banner, below):
        _hear_once_connected(part)


async def _on_key(desk: Desk, event: events.KeyEventArguments) -> None:
    if event.action.keydown and event.modifiers.ctrl and event.key == ".":
        await desk.stop("the page's key")


def _chosen_look() -> bool | None:
    """Return whether this browser was turned dark; None: what it prefers counts."""
    request = ui.context.client.request
    chosen = request.cookies.get(LOOK) if request is not None else None
    return None if chosen is None else chosen == DARK


async def _turn(dark: ui.dark_mode) -> None:
    """Turn dark and light about, and keep the choice in the browser for all pages.

    It is kept before it is shown: a page that is opened at once has it.
    """
    dark.set_value(await ui.run_javascript(TURN, timeout=ANSWER_S))


def _hear_once_connected(part: ui.element) -> None:
    """Let something be pressed as soon as the daemon hears it; before, it would be lost."""
    ui.context.client.on_connect(lambda: part.classes(remove="deaf"))


def _watchdog() -> None:
    # The page library's window stands below this in the document.
    ui.add_body_html(f'<script type="module">{CUT_OFF}</script>')
    watch = ui.element("div").classes(f"watch {BEATS[0]}").props("aria-hidden=true")
    with watch:
        ui.label("No news from the daemon: nothing on this page is live.").classes("loud")
        ui.label(
            "To stop the rig, use the switch that stands beside it. The page goes on by itself "
            "when the daemon answers again; if it was started anew with another key, open the "
            "address that it prints."
        )
    beat = 0

    def tick() -> None:
        nonlocal beat
        watch.classes(remove=BEATS[beat % 2], add=BEATS[(beat + 1) % 2])
        beat += 1

    every(TICK_S * TICKS_A_BEAT, tick)


def _show_state(chip: ui.label, status: RigStatus) -> None:
    text = str(status.state).replace("_", " ")
    if status.running:
        text += f", shot {int(status.running.rpartition('-')[2])}"
    chip.set_text(text)
    look = "safe"
    if status.state in LATCHED:
        look = "halted"
    elif status.state in DANGEROUS:
        look = "danger"
    # A change of classes redraws the page even where it changes nothing.
    if look not in chip.classes:
        chip.classes(remove=" ".join(LOOKS), add=look)


def _latch(status: RigStatus) -> str:
    words = {
        RigState.ESTOP: "Emergency stop. The power of every actuator is cut",
        RigState.FAULT: "A device failed. The rig does not arm",
        RigState.UNKNOWN_OUTCOME: "Nobody can say whether the last shot fired",
    }.get(status.state, "")
    return f"{words}: {status.latch_reason}. Look at the rig, then release it with a reason."


def _ask_release(desk: Desk) -> None:
    async def release(why: str) -> bool:
        who = actor()

        def call() -> None:
            require_plain(why, "reason")
            desk.daemon.rig.release(who, why)

        return await desk.done(call, moves=True)

    ask_reason(
        "Release the rig",
        "Power comes back. Say what was found at the rig and what was done; the reason is "
        "journalled.",
        "Release",
        release,
    )
