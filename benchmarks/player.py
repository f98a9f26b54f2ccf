"""How large the player's file of 1000 bodies over 500 frames is, and how many frames a second software draws of it."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.chromium import new_chromium
from nonsmooth.drawing.player.film import Body, Contacts, Curve, Film, Shape, ShapeKind
from nonsmooth.drawing.player.page import page_of

BODIES, FRAMES = 1000, 500  # chosen: what the player is asked to show
TOUCHING = 1200  # chosen: contacts of each frame: those of a heap in which each body has two or three
SPAN = 5.0  # chosen: of the motion [s]
WATCHED = 4.0  # chosen: how long it is watched [s]
RADIUS = 0.1  # chosen: of a body [m]


def main(words: list[str]) -> int:
    """Print a line for a film in the plane and one in space."""
    for dimension in (2, 3):
        began = time.perf_counter()
        text = page_of(heap(dimension))
        written = time.perf_counter() - began
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "heap.html"
            page.write_text(text, encoding="utf-8")
            opened, rate = watched(page, Path(folder) / "profile")
        print(
            f"{BODIES} bodies, {FRAMES} frames, {TOUCHING} contacts, {dimension} dimensions: {len(text) / 1e6:.1f} MB "
            f"written in {written:.1f} s, opened in {opened:.1f} s, {rate:.0f} frames a second"
        )
    return 0


def watched(page: Path, profile: Path) -> tuple[float, float]:
    """Seconds until it starts, and the frames drawn a second."""
    chromium = new_chromium(profile)
    try:
        began = time.perf_counter()
        chromium.get(page.as_uri())
        while not chromium.execute_script("return document.documentElement.dataset.ready"):
            time.sleep(0.02)
        opened = time.perf_counter() - began
        chromium.execute_script(f"player.speed = {SPAN / (2 * WATCHED)}; player.play()")
        time.sleep(WATCHED)
        return opened, chromium.execute_script("player.pause(); return player.rate")
    finally:
        chromium.quit()


def heap(dimension: int) -> Film:
    """Bodies in layers that heave and turn, with random contacts; no mechanics."""
    rng = np.random.default_rng(1)
    t = np.linspace(0.0, SPAN, FRAMES)
    edge = 40 if dimension == 2 else 12  # chosen: bodies along a side of the heap
    place = np.stack(np.unravel_index(np.arange(BODIES), (BODIES, *[edge] * (dimension - 1))), axis=1)[:, ::-1] * 0.25
    position = np.tile(place + rng.normal(size=place.shape) * 0.02, (FRAMES, 1, 1))
    position[..., -1] += RADIUS + 0.05 * np.abs(np.sin(3 * t[:, None] + place[:, 0]))
    angle = t[:, None] * rng.normal(size=BODIES)
    start, m = np.arange(FRAMES + 1) * TOUCHING, FRAMES * TOUCHING
    number, frame = rng.integers(0, BODIES, m), np.repeat(np.arange(FRAMES), TOUCHING)
    normal, friction = np.zeros((m, dimension)), np.zeros((m, dimension))
    normal[:, -1], friction[:, 0] = 1.0, 0.1 * rng.normal(size=m)
    mode, P_N = rng.integers(1, 3, m), rng.random(m)
    foot, half = position[frame, number] - RADIUS * normal, np.full(m, 0.5)
    contacts = Contacts(start, number, foot, normal, mode, np.zeros(m), P_N, friction, mu=half)
    curve = Curve("energies", "kinetic", "J", np.abs(np.cos(3 * t)))
    turn = angle if dimension == 2 else about_an_axis(angle, rng.normal(size=(BODIES, 3)))
    return Film("heap", t, bodies_of(dimension), position, turn, contacts, curves=(curve,))


def bodies_of(dimension: int) -> tuple[Body, ...]:
    """Boxes, balls and capsules in turn."""
    ends = np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])[:, :dimension] * RADIUS
    square = RADIUS * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    box: Any = Shape(ShapeKind.POLYGON, square) if dimension == 2 else Shape(ShapeKind.BOX, np.full((1, 3), RADIUS))
    ball = Shape(ShapeKind.DISC if dimension == 2 else ShapeKind.SPHERE, np.zeros((1, dimension)), RADIUS)
    shapes = (box, ball, Shape(ShapeKind.CAPSULE, ends, RADIUS / 2))
    return tuple(Body(f"body {k}", (shapes[k % 3],)) for k in range(BODIES))


def about_an_axis(angle: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Unit quaternions (n_t, n_b, 4)."""
    axis = axis / np.linalg.norm(axis, axis=1)[:, None]
    return np.concatenate([np.cos(angle / 2)[..., None], np.sin(angle / 2)[..., None] * axis], axis=2)
