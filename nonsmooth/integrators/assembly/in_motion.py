"""A scene in motion, whatever its steps are: blocks that compiled steps find by their addresses, as large as they must.

Steps come back where a block is too small; it is then made larger, with all that is in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from nonsmooth.integrators.assembly.bodies import Bodies
from nonsmooth.integrators.assembly.joints import Joints, Reactions, leave_out_ignored
from nonsmooth.integrators.assembly.pairs import Pairs, begin_pairs, exchanged, with_room
from nonsmooth.integrators.assembly.progress import MORE_BOOKS, MORE_CONTACTS, MORE_PAIRS
from nonsmooth.jit import Kernel, load_all
from nonsmooth.jit.blocks import Block
from nonsmooth.scenes.detection import NOT_FINITE, Found
from nonsmooth.scenes.shape_rows import Shapes

ROOM = 1.5  # chosen: by which a block is larger than what it was too small for


class Stages(NamedTuple):
    """The compiled steps of the plane or of space."""

    take: Kernel
    find: Kernel
    scratch: Callable[[Shapes, int], Any]
    others: tuple[Kernel, ...]  # that are called by ``take``

    def load(self) -> None:
        """Compile them, or read them from disk."""
        load_all([self.take, self.find, *self.others])


class InMotion:
    """What steps with rigid contacts (step.py) and on springs (springs/scene_springs.py) have in common."""

    handed: ClassVar[tuple[str, ...]]  # blocks that the steps are handed, beside that of the motion of the bodies
    kept: ClassVar[tuple[str, ...]]  # blocks that a step takes something from that the step before left
    dim: int
    bodies: Bodies
    shapes: Shapes
    found: Found
    joints: Joints
    reactions: Reactions
    pairs: Pairs
    progress: Any
    stages: Stages
    n_others: Any = 0  # blocks of rows that are no contacts

    def _make_room(self, m: int) -> None:
        """Blocks for m contacts, with what is in them."""
        raise NotImplementedError

    def make_more_room(self, end: int) -> bool:
        """Make the block larger that was too small for the steps; False where they came back for something else."""
        if end not in (MORE_CONTACTS, MORE_PAIRS, MORE_BOOKS):
            return False
        wanted = int(ROOM * int(self.progress.wanted))
        if end == MORE_CONTACTS:
            self._make_room(wanted)
        elif end == MORE_PAIRS:
            self._make_scratch(wanted)
            self.go_on()
        else:
            self._make_room_for_pairs(wanted)
        return True

    def find_contacts(self, margin: float = 0.0) -> int:
        """The contacts at the present places with gaps below a margin [m], to ``found``; returns their number, or
        NOT_FINITE where a body is nowhere. Bodies that pass through one another have none."""
        while True:
            places = self.progress.places
            n = int(self.stages.find(places.shapes, places.motion, 0.0, margin, places.found, places.scratch))
            if 0 <= n <= len(self.found.gap):
                if self.joints.apart > 0:
                    n = int(leave_out_ignored(places.joints, places.shapes, places.found, n))
                return n
            if n > 0:
                self._make_room(int(ROOM * n))
            elif n > NOT_FINITE:
                self._make_scratch(int(ROOM * -n))
                self.go_on()
            else:
                return NOT_FINITE

    def exchanged(self) -> dict[str, np.ndarray]:
        """What each pair of bodies exchanged since the record before."""
        return exchanged(self.pairs)

    def begin_pairs(self) -> None:
        """What pairs of bodies exchange is summed up anew."""
        begin_pairs(self.pairs.address)

    def reactions_of_joints(self) -> dict[str, np.ndarray]:
        """Impulses and angular impulses of the last step on the second bodies of joints; forces, torques on springs."""
        torque = self.reactions.torque
        return {"joint_impulses": self.reactions.P, "joint_torques": torque if self.dim == 3 else torque[:, 0]}

    @property
    def carried(self) -> dict[str, Block]:
        """All that the next step depends on."""
        return {name: getattr(self, name) for name in self.kept}

    def go_on(self) -> None:
        """Let the steps find the blocks of this process."""
        places = self.progress.places
        places.motion = self.bodies.motion.address
        for name in self.handed:
            setattr(places, name, getattr(self, name).address)

    def _make_scratch(self, room: int) -> None:
        """Room for so many pairs of shapes; ``go_on`` afterwards."""
        self.room, self.scratch = room, self.stages.scratch(self.shapes, room)

    def _make_room_for_pairs(self, n_p: int) -> None:
        """A block for n_p pairs, with those that there are."""
        self.pairs = with_room(self.pairs, n_p, self.dim)
        self.go_on()
