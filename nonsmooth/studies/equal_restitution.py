"""What the springs of a penalty study give back of a collision, and the rigid contact that they are compared with.

    e(zeta) of the springs (integrators/penalty/restitution.py),    2 zeta = c sqrt(G_NN/k) at the start

Motions whose collisions give back different parts tend to different limits. So the two are made equal unless each is to
keep its own: where no damping was given it is chosen for the rigid e_N, otherwise the rigid contacts take the e of the
stiffest springs.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.integrators.penalty.restitution import damping_ratio_for, restitution_of
from nonsmooth.mechanics.laws import LAW_E_N
from nonsmooth.mechanics.system import UNILATERAL
from nonsmooth.scenes.elements import Kind
from nonsmooth.scenes.pair_laws import coefficients_of
from nonsmooth.scenes.scene import Scene
from nonsmooth.studies.force_history import first_episode
from nonsmooth.studies.reference import Problem, SceneProblem

if TYPE_CHECKING:
    import xarray

RESTITUTIONS = ("equal", "own")
SAME = 5e-4  # chosen: two coefficients are the same in three digits


@dataclass(frozen=True)
class Restitution:
    """Both sides of a study.

    Attributes
    ----------
    springs : ndarray (n,)
        e at each stiffness; NaN where it is not known.
    rigid, own : float
        e_N of the rigid contact of the study, and of the model.
    of : str
        The contact.
    zeta : float
        The damping ratio where it was chosen for ``own``; otherwise NaN.
    is_measured : bool
        Whether ``springs`` comes from a run and not from the closed form.
    """

    springs: np.ndarray
    rigid: float
    own: float
    of: str
    zeta: float = math.nan
    is_measured: bool = False

    @property
    def words(self) -> str:
        """Both numbers and where they come from, a sentence."""
        ends = list(dict.fromkeys(f"{e:.3g}" for e in self.springs[[0, -1]]))
        source = "measured at the stiffest" if self.is_measured else "closed form"
        if math.isfinite(self.zeta):
            source += f", zeta = {self.zeta:.4g} chosen for it"
        springs = f"{' to '.join(ends)} ({source})" if math.isfinite(self.springs[-1]) else "unknown: it does not open"
        instead = f", in place of the model's {self.own:.3g}" if abs(self.rigid - self.own) > SAME else ""
        return f"restitution of {self.of}: springs e = {springs}; rigid contact e_N = {self.rigid:.3g}{instead}"

    def columns(self, data: xarray.Dataset) -> xarray.Dataset:
        """The data of a study with both."""
        attrs = {"e_N": self.rigid, "e_N_of_model": self.own, "restitution": self.words}
        return data.assign(e_springs=("stiffness", self.springs)).assign_attrs(attrs)


def chosen_damping(problem: Problem, contact: int, law: str) -> float | None:
    """The damping ratio whose collisions give back the e_N of a contact; None where a contact has no restitution, or
    its springs have none of their own."""
    e_N = own_restitution(problem, contact)
    zeta = damping_ratio_for(law, e_N) if math.isfinite(e_N) else math.nan
    return zeta if math.isfinite(zeta) else None


def own_restitution(problem: Problem, contact: int) -> float:
    """e_N of a contact of the model, or the largest of a scene; NaN where it is not unilateral."""
    if isinstance(problem, SceneProblem):
        return max(restitutions_in(problem.scene), default=math.nan)
    system = problem.system
    return float(system.laws[contact, LAW_E_N]) if system.kinds[contact, 0] == UNILATERAL else math.nan


def restitutions_in(scene: Scene) -> Iterable[float]:
    """e of every two materials that may touch."""
    moving = {body.material for body in scene.bodies if body.kind == Kind.DYNAMIC}
    every = {body.material for body in scene.bodies}
    return {coefficients_of(scene, a, b)[1] for a in moving for b in every}


def compared(
    problem: Problem, compliant: list[Penalty], contact: int, zeta: float | None, is_equal: bool
) -> tuple[Restitution | None, Problem]:
    """What the springs and the rigid contact give back, and the rigid motion, made equal to the springs if asked; None
    of a contact that has no restitution.

    Parameters
    ----------
    problem : Problem
    compliant : list of Penalty
        From the softest to the stiffest.
    contact : int
    zeta : float or None
        Where it was chosen for the e_N of the contact.
    is_equal : bool
    """
    own = own_restitution(problem, contact)
    if not math.isfinite(own):
        return None, problem
    springs = np.array([spring_restitutions(problem, integrator)[contact] for integrator in compliant])
    is_scene = isinstance(problem, SceneProblem)
    is_measured = not math.isfinite(springs[-1]) and not is_scene
    if is_measured:
        springs[-1] = measured_restitution(problem, compliant[-1], contact)
    of = "the bodies" if is_scene else problem.system.described.contacts[contact]
    found = Restitution(springs, own, own, of, math.nan if zeta is None else zeta, is_measured)
    return made_equal(problem, found, compliant[-1], contact) if is_equal else (found, problem)


def spring_restitutions(problem: Problem, integrator: Penalty) -> np.ndarray:
    """(n_c,) By the closed form; NaN where it depends on more than the damping ratio at the start. Of a scene (1,)."""
    if isinstance(problem, SceneProblem):
        is_ratio = integrator.damping is None and integrator.mass is None
        return np.array([restitution_of(integrator.law, integrator.damping_ratio or 0.0) if is_ratio else math.nan])
    k, c, omega = integrator.constants(problem.system, *problem.start).T
    e = [restitution_of(integrator.law, zeta) for zeta in (0.5 * c * omega / k).tolist()]
    return np.where(problem.system.kinds[:, 0] == UNILATERAL, e, math.nan)


def measured_restitution(problem: Problem, integrator: Penalty, contact: int) -> float:
    """Of the first episode of a contact; NaN where there is none that ends."""
    episode = first_episode(problem, integrator, problem.run(integrator, problem.times), contact)
    return math.nan if episode is None else min(1.0, episode.restitution)


def made_equal(problem: Problem, found: Restitution, stiffest: Penalty, contact: int) -> tuple[Restitution, Problem]:
    """The rigid motion whose unilateral contacts give back what the stiffest springs do, where that is known: what the
    damper was chosen for, or what it gives."""
    e = spring_restitutions(problem, stiffest)
    e[contact] = found.springs[-1]
    if math.isfinite(found.zeta):
        e[np.isfinite(e)] = found.own
    if not math.isfinite(e[contact]):
        return found, problem
    found = replace(found, rigid=float(e[contact]))
    if isinstance(problem, SceneProblem):
        return found, replace(problem, model=scene_giving_back(problem.scene, found.rigid))
    laws = problem.system.laws[:, LAW_E_N]
    e = np.where(np.isfinite(e), e[contact] if problem.system.contacts[contact].law_of_impact == "poisson" else e, laws)
    if (np.abs(e - laws) <= SAME).all():
        return replace(found, rigid=found.own), problem
    contacts = [replace(old, e_N=e_N) for old, e_N in zip(problem.system.contacts, e.tolist(), strict=True)]
    return found, replace(problem, model=replace(problem.system, contacts=contacts))


def scene_giving_back(scene: Scene, e: float) -> Scene:
    """The scene with this e for any two bodies."""
    other = copy.copy(scene)
    other.bodies = [replace(body, material=replace(body.material, e=e)) for body in scene.bodies]
    other.pairs = {names: (mu, None) for names, (mu, _) in scene.pairs.items()}
    return other
