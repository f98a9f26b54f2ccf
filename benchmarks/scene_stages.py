"""Which stage of a step of falling spheres takes how long: the stages of a step in space, called one by one."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.peers import adapter
from models.scenes import SphereBox
from nonsmooth.contact.network.problem import judge_network, prepare_network
from nonsmooth.contact.network.rescue import rescue
from nonsmooth.contact.network.solve import solve_network
from nonsmooth.integrators.assembly.book import book_step
from nonsmooth.integrators.assembly.contacts import write_contacts
from nonsmooth.integrators.assembly.held_closed import hold_closed
from nonsmooth.integrators.assembly.progress import margin_of
from nonsmooth.integrators.assembly.project import move_bodies
from nonsmooth.integrators.assembly.spatial import take_spins, turn_inertia
from nonsmooth.integrators.assembly.stages import predict
from nonsmooth.integrators.assembly.wandering import ask_of_wandering, note_held
from nonsmooth.jit import interpreted

STAGES = ("predict", "find", "turn", "write", "prepare", "solve", "rescue", "judge", "move", "book")
PARTS = 5  # chosen: of the run, told apart
ROOM, ROOM_OF_FEW = 6, 100  # chosen: contacts a sphere, and beside: a heap has three a sphere
PAIRS = 200  # chosen: that are near each other, a sphere
FACTOR_ROOM = 1.5  # chosen: by which there is more room for factors than was wanted


class Stepper:
    """A motion whose steps are taken stage by stage; it does not know bodies that rebound, nor divided steps."""

    def __init__(self, motion: Any) -> None:
        self.assembly, self.dt = motion.run.assembly, motion.dt
        self.motion, self.seconds = motion, dict.fromkeys(STAGES, 0.0)

    def timed(self, stage: str, call: Callable, *arguments: Any) -> Any:
        """What the call returns."""
        began = time.process_time()
        result = call(*arguments)
        self.seconds[stage] += time.process_time() - began
        return result

    def step(self) -> None:
        """One step."""
        assembly, progress, at, dt = self.assembly, self.assembly.progress, self.assembly.progress.places, self.dt
        progress.dt = dt
        self.timed("predict", predict[3], at.bodies, dt)
        margin = interpreted(margin_of)(progress, assembly.bodies)
        n = self.timed("find", assembly.stages.find, at.shapes, at.motion, dt, margin, at.found, at.scratch)
        if not 0 <= n <= len(assembly.found.gap):
            raise RuntimeError(f"the search for contacts came back with {n}")
        network = assembly.network
        network.n_c = n
        self.timed("turn", turn_inertia, at.bodies, at.network)
        places = at.bodies, at.shapes, at.surfaces, at.found, at.contacts, at.network
        self.timed("write", write_contacts[3], *places, dt)
        self.timed("prepare", prepare_network[3], at.network)
        wanders = at.bodies, at.found, at.contacts, at.network
        self.timed("prepare", ask_of_wandering, *wanders, dt, assembly.solver.approach)
        held = at.bodies, at.found, at.network, at.solver
        self.timed("prepare", hold_closed, *held, dt, progress.tight)
        self.solve()
        self.timed("judge", judge_network[3], at.network)
        moved = at.bodies, at.found, at.contacts, at.network, at.moves
        pushed = self.timed("move", move_bodies[3], *moved, dt, progress.theta, progress.tight)
        booked = at.bodies, at.found, at.contacts, at.network, at.moves, at.ledger
        self.timed("book", book_step, *booked, dt, pushed)
        self.timed("book", note_held, *wanders, dt)
        interpreted(take_spins)(assembly.bodies, assembly.bodies.motion.v)

    def solve(self) -> None:
        """The contact problem, with as much room for factors as it wants; where it is not met, other solvers."""
        assembly, at = self.assembly, self.assembly.progress.places
        while (wanted := self.timed("solve", solve_network[3], at.network, at.solver, at.desk)) > 0:
            assembly.fill = int(FACTOR_ROOM * wanted)
            assembly._make_solver()
        islands = assembly.network.islands
        if not islands.is_met[: int(islands.count)].all():
            self.timed("rescue", rescue, assembly.network, assembly.solver, assembly.tol)


def print_stages(n: int, steps: int, options: dict[str, Any]) -> None:
    """Milliseconds a step of each stage, over parts of the run, for a coarse tolerance and the default."""
    scene = SphereBox(n=n)
    for label, given in (("default options", {}), (", ".join(f"{k}={v:g}" for k, v in options.items()), options)):
        print(f"\n{n} spheres, {label}: processor ms a step\n")
        print("| steps | " + " | ".join(STAGES) + " | sum | contacts | sweeps | factors |\n" + "|---" * 15 + "|")
        stepper = make_stepper(scene, given)
        for steps_of_part in np.array_split(np.arange(steps), PARTS):
            if len(steps_of_part):
                print(part(stepper, steps_of_part))


def make_stepper(scene: SphereBox, options: dict[str, Any]) -> Stepper:
    """With room for all that will touch."""
    motion = adapter("nonsmooth_scenes").Motion(scene.scene(), scene.dt, **options)
    motion.run.assembly._make_room(ROOM * scene.n + ROOM_OF_FEW)
    motion.run.assembly.scratch = motion.run.assembly.stages.scratch(motion.run.assembly.shapes, PAIRS * scene.n)
    motion.run.assembly.go_on()
    motion.step(0)  # sets the margin of the search
    return Stepper(motion)


def part(stepper: Stepper, steps: np.ndarray) -> str:
    """A row of the table."""
    stepper.seconds = dict.fromkeys(STAGES, 0.0)
    network, work = stepper.assembly.network, np.zeros(3)
    for _ in steps:
        stepper.step()
        islands = network.islands
        k = int(islands.count)
        work += network.n_c, islands.sweeps[:k].sum(), islands.factors[:k].sum()
    times = [1e3 * seconds / len(steps) for seconds in stepper.seconds.values()]
    cells = [*(f"{t:.3f}" for t in times), f"{sum(times):.2f}", *(f"{w:.0f}" for w in work / len(steps))]
    return f"| {steps[0]} to {steps[-1]} | " + " | ".join(cells) + " |"
