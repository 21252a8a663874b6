"""The four steps of the first visit on top of every page, with what to do now.

Whether a browser wants them says one cookie, set when it does not.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import Enum, auto

from nicegui import context, ui

from rigctl.page.desk import Desk
from rigctl.page.parts.following import following
from rigctl.page.parts.keys import list_keys
from rigctl.page.parts.widgets import button
from rigctl.page.sweeps.broad import broad_sweep
from rigctl.page.sweeps.form import form_address
from rigctl.rig.states import RigState
from rigctl.rig.status import RigStatus
from rigctl.store import CampaignRecord, ShotState, SweepState

COOKIE = "rigctl_guide"
HIDDEN = "hidden"
YEAR_S = 365 * 86_400


def wanted() -> bool:
    """Say whether the guide is shown on the page that is being built."""
    return context.client.request.cookies.get(COOKIE) != HIDDEN


def keep(*, shown: bool) -> None:
    """Remember in this browser whether the guide is shown from the next page on."""
    value, age = ("", 0) if shown else (HIDDEN, YEAR_S)
    ui.run_javascript(f'document.cookie = "{COOKIE}={value}; path=/; max-age={age}; SameSite=Lax"')


ENOUGH = 20
"""So many measured shots of one campaign are compared with the model; fewer seldom tell anything.
Of the thirty that the guide has fired some may be refused."""
STEPS = (
    ("Fire a shot", "10 s; the first ever on a computer takes minutes"),
    ("Read what was measured", "bounce, sliding, spin"),
    ("Let it fire 30 more", "by itself, some minutes"),
    ("Find what the model misses", "watch the error fall"),
)
FIRE, READ, SWEEP, COMPARE = range(1, len(STEPS) + 1)
OVER = len(STEPS) + 1


class Found(Enum):
    """What the comparison on this page has come to.

    `waits`: no answer yet. `missing`: an effect would lower the error, and none was added.
    `more`: one was added, and another would lower it further. `ended`: nothing that could be added
    is left; `explained`: so with what was added.
    """

    WAITS = auto()
    MISSING = auto()
    MORE = auto()
    ENDED = auto()
    EXPLAINED = auto()


@dataclass(frozen=True, slots=True)
class Progress:
    """Where the visit stands.

    Attributes
    ----------
    step
        The next step, 1 to 4; 5 when all are done.
    campaign
        The campaign of the store with most measured shots; empty while there is none.
    measured, fired
        Its measured shots, and all of them.
    elsewhere
        Whether what was compared was fired elsewhere: no shot of this rig is measured.
    found
        What the comparison has come to.
    """

    step: int
    campaign: str = ""
    measured: int = 0
    fired: int = 0
    elsewhere: bool = False
    found: Found = Found.WAITS

    def is_done(self, step: int) -> bool:
        """Say whether a step was taken here."""
        return step < self.step and not (self.elsewhere and step < COMPARE)


def progress_of(
    campaigns: Sequence[CampaignRecord], *, any_measured: bool, found: Found = Found.WAITS
) -> Progress:
    """Return where the visit stands.

    Parameters
    ----------
    campaigns
        Of the store.
    any_measured
        Whether any shot is measured, of a campaign or of none.
    found
        What the comparison of a campaign with its model, on this page, has come to.
    """
    if found is not Found.WAITS:
        step = COMPARE if found in {Found.MISSING, Found.MORE} else OVER
        return Progress(step, elsewhere=not any_measured, found=found)
    counted = [(one.states.get(ShotState.ANALYSED, 0), one) for one in campaigns]
    measured, best = max(counted, key=lambda pair: pair[0], default=(0, None))
    if best is None:
        return Progress(READ if any_measured else FIRE)
    if measured >= ENOUGH:
        step = COMPARE
    elif measured and best.shots > 1:
        step = SWEEP
    else:
        step = READ if any_measured else FIRE
    return Progress(step, best.name, measured, best.shots)


MEASURES = frozenset({ShotState.STORED, ShotState.ANALYSING})
ARMED_NOW = "The rig is armed: now press Fire. Disarm gives up, and nothing is fired."
NOW = {
    RigState.CHECKED: ARMED_NOW,
    RigState.ARMED: ARMED_NOW,
    RigState.FIRING: "Fired: the spheres fly and the camera films them.",
    RigState.CAPTURING: "Fired: the spheres fly and the camera films them.",
}
MEASURED_NOW = "The film is there. Its pictures are measured now: the numbers come by themselves."
REFUSED_NOW = (
    "The shot was not measured. Why, and what helps, stands with its film: set that, then press "
    "Arm and Fire again."
)


def first_words(status: RigStatus) -> str:
    """Return what to do for the first shot, or what is done with it just now."""
    if status.state in NOW:
        return NOW[status.state]
    if status.last_shot is not None and status.last_shot.state in MEASURES:
        return MEASURED_NOW
    if status.last_shot is not None and status.last_shot.state is ShotState.REFUSED:
        return REFUSED_NOW
    return "Good values are filled in: press Arm, then Fire. Nothing moves before you arm."


LOOK_S = 0.5
CAMPAIGN = "first"
SWEEPS = "/sweeps"
RUNS = frozenset({SweepState.RUNNING, SweepState.PAUSED})
COMPARED = {
    Found.MISSING: "Something is missing in the model. Step 3 below says what would explain it: "
    "add it, and the error falls.",
    Found.MORE: "That is added. Something more is still missing: look again at step 3 below.",
    Found.ENDED: "The verdict below says what these shots show, and what they cannot.",
    Found.EXPLAINED: "What was missing is found and added: the verdict below says how far the "
    "error fell.",
}
"""What to do once a campaign stands beside its model, by what that has come to."""


class Rail:
    """The steps, the present one marked, and one sentence with one button; nothing if not wanted.

    Parameters
    ----------
    desk
        What the page works with.
    """

    def __init__(self, desk: Desk) -> None:
        self._desk, self._place = desk, context.client.request.url.path
        self._found, self._heard, self._shown = Found.WAITS, -1, wanted()
        self._more: list[Callable[[], object]] = []
        self._now = self._stand() if self._shown else Progress(FIRE)
        with ui.element("div").classes("stack wide") as self._box:
            self._show()
        self._box.set_visibility(self._shown)
        following(LOOK_S, self._follow)

    def with_it(self, place: Callable[[], None]) -> None:
        """Have `place` put something here whenever the guide is shown, and take it away with it."""

        @ui.refreshable
        def shown() -> None:
            if self._shown:
                place()

        shown()
        self._more.append(shown.refresh)

    def asked(self) -> None:
        """Bring the guide back; list the keys where it is shown. Nothing else is drawn anew."""
        if self._shown:
            list_keys()
        else:
            self._switch(shown=True)

    def compared(self, found: Found) -> None:
        """Say what the comparison on this page has come to; at its end the guide goes.

        It is gone from the next page on.
        """
        if found is self._found:
            return
        self._found = found
        if self._shown:
            self._now = self._stand()
            self._show.refresh()
            if self._now.step == OVER:
                keep(shown=False)

    def _switch(self, *, shown: bool) -> None:
        self._shown, self._now = shown, self._stand()
        keep(shown=shown)
        self._box.set_visibility(shown)
        self._show.refresh()
        for draw in self._more:
            draw()

    def _stand(self) -> Progress:
        self._heard = self._desk.feed.told
        now = progress_of(
            self._desk.feed.shared("campaigns", self._desk.daemon.store.campaigns.all),
            any_measured=any_measured(self._desk),
            found=self._found,
        )
        # Who is at the form of a sweep has read the shot.
        return replace(now, step=SWEEP) if now.step == READ and self._place == SWEEPS else now

    def _follow(self) -> None:
        if not self._shown or self._heard == self._desk.feed.told:
            return
        if (now := self._stand()) == self._now:
            self._say()
            return
        self._now = now
        self._show.refresh()

    def _say(self) -> None:
        """Say what to do now; new words cost less than steps that are drawn anew."""
        self._said.set_text(self._sentence())

    @ui.refreshable_method
    def _show(self) -> None:
        if not self._shown:
            return
        if self._place == "/":
            with ui.element("div").classes("claim"):
                ui.label("Shoot two spheres at each other.")
                ui.label("Find the law of physics that the model forgot.")
        with ui.element("section").classes("guide").props('aria-label="guide" data-testid=guide'):
            with ui.element("ol").classes("way"):
                for number, (name, about) in enumerate(STEPS, start=1):
                    self._step(number, name, about)
            with ui.element("div").classes("now"):
                self._said = ui.label(self._sentence()).classes("said")
                self._said.props("data-testid=guide-text")
                self._button()
                hide = button(
                    "I know the rig: hide the guide",
                    lambda: self._switch(shown=False),
                    look="line tab",
                    testid="hide-guide",
                )
                hide.tooltip("It stays hidden in this browser; the ? at the top brings it back.")

    def _step(self, number: int, name: str, about: str) -> None:
        done, here = self._now.is_done(number), number == self._now.step
        look = "done" if done else "here" if here else "todo"
        with ui.element("li").classes(look) as placed:
            if here:
                placed.props('aria-current="step"')
            ui.label("✓" if done else str(number)).classes("step-number").props("aria-hidden=true")
            with ui.element("div"):
                ui.label(name).classes("strong")
                ui.label("done" if done else about).classes("note")

    def _sentence(self) -> str:
        now = self._now
        if now.step == FIRE:
            return first_words(self._desk.daemon.rig.status())
        if now.step == READ:
            return f"{self._met()} One shot shows how it bounced; thirty show a law."
        if now.step == SWEEP and self._place == SWEEPS and not self._runs():
            return (
                "Thirty shots are chosen, slow to fast and head on to grazing. Press Start: they "
                "are fired and measured by themselves. Pause, Abort and STOP are always there."
            )
        if now.step == SWEEP:
            are = "shot is" if now.measured == 1 else "shots are"
            return (
                f"{now.measured} {are} measured of “{now.campaign}”, the first of all counted too. "
                f"From {ENOUGH} on they are compared; all thirty say more."
            )
        if now.found is not Found.WAITS:
            return COMPARED[now.found]
        return (
            f"{now.measured} shots are measured. Now hold them against the model: where it is "
            "wrong, something is missing in it."
        )

    def _met(self) -> str:
        """Say in numbers what the shot that was measured last did."""
        last = self._desk.daemon.rig.status().last_shot
        result = {} if last is None else self._desk.films.result(last)
        if result.get("status") != "measured":
            return "Your first shot is measured."
        met, parted = (abs(result[name]["value"]) for name in ("v_n", "v_n_after"))
        return (
            f"Read it: the spheres met at {met:.2f} m/s and parted at {parted:.2f} m/s, along the "
            f"line of centres. So the bounce e is {parted / met:.3f}."
        )

    def _button(self) -> None:
        now = self._now
        if now.step == FIRE and self._place != "/":
            _lead("To the rig", "/")
        elif now.step in {READ, SWEEP} and not self._runs() and self._place != SWEEPS:
            _lead("Let it fire 30 more", self._thirty())
        elif now.step == COMPARE and not self._place.startswith("/model/"):
            _lead("Compare with the model", f"/model/{now.campaign}")
        elif now.step == OVER:
            _lead("Take a challenge", "/model")

    def _thirty(self) -> str:
        limits, name = self._desk.daemon.configuration.limits, self._now.campaign
        own = bool(name) and not self._desk.daemon.store.is_imported(name)
        sweep = broad_sweep(name if own else CAMPAIGN, limits)
        return SWEEPS if sweep is None else form_address(sweep)

    def _runs(self) -> bool:
        found = self._desk.daemon.store.sweeps.sweeps(limit=1)
        return any(sweep.state in RUNS for sweep in found)


def _lead(text: str, address: str) -> None:
    button(text, lambda: ui.navigate.to(address), look="fill", testid="guide-next")


def any_measured(desk: Desk) -> bool:
    """Say whether any shot of the store is measured."""

    def read() -> bool:
        return bool(desk.daemon.store.shots(limit=1, state=ShotState.ANALYSED))

    return desk.feed.shared("any measured", read)
