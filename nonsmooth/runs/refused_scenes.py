"""What methods refuse of scenes, in one list: each with what ends it, or with the method that takes it.

How large a scene may be that is integrated as its system is in scene_by_system.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from nonsmooth.contact.planar.selection import Selection
from nonsmooth.errors import InvalidInput
from nonsmooth.integrators.moreau_jean.options import MoreauJean
from nonsmooth.integrators.penalty.law import Regularised
from nonsmooth.integrators.penalty.options import Penalty
from nonsmooth.mechanics.laws import LAW_CODE, STATIC_KINETIC, ImpactLaw
from nonsmooth.results.recorded import EVENTS, PAIRS
from nonsmooth.runs.recorder import SceneRun
from nonsmooth.scenes.shapes import SPATIAL


def require_taken(run: SceneRun, project: bool, functions: Sequence[Callable], threads: int) -> None:
    """Raise `InvalidInput` for the first thing of a run that its method does not take; ``functions`` are events."""
    for sentence in refused(run, project, functions, threads):
        raise InvalidInput(sentence)


def require_taken_by_system(method: str, asked: Mapping[str, Any]) -> None:
    """Raise `InvalidInput` for the first option that was asked for of a scene that is integrated as its system."""
    from nonsmooth.scenes.as_system import CURE

    for option in (option for option, value in asked.items() if value):
        name, _, value = option.partition("=")
        raise InvalidInput(
            f"{method} integrates a scene as its system, which takes no {name}={value}; leave it out, or {CURE}"
        )


def refused(run: SceneRun, project: bool, functions: Sequence[Callable], threads: int) -> Iterator[str]:
    """All that a method does not take of what was asked for."""
    yield from refused_by_all(run, project, functions)
    if isinstance(run.integrator, Penalty):
        yield from refused_by_springs(run, threads)
        return
    if isinstance(run.integrator, MoreauJean):
        yield from refused_by_moreau_jean(run)
    yield from refused_by_rigid_steps(run)


def refused_by_all(run: SceneRun, project: bool, functions: Sequence[Callable]) -> Iterator[str]:
    """What neither of them takes."""
    scene = run.scene
    if len(scene.bodies) == 0:
        yield "the scene has no bodies; add them by scene.body(...), scene.fixed(...)"
    if project and scene.joints:
        yield (
            f"project=True moves bodies apart that no joint holds, and the scene has {scene.joints[0].name}; move "
            "them apart by hand"
        )
    if run.recorder.is_resumed and functions:
        yield "a run with a checkpoint looks for no events; leave out events=, or checkpoint= and resume="
    if run.recorder.is_resumed and EVENTS in run.recorder.kinds:
        yield 'a checkpoint keeps no events; leave "events" out of record=, or leave out checkpoint= and resume='


def refused_by_moreau_jean(run: SceneRun) -> Iterator[str]:
    """Options of `MoreauJean` that are not for scenes."""
    if run.integrator.projection:
        yield "bodies of a scene are pushed apart in every step; leave out projection= of MoreauJean"
    if run.integrator.specialise is True:
        yield (
            "a loop is compiled for a System alone, the steps of a scene are the same for all; leave out "
            "specialise= of MoreauJean"
        )
    if run.integrator.compliance is not None:
        yield from refused_joints(run, "MoreauJean with compliance=")
        yield from refused_adhesion(run, "MoreauJean with compliance=")


def refused_by_rigid_steps(run: SceneRun) -> Iterator[str]:
    """What steps with rigid contacts do not take."""
    surfaces = run.world.surfaces
    rebounding = [joint.name for joint in run.scene.joints if joint.e > 0.0]
    if surfaces.impact != ImpactLaw.NEWTON and rebounding:
        yield (
            f"limits and ropes rebound by Newton's law, {rebounding[0]} does, and a material of the scene has impact = "
            f"{ImpactLaw(surfaces.impact).name.lower()!r}; give impact='newton', or leave out e= of the joint"
        )
    if surfaces.impact != ImpactLaw.NEWTON and run.scene.dim == SPATIAL and (surfaces.mu > 0.0).any():
        yield (
            f"impact = {ImpactLaw(surfaces.impact).name.lower()!r} in space is one without friction, and a material of "
            "the scene has mu > 0; give mu=0, or impact='newton'"
        )


def refused_by_springs(run: SceneRun, threads: int) -> Iterator[str]:
    """What `Penalty` does not take."""
    yield from refused_drives(run)
    if (run.world.surfaces.rolling > 0.0).any() or (run.world.surfaces.spinning > 0.0).any():
        yield (
            "rolling and spinning friction are laws of rigid contacts, which Penalty has not, and a material of the "
            "scene has some; take MoreauJean(dt)"
        )
    yield from refused_adhesion(run, "Penalty")
    if run.world.surfaces.has_grain:
        yield (
            "springs of Penalty rub alike in all directions, and a material of the scene has EllipticFriction; take "
            "MoreauJean(dt)"
        )
    if threads > 1:
        yield (
            "threads share the islands of a contact problem, and Penalty has none: the stages of its steps are so "
            "short that to hand them over costs what is gained; leave out threads=, or take MoreauJean(dt)"
        )
    if run.selection != Selection.COMPLIANT_LIMIT:
        yield "springs have one answer, that of the compliant limit; leave out selection=, or take MoreauJean(dt)"
    if run.world.surfaces.impact != ImpactLaw.NEWTON:
        yield (
            f"springs and dampers say how bodies rebound, and a material has impact = "
            f"{ImpactLaw(run.world.surfaces.impact).name.lower()!r}; leave out impact=, or take MoreauJean(dt)"
        )
    laws = run.world.surfaces.laws
    if (laws[:, LAW_CODE] == STATIC_KINETIC).any():
        yield (
            "a spring that slides has one coefficient at rest, and a material of the scene has a law of static and "
            "kinetic friction; take ns.Stribeck, or MoreauJean(dt)"
        )
    if run.integrator.law == "hunt-crossley" and not isinstance(run.integrator.friction, Regularised):
        yield (
            "hunt-crossley has no stiffness [N/m] that a tangential spring could have a part of; give "
            "friction=ns.Regularised(v_s), or another law"
        )


def refused_drives(run: SceneRun) -> Iterator[str]:
    """What of joints `Penalty` does not take."""
    for joint in run.scene.joints:
        held = [motor for motor in joint.motors if motor.load is None]
        if held or joint.friction is not None:
            what = "a motor that holds a speed" if held else "friction"
            yield f"a joint on springs has no set-valued law, and {joint.name} has {what}; take MoreauJean(dt)"
        if joint.springs:
            yield f"Penalty knows no springs on coordinates of joints, and {joint.name} has one; take MoreauJean(dt)"
        if joint.e > 0.0:
            yield f"springs and dampers say how bodies rebound, and {joint.name} has e = {joint.e:g}; leave it out"
        if run.integrator.law == "hunt-crossley":
            yield f"hunt-crossley has no stiffness [N/m] that {joint.name} could have; take another law"
    if run.scene.joints and PAIRS in run.recorder.kinds:
        yield 'pairs of Penalty are those of contacts, and the scene has joints; leave "pairs" out of record='


def refused_adhesion(run: SceneRun, what: str) -> Iterator[str]:
    """Contacts that adhere, where they are not known."""
    if (run.world.surfaces.adhesion > 0.0).any():
        yield f"{what} has springs that push, and a material of the scene has adhesion; take MoreauJean(dt), rigid"


def refused_joints(run: SceneRun, what: str) -> Iterator[str]:
    """Joints, where they are not known."""
    if run.scene.joints:
        yield f"{what} does not hold joints, and the scene has {run.scene.joints[0].name}; take MoreauJean(dt), rigid"
