"""``python -m benchmarks robots [FOLDER ...]``: files of MuJoCo models and robots as scenes, and how they move.

Each file is read; it moves for a tenth of a second without contacts and limits, next to MuJoCo; and it stands or falls
for two seconds on the ground. FOLDER holds .xml or .urdf files; left out: those of gymnasium and example-robot-data.
"""

from __future__ import annotations

import os
import platform
import re
import sys
import sysconfig
import time
import warnings
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

import nonsmooth as ns
from benchmarks.peers import adapter, imports
from nonsmooth.scenes.parts import parts_of
from nonsmooth.scenes.places import compose, place_of, rotate

IN_PACKAGES = ("gymnasium/envs/mujoco/assets", "cmeel.prefix/share/example-robot-data/robots")
ROBOTS = ("double_pendulum_simple", "panda", "ur5_robot", "solo12", "anymal", "go2", "bolt", "kinova",
          "simple_humanoid", "so101")  # of the second one  # fmt: skip
FREE, T_END = 0.1, 2.0  # s
DT_FREE, DT = 1e-4, 1e-3  # s
ABOVE = 0.01  # m, from a robot of a URDF to the ground below it
OVERLAP = re.compile(r"(.+) and (.+) overlap at the start")
LOWER = 0.05  # m, by which a floor is lowered, as often as a model begins in it


def main(words: list[str]) -> int:
    """Print the tables, and what was not understood."""
    folders = list(map(Path, words) if words else installed())
    files = [file for folder in folders for file in files_in(folder)]
    if not files:
        print("there is no .xml or .urdf file; name a folder, or install gymnasium and example-robot-data",
              file=sys.stderr)  # fmt: skip
        return 2
    warnings.simplefilter("ignore")
    print(f"{platform.platform()}, Python {platform.python_version()}, load {os.getloadavg()[0]:.1f}\n")
    print("| file | bodies | joints | off MuJoCo [m] | ms a step | worst residual | missed | joints apart [m] "
          "| deepest [m] | root sinks by [m] | fastest at the end [m/s] |\n|" + "---|" * 11)  # fmt: skip
    said: dict[str, tuple[str, ...]] = {}
    notes: list[str] = []
    for file in files:
        try:
            scene = ns.Scene.load(file)
            said[file.name] = scene.not_understood
            sol, seconds = stand(scene, file, notes)
        except (ns.NonsmoothError, ValueError) as refusal:
            print(f"| {file.name} | {refusal} |" + " |" * 9, flush=True)
            continue
        print(row(file, scene, sol, seconds, notes), flush=True)
    print("".join(f"\n- {note}" for note in notes))
    for name, sentences in said.items():
        print(f"\n**{name}**" + "".join(f"\n- {marked(sentence)}" for sentence in sentences))
    tell_refused([file for folder in folders for file in all_files(folder)])
    return 0


def marked(sentence: str) -> str:
    """A sentence with its elements of XML as code, which a page shows."""
    return re.sub(r"(<\w+>)", r"`\1`", sentence)


def tell_refused(files: list[Path]) -> None:
    """Print how many of all files are read, and why others are not."""
    reasons = []
    for file in files:
        try:
            ns.Scene.load(file)
        except ns.NonsmoothError as refusal:
            reasons.append(f"- {file.name}: {str(refusal).removeprefix(str(file)).lstrip(': ')}")
    print(f"\n{len(files) - len(reasons)} of {len(files)} files are read; the others are refused:\n")
    print("\n".join(reasons))


def installed() -> Iterator[Path]:
    """The folders of packages that are installed."""
    return (place for name in IN_PACKAGES if (place := Path(sysconfig.get_paths()["purelib"]) / name).is_dir())


def all_files(folder: Path) -> list[Path]:
    """The files of a folder."""
    return sorted(folder.glob("*.xml")) + sorted(folder.rglob("*.urdf"))


def files_in(folder: Path) -> list[Path]:
    """Those that are run: of many URDF those of ROBOTS."""
    models, robots = sorted(folder.glob("*.xml")), sorted(folder.rglob("*.urdf"))
    known = {file.stem: file for file in robots if file.stem in ROBOTS}
    return models + ([known[name] for name in ROBOTS if name in known] if len(robots) > len(ROBOTS) else robots)


def off_mujoco(file: Path) -> float:
    """How far a centre of mass is from where MuJoCo has it, of what moves freely, and of what its motors drive."""
    if not imports("mujoco"):
        return np.nan
    robots = adapter("mujoco_robots")
    largest = 0.0
    for control in [None] if file.suffix == ".urdf" else [None, robots.controls(file)]:
        values = {} if control is None else dict(zip(names_of_controls(file), map(float, control), strict=True))
        scene = ns.Scene.load(file, **({"fixed_base": 1.0} if file.suffix == ".urdf" else values))
        set_free(scene)
        sol = ns.simulate(scene, (0, FREE), integrator=ns.MoreauJean(dt=DT_FREE), record=("bodies",))
        for name, place in robots.places(file, FREE, control).items():
            largest = max(largest, float(np.abs(sol[name].position[-1] - place).max()))
    return largest


def names_of_controls(file: Path) -> list[str]:
    """What a model is driven by."""
    return list(ns.Scene.load(file).parameter_values)


def set_free(scene: Any) -> None:
    """Let nothing touch, nor stop, nor rub in joints."""
    scene.ignored = list(combinations(scene.bodies, 2))
    for joint in scene.joints:
        joint.limits.clear()
        joint.motors[:] = [motor for motor in joint.motors if motor.speed is None]


def stand(scene: Any, file: Path, notes: list[str]) -> tuple[Any, float]:
    """The run on the ground, and its seconds. What overlaps at the start is put right first: a floor is lowered, two
    bodies pass through one another."""
    if file.suffix == ".urdf":
        ground = lowest(scene) - ABOVE
        scene.fixed(ns.HalfSpace((0, 0, 1)), position=(0, 0, ground), name="ground", material=ns.Material(mu=0.7))
    while True:
        try:
            ns.simulate(scene, (0, DT), integrator=ns.MoreauJean(dt=DT))  # compiled before it is timed
            break
        except ns.InvalidInput as refusal:
            overlapping = OVERLAP.match(str(refusal))
            if overlapping is None:
                raise
            if "floor" in overlapping.groups():
                scene["floor"].position[2] -= LOWER
                notes.append(f"{file.name}: the floor is lowered by {LOWER} m, {overlapping.group()}")
            else:
                scene.ignore(*overlapping.groups())
                notes.append(f"{file.name}: {overlapping.group()}, and pass through one another")
    began = time.perf_counter()
    sol = ns.simulate(scene, (0, T_END), integrator=ns.MoreauJean(dt=DT), every=10)
    return sol, time.perf_counter() - began


def lowest(scene: Any) -> float:
    """How low the shapes of a scene reach, at most [m]."""
    low = 0.0
    for body in scene.bodies:
        for part in parts_of(body.shape, 3) if body.name != "world" else ():
            at = compose(place_of(body.position, body.turn), part.place)
            corners = rotate(at[3:], np.asarray(part.vertices)) if len(part.vertices) else np.zeros((1, 3))
            reach = part.radius + (0.0 if len(part.vertices) else float(np.linalg.norm(part.size)))
            low = min(low, float((at[:3] + corners)[:, 2].min()) - reach)
    return low


def row(file: Path, scene: Any, sol: Any, seconds: float, notes: list[str]) -> str:
    """Of a file that was read."""
    stats, moving = sol.stats, [body for body in scene.bodies if body.mass is not None]
    try:
        off = f"{off_mujoco(file):.1e}"
    except ValueError as refusal:
        off = "it refuses the file"
        notes.append(f"{file.name}: MuJoCo says {' '.join(str(refusal).split())}")
    root, speed = moving[0].index, np.linalg.norm(sol.velocity[-1], axis=1).max()
    sinks = sol.position[0, root, 2] - sol.position[-1, root, 2]
    cells = [
        file.name, len(moving), len(scene.joints), off, f"{1e3 * seconds / max(1, stats.steps):.2f}",
        f"{stats.worst_residual:.1e}", stats.missed, f"{stats.worst_joint_drift:.1e}",
        f"{stats.worst_penetration:.1e}", f"{sinks:.3f}", f"{speed:.1e}",
    ]  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"
