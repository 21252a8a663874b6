"""Radius of the disc, learned without a stated scale, under other light and blur."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

from analysis.photometric.teaching import teach
from analysis.setup import CameraSetup, Setup, SphereSetup
from benchmarks.imaging.goals import Sheet
from simulators.world import Launch, WorldDescription, render_shot

LIMBS, SIDES, BLURS = (0.0, 0.3, 0.6), (0.0, 0.2, 0.4), (0.7, 1.2)
SHOTS = ((60.0, 5e-3), (40.0, 9e-3), (80.0, 2e-3))
"""Pressure, kPa, and offset, m, of those that teach."""


def run(seed: int) -> None:
    """Learn a pair under each light and blur; print the largest error and their mean."""
    sheet, off = Sheet("radius"), []
    print("\nradius learned from three shots, error in px (limb, side light, blur)")
    for limb, side, blur in itertools.product(LIMBS, SIDES, BLURS):
        world = lit(WorldDescription(), limb, side, blur)
        setup = unscaled(world)
        shots = [
            render_shot(world, Launch(kpa, kpa, offset), seed, shot=number)
            for number, (kpa, offset) in enumerate(SHOTS, start=1)
        ]
        known = teach([(shot.frames, shot.times_s, setup) for shot in shots])
        if known is None:
            print(f"  {limb:g} {side:g} {blur:g}: cannot be learned")
            continue
        true = world.optics.scale_px_per_m
        errors = (known.camera.optics.scales - true) * setup.spheres[0].diameter_m / 2
        stated = known.scale_sigma * true * setup.spheres[0].diameter_m / 2
        off.append(errors)
        told = ", ".join(f"{e:+.4f}" for e in errors)
        print(f"  {limb:g} {side:g} {blur:g}: {told}; stated {stated:.4f}", flush=True)
    sheet.at_most("largest error of the radius", float(np.abs(off).max()), 0.02, "px")
    sheet.at_most("mean error of the radius", abs(float(np.mean(off))), 0.02, "px")
    sheet.write()


def lit(world: WorldDescription, limb: float, side: float, blur: float) -> WorldDescription:
    """Return the world under another light, seen through another lens."""
    optics = world.optics
    front, top = (
        replace(light, limb_darkening=limb, side_light=side)
        for light in (optics.front_light, optics.top_light)
    )
    return replace(world, optics=replace(optics, front_light=front, top_light=top, blur_px=blur))


def unscaled(world: WorldDescription) -> Setup:
    """Return what a laboratory knows of a world whose scale it has not measured."""
    optics = world.optics
    camera = CameraSetup(
        frame_rate_hz=1000.0,
        height_px=optics.rows,
        width_px=optics.columns,
        front_view_rows=optics.front_rows,
        top_view_rows=optics.top_rows,
        front_origin_px=optics.front_origin_px,
        top_origin_px=optics.top_origin_px,
    )
    a, b = world.sphere_a.diameter_m, world.sphere_b.diameter_m
    return Setup(camera, (SphereSetup("a", a), SphereSetup("b", b)))
