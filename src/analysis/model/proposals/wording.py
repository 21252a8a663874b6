"""A form as a formula, in text and in LaTeX, with the constants that only set a zero filled in."""

from __future__ import annotations

from analysis.model.proposals.arguments import Argument
from analysis.model.proposals.channels import Form
from analysis.model.proposals.forms.flight import FlightForm
from analysis.model.proposals.forms.form import ContactForm
from analysis.model.proposals.forms.frame import AXES, FrameForm
from analysis.model.proposals.forms.impulses import IMPULSE_N, IMPULSE_T, TORSION
from analysis.model.proposals.forms.launch import TRACK, LaunchForm
from analysis.model.proposals.forms.shapes import POWER

_SLOTS = {
    "e": ("e", "e0", "e", "e_{0}"),
    "mu": ("mu", "mu0", r"\mu", r"\mu_{0}"),
    "beta0": ("beta0", "beta00", r"\beta_0", r"\beta_{0}"),
    IMPULSE_N: ("J_n", "J_n0", "J_n", "J_{n,0}"),
    IMPULSE_T: ("J_t", "J_t0", "J_t", "J_{t,0}"),
}
"""Of each slot its letter and what it is without the law, in text and in LaTeX."""
_FLIGHT = {
    "central": (
        "acceleration of a = k (D / d)^p toward b",
        r"a_a = k\,(D/d)^{p}\ \text{toward b}",
    ),
    "central-exponential": (
        "acceleration of a = k exp(-(d - D) / c) toward b",
        r"a_a = k\,e^{-(d-D)/c}\ \text{toward b}",
    ),
    "velocity": (
        "acceleration = -k (|v| / (1 m/s))^q v / |v|",
        r"\mathbf{a} = -k\,(|\mathbf{v}|/(1\,\mathrm{m/s}))^{q}\,\mathbf{v}/|\mathbf{v}|",
    ),
    "uniform": ("acceleration = (g_x, g_y, g_z)", r"\mathbf{a} = \mathbf{g}"),
}
_SHAPES = {
    ("linear", 1): ("a {less}", r"a\,{less}"),
    ("power", 1): ("a {less}^2", r"a\,{less}^2"),
    ("exponential", 1): ("a exp(-{less} / c)", r"a\,e^{{-{less}/c}}"),
    ("hinge", 1): ("a max({x} - h, 0)", r"a\,\max({x}-h,\,0)"),
    ("step", 1): ("a H({x} - s)", r"a\,H({x}-s)"),
    ("bump", 1): ("a exp(-({x} - m)^2 / (2 w^2))", r"a\,e^{{-({x}-m)^2/(2w^2)}}"),
    ("periodic", 2): (
        "a sin(2 pi {less} / P) + b cos(2 pi {less} / P)",
        r"a\sin(2\pi\,{less}/P) + b\cos(2\pi\,{less}/P)",
    ),
}


_QUANTITIES = {
    "speed": ("speed", r"v"),
    "speed_a": ("speed of a", r"v_a"),
    "speed_b": ("speed of b", r"v_b"),
    TRACK: ("offset of the tracks", r"x_\mathrm{tracks}"),
}


def formula(form: Form | LaunchForm) -> str:
    """Return a form in text."""
    return _written(form, 0)


def latex(form: Form | LaunchForm) -> str:
    """Return a form in LaTeX."""
    return _written(form, 1)


def _written(form: Form | LaunchForm, style: int) -> str:
    if isinstance(form, LaunchForm):
        return _of_launch(form, style)
    if isinstance(form, FlightForm):
        return _FLIGHT[form.kind][style]
    if isinstance(form, FrameForm):
        return _of_frames(form, style)
    change = _change(form, style)
    if form.slot == TORSION:
        torque = (
            "torque about n = (3 pi / 16) mu J_n ({})",
            r"L_n = \tfrac{{3\pi}}{{16}}\mu J_n({})",
        )
        return torque[style].format(change)
    name, zero = _SLOTS[form.slot][2 * style : 2 * style + 2]
    if form.shape is POWER:
        x, x0 = _symbol(form.arguments[0], style), form.constants[0]
        return (f"{name} = {zero} ({x} / {x0:.4g})^p", f"{name} = {zero} ({x}/{x0:.4g})^{{p}}")[
            style
        ]
    return (f"{name} = {zero} [1 + {change}]", rf"{name} = {zero}\,[1 + {change}]")[style]


def _of_launch(form: LaunchForm, style: int) -> str:
    """Return what a quantity at the mouths becomes, as foretold from the settings or changed."""
    name, x = _QUANTITIES[form.quantity][style], _symbol(form.of, style)
    plain = (f"{name} by the settings", rf"{name}^{{(0)}}")[style]
    if form.symbols == ("p",):
        x0 = form.constants[0]
        return (f"{name} = {plain} x ({x} / {x0:.4g})^p", rf"{name} = {plain}({x}/{x0:.4g})^{{p}}")[
            style
        ]
    if form.shape is POWER:
        change = "a " + _logarithm(x, form.constants[0], style)
    else:
        template = _SHAPES[form.shape.name, len(form.symbols)][style]
        zero = form.constants[0] if "x0" in form.shape.fixed else 0.0
        change = template.format(x=x, less=_less(x, zero, style))
    if form.quantity == TRACK:
        return f"{name} = {plain} + {change}"
    return (f"{name} = {plain} x [1 + {change}]", rf"{name} = {plain}\,[1 + {change}]")[style]


def _of_frames(form: FrameForm, style: int) -> str:
    """Return where an image shows a centre, or when a frame was exposed."""
    if form.slot == "camera":
        i, j = AXES[form.along], AXES[form.by]
        square = "^2" if form.kind == "power" else ""
        return (f"{i}' = {i} + a {j}{square}", rf"{i}' = {i} + a\,{j}{square}")[style]
    if form.kind == "power":
        return ("t_true = t + a t^2", r"t_\mathrm{true} = t + a\,t^2")[style]
    return (
        "t_true = t + a sin(2 pi f t) + b cos(2 pi f t)",
        r"t_\mathrm{true} = t + a\sin(2\pi f t) + b\cos(2\pi f t)",
    )[style]


def _change(form: ContactForm, style: int) -> str:
    """Return what is added to 1."""
    symbols = [_symbol(argument, style) for argument in form.arguments]
    if len(form.arguments) == 2:
        parts = [
            _logarithm(x, zero, style) if argument.positive else _less(x, zero, style)
            for argument, x, zero in zip(form.arguments, symbols, form.constants, strict=True)
        ]
        return (" ", r"\,")[style].join(["a", *parts])
    if form.shape is None:
        return _of_numbers(form, style)
    if form.shape is POWER:
        return _logarithm(symbols[0], form.constants[0], style)
    template = _SHAPES[form.shape.name, len(form.symbols)][style]
    zero = form.constants[0] if "x0" in form.shape.fixed else 0.0
    return template.format(x=symbols[0], less=_less(symbols[0], zero, style))


def _of_numbers(form: ContactForm, style: int) -> str:
    """Return the sum over the numbers of one argument: twice an angle, a place on a body."""
    if form.argument == "normal":
        return ("a cos 2phi + b sin 2phi", r"a\cos 2\varphi + b\sin 2\varphi")[style]
    place = _symbol(form.arguments[0], style)
    return (f"(a_x, a_y, a_z) . {place}", rf"\mathbf{{a}}\cdot{place}")[style]


def _symbol(argument: Argument, style: int) -> str:
    return (argument.symbol, argument.latex)[style]


def _less(x: str, zero: float, style: int) -> str:
    if zero == 0.0:
        return x
    sign, size = ("-", zero) if zero > 0 else ("+", -zero)
    gap = (" ", "")[style]
    return f"({x}{gap}{sign}{gap}{size:.5g})"


def _logarithm(x: str, zero: float, style: int) -> str:
    return (f"ln({x} / {zero:.4g})", rf"\ln({x}/{zero:.4g})")[style]
