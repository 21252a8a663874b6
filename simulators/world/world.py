"""The world in lab time: pushers fire, and a camera may look at any instant."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from simulators.world.chance import marked_camera, noise_chance, shot_chance
from simulators.world.description import Magnet, WorldDescription
from simulators.world.encounter import Encounter, Law
from simulators.world.firing import fire
from simulators.world.flight import load_integrator
from simulators.world.launch import Launch
from simulators.world.release import PLATE, Release
from simulators.world.state import Pose
from simulators.world.truth import append_line, contact_truth

REMEMBERED_SHOTS = 256
"""Pictures of older shots show an empty scene; a tape holds far fewer."""

# A shot takes some 40 ms of computing; this bounds a picture's wait for it on a busy machine.
_PATIENCE_S = 60.0


@dataclass(frozen=True, slots=True)
class _Fired:
    """A shot and its outcome, which a thread of its own works out."""

    launch: Launch | Release
    encounter: Future[Encounter]

    def poses(self, time_s: float) -> Sequence[Pose | None]:
        """Return the poses of a and b at a lab time."""
        return self.encounter.result(_PATIENCE_S).poses(time_s - self.launch.starts_s)

    def shows(self, time_s: float) -> bool:
        """Return whether a sphere of this shot is in the air at a lab time."""
        times = (self.launch.fire_a_s, self.launch.fire_b_s)
        fired_s = min(time for time in times if time is not None)
        return fired_s <= time_s and any(pose is not None for pose in self.poses(time_s))


class World:
    """Two tubes, two spheres and a camera; every method may be called from any thread.

    The same description, seed and order of launches give the same world: scatter depends on the
    seed and the number of the shot, noise on the seed and the time of the picture.

    Parameters
    ----------
    description
        What the world is made of.
    seed
        Of markers, scatter and noise; not negative.
    truth_folder
        Made if absent. `fires.jsonl` gets one line a fire before `fire` returns, on the disk;
        `truth.jsonl` one line a shot once it has been worked out.
    law
        Of the contact; None: the description's.
    """

    def __init__(
        self,
        description: WorldDescription,
        seed: int,
        truth_folder: Path,
        law: Law | None = None,
    ) -> None:
        self.description = description
        self.truth_folder = truth_folder
        self._seed, self._law = seed, law
        truth_folder.mkdir(parents=True, exist_ok=True)
        self._lock = threading.Lock()
        self._truth_lock = threading.Lock()
        self._fires = 0
        self._fired: deque[_Fired] = deque(maxlen=REMEMBERED_SHOTS)
        self._camera = marked_camera(description, seed)
        threading.Thread(target=load_integrator, name="world-load", daemon=True).start()

    @property
    def fires(self) -> int:
        """How often the pushers have fired."""
        with self._lock:
            return self._fires

    def fire(self, launch: Launch | Release) -> int:
        """Launch the spheres and return the number of the shot, the first being 1.

        Returns at once: the shot is worked out meanwhile, and a picture of it waits for that.
        """
        with self._lock:
            shot = self._fires + 1
            append_line(
                self.truth_folder / "fires.jsonl",
                {"shot": shot, "fire_a_s": launch.fire_a_s, "fire_b_s": launch.fire_b_s},
            )
            self._fires = shot
            fired = _Fired(launch, Future())
            self._fired.append(fired)
        threading.Thread(
            target=self._work_out, args=(shot, fired), name=f"world-shot-{shot}"
        ).start()
        return shot

    def picture(self, time_s: float, rows: int | None = None) -> NDArray[np.uint8]:
        """Return the frame (rows, columns) with mid-exposure at a lab time.

        Spheres still in their tubes or out of the field are not to be seen; with none in the air
        it is the empty scene. The same picture asked for twice is the same to the last bit.

        Raises
        ------
        ValueError
            A picture cannot have that number of rows (`render.picture_rows`).
        """
        with self._lock:
            shots = list(self._fired)
        # The tubes hold one sphere each: the latest shot in the air is the one to be seen.
        seen = next((shot for shot in reversed(shots) if shot.shows(time_s)), None)
        poses = seen.poses if seen is not None else _nothing
        return self._camera.take(poses, time_s, noise_chance(self._seed, time_s), rows)

    def _work_out(self, shot: int, fired: _Fired) -> None:
        try:
            chance = shot_chance(self._seed, shot)
            encounter = fire(self.description, fired.launch, chance, self._law)
            with self._truth_lock:
                append_line(self.truth_folder / "truth.jsonl", self._truth(shot, fired, encounter))
        except Exception as error:  # noqa: BLE001 - whoever asks for a picture is told
            fired.encounter.set_exception(error)
        else:
            fired.encounter.set_result(encounter)

    def _truth(self, shot: int, fired: _Fired, encounter: Encounter) -> dict[str, object]:
        bounces = isinstance(self.description.holder, Magnet)
        b = PLATE if bounces else self.description.sphere_b
        spheres = (self.description.sphere_a, b)
        truth: dict[str, object] = {"shot": shot, **asdict(fired.launch)}
        truth |= contact_truth(encounter.contact, spheres)
        if bounces and encounter.contact is not None:
            every = (encounter.contact, *encounter.later)
            truth["impacts"] = [contact_truth(each, spheres) for each in every]
        return truth


def _nothing(_: float) -> Sequence[Pose | None]:
    return None, None
