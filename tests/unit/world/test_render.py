from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from simulators.world.description import Sphere
from simulators.world.optics import Lighting, Optics, front_view, picture_rows, top_view
from simulators.world.render import Camera
from simulators.world.rotation import matrix, random_orientation
from simulators.world.state import Pose

Vector = NDArray[np.float64]
Triple = tuple[float, float, float]
EVEN = Lighting(100.0, 0.0, 0.0, 0.0, 0.0)
PLAIN = Optics(
    background=0.0,
    background_per_row=0.0,
    background_per_column=0.0,
    front_light=EVEN,
    top_light=EVEN,
    noise_grey=0.0,
    exposure_s=0.0,
)
SPHERE = Sphere(markers=0)
RADIUS_PX = SPHERE.radius_m * PLAIN.scale_px_per_m
UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])
NO_MARKERS = np.empty((0, 3))
FRONT = slice(*PLAIN.front_rows)
TOP = slice(*PLAIN.top_rows)


def at(x: float, y: float, z: float, orientation: Vector = UPRIGHT) -> Pose:
    return Pose(np.array([x, y, z]), orientation)


def light(
    optics: Optics,
    a: Pose | None,
    b: Pose | None = None,
    markers: Vector = NO_MARKERS,
    sphere: Sphere = SPHERE,
) -> Vector:
    camera = Camera(optics, (sphere, sphere), (markers, markers))
    return camera.expose(lambda _: (a, b), 0.0).astype(np.float64)


def centroid(image: Vector, first_row: int = 0) -> tuple[float, float]:
    rows, columns = np.indices(image.shape)
    weight = image.sum()
    return (rows * image).sum() / weight + first_row, (columns * image).sum() / weight


places = [(0.0, 0.0, 0.0), (0.00312, -0.0207, 0.0041), (-0.0011, 0.0333, -0.0029)]


@pytest.mark.parametrize("place", places)
def test_a_plain_disc_has_the_area_and_the_centre_of_its_sphere(place: Triple) -> None:
    image = light(PLAIN, at(*place))
    for view, rows in ((front_view(PLAIN), FRONT), (top_view(PLAIN), TOP)):
        part = image[rows]
        assert part.sum() / 100.0 == pytest.approx(np.pi * RADIUS_PX**2, rel=2e-4)
        row, column = centroid(part, rows.start)
        expected = view.centre_px(np.array(place), PLAIN.scale_px_per_m)
        assert row == pytest.approx(expected[0], abs=2e-3)
        assert column == pytest.approx(expected[1], abs=2e-3)


def test_the_two_views_show_axes_as_the_exchange_format_says() -> None:
    x, y, z = 0.004, -0.021, 0.003
    front = front_view(PLAIN).centre_px(np.array([x, y, z]), 1574.8)
    top = top_view(PLAIN).centre_px(np.array([x, y, z]), 1574.8)
    assert front == pytest.approx((132.0 + 1574.8 * x, 120.0 + 1574.8 * y))
    assert top == pytest.approx((46.0 - 1574.8 * z, 120.0 + 1574.8 * y))


@pytest.mark.parametrize("seed", range(4))
def test_a_marker_appears_where_its_direction_points(seed: int) -> None:
    rng = np.random.default_rng(seed)
    orientation = random_orientation(rng)
    body = matrix(orientation).T
    small = replace(SPHERE, marker_radius_rad=0.12)
    # One marker toward the camera side and one upward, each slanted at random.
    slant = rng.uniform(-0.5, 0.5, size=(2, 2))
    toward = np.array([[slant[0, 0], slant[0, 1], 1.0], [-1.0, slant[1, 0], slant[1, 1]]])
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    markers = toward @ body.T
    place = np.array([0.001, 0.002, -0.001])
    plain = light(PLAIN, at(*place), sphere=small)
    marked = light(PLAIN, at(*place, orientation), markers=markers, sphere=small)
    for view, rows, direction in (
        (front_view(PLAIN), FRONT, toward[0]),
        (top_view(PLAIN), TOP, toward[1]),
    ):
        dark = (plain - marked)[rows]
        # The rim of a cap is a circle about cos(radius) of its axis, and its image an ellipse.
        depth = np.cos(0.12)
        pole = place + direction * SPHERE.radius_m * depth
        keep = _near(dark, view.centre_px(pole, PLAIN.scale_px_per_m), rows.start)
        assert centroid(keep, rows.start) == pytest.approx(
            view.centre_px(pole, PLAIN.scale_px_per_m), abs=0.01
        )


def _near(image: Vector, centre: tuple[float, float], first_row: int) -> Vector:
    rows, columns = np.indices(image.shape)
    far = np.hypot(rows + first_row - centre[0], columns - centre[1]) > 7.0
    return np.where(far, 0.0, image)


def test_markers_on_the_far_side_are_not_seen() -> None:
    markers = np.array([[0.3, 0.0, -1.0]]) / np.hypot(0.3, 1.0)
    plain, marked = light(PLAIN, at(0, 0, 0)), light(PLAIN, at(0, 0, 0), markers=markers)
    np.testing.assert_array_equal(plain[FRONT], marked[FRONT])


def coloured(a: Pose | None, b: Pose | None) -> NDArray[np.float32]:
    """Picture of two spheres of which only a carries a marker, a huge one: it is the darker."""
    cover = replace(SPHERE, marker_radius_rad=1.5, marker_reflectance=0.5)
    camera = Camera(PLAIN, (cover, cover), (np.array([[-0.6, 0.0, 0.8]]), NO_MARKERS))
    return camera.expose(lambda _: (a, b), 0.0)


def test_the_nearer_sphere_hides_the_farther_one_in_the_front_view() -> None:
    near, far = 0.003, -0.003
    assert coloured(at(0, 0, near), at(0, 0.005, far))[132, 124] == pytest.approx(50.0)
    assert coloured(at(0, 0, far), at(0, 0.005, near))[132, 124] == pytest.approx(100.0)


def test_the_higher_sphere_hides_the_lower_one_in_the_mirror() -> None:
    high, low = -0.01, 0.015
    assert coloured(at(high, 0, 0), at(low, 0.005, 0))[46, 124] == pytest.approx(50.0)
    assert coloured(at(low, 0, 0), at(high, 0.005, 0))[46, 124] == pytest.approx(100.0)


def test_a_sphere_before_the_mirror_covers_what_the_mirror_shows() -> None:
    # Sphere a has risen into the mirror's rows; b is seen there in the mirror.
    image = coloured(at(-0.04, 0, 0), at(0.02, 0, 0))
    row = round(132.0 - 0.04 * 1574.8) - 15
    assert image[row, 120] == pytest.approx(50.0)


def test_the_lens_adds_its_variance_and_keeps_the_light() -> None:
    sharp, soft = replace(PLAIN, blur_px=0.0), replace(PLAIN, blur_px=1.5)
    point = replace(SPHERE, diameter_m=0.002)
    images = [light(optics, at(0, 0, 0), sphere=point)[FRONT] for optics in (sharp, soft)]
    rows = np.indices(images[0].shape)[0]

    def variance(image: Vector) -> float:
        mean = (rows * image).sum() / image.sum()
        return ((rows - mean) ** 2 * image).sum() / image.sum()

    assert images[1].sum() == pytest.approx(images[0].sum(), rel=1e-4)
    assert variance(images[1]) - variance(images[0]) == pytest.approx(1.5**2, rel=0.02)


def test_exposure_smears_the_image_about_its_mid_exposure_place() -> None:
    speed, exposure = 2.5, 1e-3
    optics = replace(PLAIN, exposure_s=exposure)
    camera = Camera(optics, (SPHERE, SPHERE), (NO_MARKERS, NO_MARKERS))
    moving = camera.expose(lambda time: (at(0, speed * (time - 4.0), 0), None), 4.0)
    still = light(PLAIN, at(0, 0, 0))
    columns = np.indices(still[FRONT].shape)[1]

    def spread(image: Vector) -> tuple[float, float]:
        mean = (columns * image).sum() / image.sum()
        return mean, ((columns - mean) ** 2 * image).sum() / image.sum()

    mean, variance = spread(moving[FRONT].astype(float))
    assert mean == pytest.approx(120.0, abs=2e-3)
    # Uniform motion over a length adds a twelfth of its square to the variance.
    length = speed * exposure * optics.scale_px_per_m
    added = variance - spread(still[FRONT])[1]
    assert added == pytest.approx(length**2 / 12.0, rel=0.02)


def test_noise_has_the_stated_standard_deviation() -> None:
    optics = replace(PLAIN, background=80.0, noise_grey=3.0)
    camera = Camera(optics, (SPHERE, SPHERE), (NO_MARKERS, NO_MARKERS))
    image = camera.take(lambda _: (None, None), 0.0, np.random.default_rng(1))
    # Rounding to whole grey levels adds a twelfth to the variance.
    assert image.std() == pytest.approx(np.sqrt(9.0 + 1.0 / 12.0), rel=0.015)
    assert image.mean() == pytest.approx(80.0, abs=0.06)


def test_grey_levels_are_clipped_and_not_wrapped() -> None:
    optics = replace(PLAIN, background=254.0, noise_grey=5.0)
    camera = Camera(optics, (SPHERE, SPHERE), (NO_MARKERS, NO_MARKERS))
    image = camera.take(lambda _: (None, None), 0.0, np.random.default_rng(1))
    assert image.min() > 200


def test_limb_and_side_light_shade_the_disc_as_described() -> None:
    shaded = Lighting(100.0, 0.3, 0.2, 0.0, 1.0)
    optics = replace(PLAIN, front_light=shaded, blur_px=0.0)
    image = light(optics, at(0, 0, 0))
    for column in (110, 120, 130):
        across = (column - 120) / RADIUS_PX
        expected = 100.0 * (1.0 - 0.3 * (1.0 - np.sqrt(1.0 - across**2))) * (1.0 + 0.2 * across)
        assert image[132, column] == pytest.approx(expected, abs=0.1)


@pytest.mark.parametrize(("pictures", "rows"), [(1, 192), (2, 96), (3, 64), (4, 48), (6, 32)])
def test_split_pictures_show_the_rows_about_the_middle(pictures: int, rows: int) -> None:
    camera = Camera(PLAIN, (SPHERE, SPHERE), (NO_MARKERS, NO_MARKERS))
    whole = camera.expose(lambda _: (at(0, 0, 0), None), 0.0)
    part = camera.expose(lambda _: (at(0, 0, 0), None), 0.0, rows)
    assert part.shape == (192 // pictures, 240)
    np.testing.assert_array_equal(part, whole[96 - rows // 2 : 96 + rows // 2])


def test_rows_that_no_split_gives_are_refused() -> None:
    with pytest.raises(ValueError, match=r"one of .* rows, asked for 100"):
        picture_rows(PLAIN, 100)


@pytest.mark.parametrize("place", [(0.0, 0.078, 0.0), (0.045, 0.0, 0.0), (-0.09, -0.08, 0.03)])
def test_spheres_across_the_edge_of_the_frame_are_cut_there(place: Triple) -> None:
    image = light(PLAIN, at(*place))
    assert image.shape == (192, 240)
    assert image.min() >= 0.0


def test_a_sphere_out_of_the_field_leaves_the_scene_empty() -> None:
    optics = Optics(noise_grey=0.0)
    np.testing.assert_array_equal(light(optics, at(0.4, 0.0, 0.0))[120:], light(optics, None)[120:])
