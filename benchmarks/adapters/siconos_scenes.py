"""Scenes of boxes and spheres in Siconos, in a process of its own (`siconos_bodies`)."""

import json
import subprocess
from pathlib import Path

import numpy as np

from benchmarks.siconos import interpreter
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.inertia import inertia_of
from nonsmooth.scenes.places import place_of, turn_onto
from nonsmooth.scenes.shapes import Box


class Motion:
    """A scene in motion."""

    def __init__(self, scene, dt):
        self.process = subprocess.Popen(
            [interpreter(), str(Path(__file__).with_name("siconos_bodies.py"))],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        moving = [body for body in scene.bodies if body.kind is not Kind.FIXED]
        planes = [body.shape for body in scene.bodies if body.kind is Kind.FIXED]
        bodies = [described(body) for body in moving]
        self.x = np.array([body["x"] for body in bodies])
        material = moving[0].material
        self.tell(json.dumps({
            "dt": dt, "gravity": np.asarray(scene.gravity, dtype=float).tolist(), "bodies": bodies,
            "planes": [place_of(plane.offset * plane.normal, turn_onto(plane.normal)).tolist() for plane in planes],
            "mu": material.mu, "e": material.e,
        }))  # fmt: skip

    def tell(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def step(self, count):
        """So many steps; their processor time [s]."""
        self.tell(str(count))
        answer = json.loads(self.process.stdout.readline())
        self.x = np.array(answer["x"])
        return answer["seconds"]

    def places(self):
        return self.x[:, :3], self.x[:, 3:]

    def close(self):
        with self.process as ended:
            ended.stdin.close()


def described(body):
    """A body as numbers."""
    inertia = inertia_of(body, 3)
    is_box = isinstance(body.shape, Box)
    x = [*np.asarray(body.position, dtype=float).tolist(), *np.asarray(body.turn, dtype=float).tolist()]
    return {
        "shape": "box" if is_box else "sphere", "sizes": list(body.shape.lengths) if is_box else [body.shape.radius],
        "mass": float(inertia.mass), "moments": np.asarray(inertia.moments, dtype=float).tolist(), "x": x,
        "v": [*np.asarray(body.velocity, dtype=float).tolist(), *np.asarray(body.spin, dtype=float).tolist()],
    }  # fmt: skip
