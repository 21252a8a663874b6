from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from analysis.collision.coefficients import (
    Impact,
    Motion,
    first_touch,
    measure_impact,
)
from analysis.collision.instant import NoTouchError
from analysis.motion.spin import Spin
from analysis.motion.velocity import FlightPath

R = 0.0127
RADII = (R, R)
GRAVITY = np.array([9.80665, 0.0, 0.0])
TOUCH_S = 8.3e-3
REFERENCE_S = 8.0e-3
NORMAL = np.array([0.4, np.sqrt(1 - 0.16 - 0.0025), 0.05])
VELOCITIES = {
    "a before": np.array([-0.1, 2.0, 0.02]),
    "b before": np.array([0.15, -1.9, -0.01]),
    "a after": np.array([-0.9, -1.0, -0.05]),
    "b after": np.array([0.95, 1.1, 0.06]),
}
SPINS = {
    "a before": np.array([10.0, -5.0, 30.0]),
    "b before": np.array([-4.0, 8.0, -20.0]),
    "a after": np.array([12.0, -5.0, 60.0]),
    "b after": np.array([-2.0, 8.0, 12.0]),
}
NAMES = tuple(VELOCITIES)
TRUE_V_N = float((VELOCITIES["b before"] - VELOCITIES["a before"]) @ NORMAL)
LASTS_S = 1.5e-4
TRUE_V_N_AFTER = float((VELOCITIES["b after"] - VELOCITIES["a after"]) @ NORMAL)


def covariance(sigma_x: float = 2e-5, sigma_v: float = 8e-3, tied: float = 0.4) -> np.ndarray:
    whole = np.diag([sigma_x**2] * 3 + [sigma_v**2] * 3)
    for axis in range(3):
        whole[axis, axis + 3] = whole[axis + 3, axis] = tied * sigma_x * sigma_v
    return whole


def path(name: str) -> FlightPath:
    """Return a path that stands where its sphere is at first touch, carried to the reference."""
    place = (NORMAL if name[0] == "b" else -NORMAL) * R
    wait = REFERENCE_S - TOUCH_S
    # The velocities above hold at the touch.
    velocity = VELOCITIES[name] + GRAVITY * wait
    position = place + VELOCITIES[name] * wait + 0.5 * GRAVITY * wait**2
    return FlightPath(REFERENCE_S, position, velocity, GRAVITY, covariance(), 1.0, np.zeros(6))


def spin(name: str) -> Spin:
    return Spin(SPINS[name], np.diag([2.0, 3.0, 2.5]) ** 2, 1.0)


def motion(sphere: str) -> Motion:
    before, after = f"{sphere} before", f"{sphere} after"
    return Motion(path(before), path(after), spin(before), spin(after))


def parting_later(sphere: Motion, lasts_s: float) -> Motion:
    """Return the motion whose path after contact leaves from the touch so much later."""
    after = sphere.after
    return replace(sphere, after=replace(after, position=after.position - lasts_s * after.velocity))


def drawn(sphere: Motion, rng: np.random.Generator) -> Motion:
    """Return the motion that another measurement would have given, taken as exact."""

    def other_path(p: FlightPath) -> FlightPath:
        state = rng.multivariate_normal(np.concatenate([p.position, p.velocity]), p.covariance)
        return replace(p, position=state[:3], velocity=state[3:], covariance=np.zeros((6, 6)))

    def other_spin(s: Spin) -> Spin:
        velocity = rng.multivariate_normal(s.velocity, s.covariance)
        return replace(s, velocity=velocity, covariance=np.zeros((3, 3)))

    return Motion(
        other_path(sphere.before),
        other_path(sphere.after),
        other_spin(sphere.spin_before),
        other_spin(sphere.spin_after),
    )


def rescaled(sphere: Motion, factor: float) -> Motion:
    def longer(p: FlightPath) -> FlightPath:
        return replace(p, position=factor * p.position, velocity=factor * p.velocity)

    return replace(sphere, before=longer(sphere.before), after=longer(sphere.after))


def seen_turned(sphere: Motion, turn: np.ndarray) -> Motion:
    """Return the motion of a sphere whose orientations are all seen turned by a vector, rad."""
    seen = Rotation.from_rotvec(turn)

    def other(s: Spin) -> Spin:
        return replace(s, velocity=seen.apply(s.velocity))

    return replace(
        sphere, spin_before=other(sphere.spin_before), spin_after=other(sphere.spin_after)
    )


def numbers(impact: Impact) -> np.ndarray:
    beta = impact.beta.value if impact.beta else np.nan
    assert impact.duration is not None
    parts = (impact.v_n, impact.v_s, impact.v_n_after, impact.v_s_after, impact.e, impact.duration)
    return np.array([impact.contact_time.value, *(q.value for q in parts), beta, *impact.normal])


def stated(impact: Impact) -> np.ndarray:
    beta = impact.beta.sigma if impact.beta else np.nan
    assert impact.duration is not None
    parts = (impact.v_n, impact.v_s, impact.v_n_after, impact.v_s_after, impact.e, impact.duration)
    times = impact.contact_time.sigma
    return np.array([times, *(q.sigma for q in parts), beta, *impact.normal_sigma])


def test_exact_motion_gives_the_impact_it_was_made_of() -> None:
    impact = measure_impact(motion("a"), motion("b"), RADII, 0.0)
    # The touch is sought on straight paths; gravity is common to both spheres.
    assert impact.contact_time.value == pytest.approx(TOUCH_S, abs=1e-9)
    np.testing.assert_allclose(impact.normal, NORMAL, atol=1e-9)
    assert impact.v_n.value == pytest.approx(TRUE_V_N)
    assert impact.v_n_after.value == pytest.approx(TRUE_V_N_AFTER)
    assert impact.e.value == pytest.approx(-TRUE_V_N_AFTER / TRUE_V_N)
    relative = VELOCITIES["b before"] - VELOCITIES["a before"]
    turning = R * (SPINS["a before"] + SPINS["b before"])
    surface = relative - TRUE_V_N * NORMAL + np.cross(NORMAL, turning)
    assert impact.v_s.value == pytest.approx(np.linalg.norm(surface))
    np.testing.assert_allclose(impact.after.velocity_b, VELOCITIES["b after"])
    np.testing.assert_allclose(impact.before.spin_a, SPINS["a before"])
    units = [q.unit for q in (impact.contact_time, impact.v_n, impact.e)]
    assert units == ["s", "m/s", "1"]


def test_stated_errors_are_the_scatter_of_four_hundred_measurements() -> None:
    # The scale's share of the error of v_n is as large as that of the paths.
    rng, scale_sigma = np.random.default_rng(9), 0.003
    a, b = motion("a"), motion("b")
    draws = []
    for _ in range(400):
        factor = 1.0 + scale_sigma * rng.standard_normal()
        one, other = (rescaled(drawn(sphere, rng), factor) for sphere in (a, b))
        draws.append(numbers(measure_impact(one, other, RADII, 0.0)))
    errors = stated(measure_impact(a, b, RADII, scale_sigma))
    np.testing.assert_allclose(errors, np.std(draws, axis=0), rtol=0.15)


def test_stated_errors_hold_spins_that_are_seen_turned_alike_before_and_after_contact() -> None:
    rng, turn_sigma = np.random.default_rng(10), 0.1
    spheres = [motion("a"), motion("b")]
    draws = []
    for _ in range(400):
        turned = [seen_turned(one, turn_sigma * rng.standard_normal(3)) for one in spheres]
        draws.append(numbers(measure_impact(*(drawn(one, rng) for one in turned), RADII, 0.0)))
    errors = stated(measure_impact(*spheres, RADII, 0.0, turn_sigma=turn_sigma))
    np.testing.assert_allclose(errors, np.std(draws, axis=0), rtol=0.15)
    alone = stated(measure_impact(*spheres, RADII, 0.0))
    np.testing.assert_array_less(1.05 * alone[[2, 4]], errors[[2, 4]])  # v_s, v_s'


def test_own_errors_are_those_that_an_exact_scale_in_still_air_would_leave() -> None:
    def in_air(p: FlightPath) -> FlightPath:
        return replace(p, drag_shift=1e-3 * np.concatenate([0.01 * p.velocity, p.velocity]))

    def slowed(sphere: Motion) -> Motion:
        return replace(sphere, before=in_air(sphere.before), after=in_air(sphere.after))

    whole = measure_impact(slowed(motion("a")), slowed(motion("b")), RADII, 0.003)
    alone = measure_impact(motion("a"), motion("b"), RADII, 0.0)
    for name in ("v_n", "v_s", "v_n_after", "v_s_after", "e", "beta"):
        found, own = getattr(whole, name), getattr(alone, name)
        assert found.own == pytest.approx(own.sigma, rel=1e-3), name
        assert found.sigma == pytest.approx(np.hypot(found.own, found.common)), name


def test_the_common_error_of_the_scale_is_what_another_scale_would_have_changed() -> None:
    whole = measure_impact(motion("a"), motion("b"), RADII, 0.003)
    longer = measure_impact(*(rescaled(motion(s), 1.0003) for s in "ab"), RADII, 0.0)
    for name in ("v_n", "v_s", "v_n_after", "v_s_after", "e"):
        found, other = getattr(whole, name), getattr(longer, name)
        assert found.common == pytest.approx(10 * abs(other.value - found.value), rel=0.02), name


def test_a_contact_lasts_from_the_touch_of_the_paths_before_to_the_parting_of_those_after() -> None:
    impact = measure_impact(
        parting_later(motion("a"), LASTS_S), parting_later(motion("b"), LASTS_S), RADII, 0.0
    )
    assert impact.duration is not None
    # The carried paths take the velocities at the reference, half a contact from the touch's.
    assert impact.duration.value == pytest.approx(LASTS_S, abs=1e-7)
    assert impact.duration.unit == "s"
    instantaneous = measure_impact(motion("a"), motion("b"), RADII, 0.0)
    assert instantaneous.duration is not None
    assert instantaneous.duration.value == pytest.approx(0.0, abs=1e-9)


def test_where_the_lines_through_the_tracks_cross_gives_the_same_duration() -> None:
    aimed = {name: sign * NORMAL for name, sign in (("a", -1.0), ("b", 1.0))}
    speeds = {"before": -1.6, "after": 1.2}

    def head_on(name: str) -> Motion:
        whole = motion(name)
        before = replace(whole.before, position=R * aimed[name], velocity=-1.6 * aimed[name])
        after = replace(whole.after, position=R * aimed[name], velocity=1.2 * aimed[name])
        return parting_later(replace(whole, before=before, after=after), LASTS_S)

    impact = measure_impact(head_on("a"), head_on("b"), RADII, 0.0)
    # Distance of the centres over that of touch: 2 * -1.6 t before, 2 * 1.2 (t - T) after.
    kink_s = LASTS_S * speeds["after"] / (speeds["after"] - speeds["before"])
    e = speeds["after"] / -speeds["before"]
    assert impact.duration is not None
    assert impact.duration.value == pytest.approx(kink_s * (1 + e) / e)


def test_paths_that_pass_each_other_by_after_contact_tell_no_duration() -> None:
    a, b = motion("a"), motion("b")
    wide = replace(b.after, position=b.after.position + np.array([0.0, 0.0, 3 * R]))
    outward = replace(wide, velocity=a.after.velocity + np.array([0.3, 0.0, 0.0]))
    impact = measure_impact(a, replace(b, after=outward), RADII, 0.0)
    assert impact.duration is None
    assert impact.e.sigma > 0


def test_the_error_of_each_state_stands_in_its_place() -> None:
    impact = measure_impact(motion("a"), motion("b"), RADII, 0.0)
    assert impact.state_sigma.shape == (2, 4, 3)
    np.testing.assert_allclose(impact.state_sigma[:, :2], 8e-3, rtol=0.05)
    np.testing.assert_allclose(impact.state_sigma[:, 2:], np.tile([2.0, 3.0, 2.5], (2, 2, 1)))


def test_without_surface_velocity_there_is_no_beta() -> None:
    head_on = {
        "a before": TRUE_V_N * NORMAL / -2,
        "b before": TRUE_V_N * NORMAL / 2,
        "a after": TRUE_V_N_AFTER * NORMAL / -2,
        "b after": TRUE_V_N_AFTER * NORMAL / 2,
    }

    def aimed(sphere: str) -> Motion:
        whole = motion(sphere)
        place = (NORMAL if sphere == "b" else -NORMAL) * R * 1.1
        before, after = (
            replace(p, position=place, velocity=head_on[f"{sphere} {side}"])
            for p, side in ((whole.before, "before"), (whole.after, "after"))
        )
        still = Spin(np.zeros(3), np.eye(3), 1.0)
        return Motion(before, after, still, still)

    impact = measure_impact(aimed("a"), aimed("b"), RADII, 0.0)
    assert impact.beta is None
    assert impact.e.value == pytest.approx(-TRUE_V_N_AFTER / TRUE_V_N)


def test_what_drag_does_to_all_paths_together_is_one_error_of_each_number() -> None:
    def slowed(sphere: Motion, share: float) -> Motion:
        # As a fit without drag: too fast before the contact, too slow after it.
        def off(p: FlightPath, sign: float) -> FlightPath:
            shift = sign * np.concatenate([-4e-6 * p.velocity, np.zeros(3)])
            shift[3:] = sign * 3e-4 * p.velocity
            return replace(
                p,
                position=p.position + share * shift[:3],
                velocity=p.velocity + share * shift[3:],
                covariance=1e-4 * p.covariance,
                drag_shift=shift,
            )

        return replace(sphere, before=off(sphere.before, 1.0), after=off(sphere.after, -1.0))

    def without_drag(sphere: Motion) -> Motion:
        before, after = (replace(p, drag_shift=np.zeros(6)) for p in (sphere.before, sphere.after))
        return replace(sphere, before=before, after=after)

    still = slowed(motion("a"), 0.0), slowed(motion("b"), 0.0)
    plain = measure_impact(without_drag(still[0]), without_drag(still[1]), RADII, 0.0)
    with_drag = measure_impact(*still, RADII, 0.0)
    moved = measure_impact(slowed(motion("a"), 1.0), slowed(motion("b"), 1.0), RADII, 0.0)
    np.testing.assert_allclose(numbers(with_drag), numbers(plain))
    added = np.sqrt(np.maximum(stated(with_drag) ** 2 - stated(plain) ** 2, 0.0))
    np.testing.assert_allclose(added, np.abs(numbers(moved) - numbers(plain)), rtol=0.01, atol=1e-7)
    # v_n too large and v_n' too small by 3e-4 each: e by twice that share of itself.
    assert added[5] == pytest.approx(6e-4 * plain.e.value, rel=0.2)


def test_paths_that_do_not_meet_say_how_near_they_come() -> None:
    a = FlightPath(
        0.0,
        np.array([0.0, -0.05, 0.0]),
        np.array([0.0, 2.0, 0.0]),
        GRAVITY,
        np.eye(6),
        1.0,
        np.zeros(6),
    )
    b = FlightPath(
        0.0,
        np.array([0.03, 0.05, 0.0]),
        np.array([0.0, -2.0, 0.0]),
        GRAVITY,
        np.eye(6),
        1.0,
        np.zeros(6),
    )
    with pytest.raises(NoTouchError) as miss:
        first_touch(a, b, RADII)
    assert miss.value.closest_m == pytest.approx(0.03)
    assert "30.00 mm" in str(miss.value)
