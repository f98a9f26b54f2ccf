"""``nonsmooth study stability | cycle | penalty | convergence``."""

from __future__ import annotations

import argparse
import functools
from typing import TYPE_CHECKING, Any

from nonsmooth.commands.integrators import add_integrator, given_options, integrator_class
from nonsmooth.commands.outputs import (
    add_drawn,
    add_printed,
    add_progress,
    add_resumed,
    add_saved,
    add_workers,
    attrs_as_json,
    dataset_as_json,
    part_told,
    progress_of,
    save_json,
    tell,
    tell_file,
)
from nonsmooth.commands.terminal import complain, figure_path
from nonsmooth.commands.typed_input import (
    AXIS,
    assignments,
    initial_state,
    is_number,
    number,
    read_axis,
    require_writable,
)
from nonsmooth.commands.typed_model import MODEL, is_scene, require_units, typed_model
from nonsmooth.errors import INTERRUPTED, InvalidInput

if TYPE_CHECKING:
    from nonsmooth.studies.stability import StabilityStudy
    from nonsmooth.studies.study import Study

JSON_ENDINGS = (".json",)
REFERENCES = ("event-driven",)


def add_studies(studies: Any) -> None:
    """Every study with its options."""
    for name, what, act in (
        ("stability", "steady sliding: eigenvalues, and their change with one or two parameters", act_stability),
        ("cycle", "the periodic motion: phases, Floquet multipliers, and their change with a parameter", act_cycle),
    ):
        add_vibration(studies.add_parser(name, help=what), act, name)
    stability, cycle = studies.choices["stability"], studies.choices["cycle"]
    add_state(stability, "near which steady sliding is looked for")
    for option, what in (("sliding", "gamma_F; those of the surface velocities by default"),
                         ("normal", "the normal forces of bilateral contacts; 1 by default")):  # fmt: skip
        stability.add_argument(f"--{option}", nargs="+", type=number, metavar="SIGN", help=f"signs of {what}")
    add_start(cycle, "from which the motion is simulated", "that is simulated, twice as long where it has not settled")
    cycle.add_argument("--dt", type=number, help="simulate with this step [s]; with located events by default")
    cycle.add_argument("--forcing", type=number, metavar="T", help="period of the forcing [s]")
    add_bifurcation(studies)
    add_limits(studies)


def add_bifurcation(studies: Any) -> None:
    """The options of the study of what motions settle into."""
    study = studies.add_parser("bifurcation", help="what the motion settles into along a parameter, up and down")
    add_vibration(study, act_bifurcation, "bifurcation")
    study.add_argument("--coordinate", metavar="NAME", help="whose maxima are kept; the first by default")
    add_start(study, "of the first motion", "at each value, the last fifth of which is looked at")
    study.add_argument("--dt", type=number, help="step [s]; the model's own by default")
    study.add_argument("--forcing", metavar="T", help="period of the forcing [s], or the parameter that says it: a "
                       "section once a period")  # fmt: skip
    add_workers(study, "processes for several starts; 1 by default")


def add_start(study: argparse.ArgumentParser, start: str, motion: str) -> None:
    """Where the motion of a study begins, and how long it is."""
    add_state(study, start)
    study.add_argument("--duration", type=number, metavar="T", help=f"of the motion {motion} [s]")


def add_state(study: argparse.ArgumentParser, start: str) -> None:
    """A state by the natural variables of the model."""
    study.add_argument("--state", nargs="+", action="extend", default=[], metavar="NAME=VALUE",
                       help=f"initial state, e.g. th=pi/4, {start}")  # fmt: skip


def add_limits(studies: Any) -> None:
    """The options of the studies of limits."""
    penalty = studies.add_parser("penalty", help="compliant contact against rigid contact, over the stiffness")
    penalty.add_argument("--stiffness", nargs="+", type=number, metavar="K", help="[N/m]; 1e4 to 1e12 by default")
    penalty.add_argument("--damping-ratio", type=number, metavar="ZETA", help="c = 2 zeta sqrt(k m)")
    penalty.add_argument("--damping", type=number, metavar="C", help="[N s/m]")
    penalty.add_argument("--damping-time", type=number, metavar="T", help="c = k T [s]")
    equal = "equal (the default): chosen so that springs and rigid contact give back the same; own: each its own"
    penalty.add_argument("--restitution", choices=("equal", "own"), default="equal", help=equal)
    convergence = studies.add_parser("convergence", help="errors of an integrator over its step or its tolerance")
    add_integrator(convergence, many=("dt", "rtol"))
    convergence.add_argument("--reference", choices=REFERENCES, help="exact states; the same integrator by default")
    makers = {"penalty": (penalty, study_penalty), "convergence": (convergence, study_convergence)}
    for name, (command, make) in makers.items():
        more = "; a scene too" if name == "penalty" else ""
        command.set_defaults(act=act_limit, make=make, suffix=f"-{name}")
        command.add_argument("model", metavar="MODEL", help=MODEL + more)
        for option, what in (("--set", "parameters, e.g. mu=2"), ("--state", "initial state, e.g. th=pi/4")):
            command.add_argument(option, nargs="+", action="extend", default=[], metavar="NAME=VALUE", help=what)
        command.add_argument("--q0", nargs="+", type=number, metavar="Q", help="initial coordinates (with --u0)")
        command.add_argument("--u0", nargs="+", type=number, metavar="U", help="initial velocities (with --q0)")
        command.add_argument("--t-end", type=number, metavar="T", help="end [s]; the model's own by default")
        command.add_argument("--times", nargs="+", type=number, metavar="T", help="when errors are measured [s]")
        after = "time after each matched event [s]; half that to the next one by default"
        command.add_argument("--delay", type=number, metavar="T", help=after)
        add_workers(command, "processes; 1 by default")
        add_resumed(command)
        add_outputs_of_study(command, name)


def add_vibration(study: argparse.ArgumentParser, act: Any, name: str) -> None:
    """The options of the studies of equilibria and cycles."""
    study.set_defaults(act=act, suffix=f"-{name}")
    study.add_argument("model", metavar="MODEL", help=MODEL)
    study.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="parameters")
    study.add_argument("--axis", nargs="+", action="extend", default=[], metavar="AXIS", help=AXIS)
    add_outputs_of_study(study, name)


def add_outputs_of_study(study: argparse.ArgumentParser, name: str) -> None:
    """What every study prints, draws, saves and shows on the way."""
    add_drawn(study, f"where to draw; MODEL-{name}.png by default")
    add_saved(study, "save what --json prints (.json)")
    add_progress(study)
    add_printed(study)


def act_stability(arguments: argparse.Namespace) -> int:
    """``nonsmooth study stability``."""
    from nonsmooth.studies.stability import study_stability

    options = {name: getattr(arguments, name) for name in ("sliding", "normal")}
    options["state"] = assignments("--state", arguments.state) or None
    return act_vibration(arguments, functools.partial(study_stability, **options))


def act_cycle(arguments: argparse.Namespace) -> int:
    """``nonsmooth study cycle``."""
    from nonsmooth.studies.cycle import study_cycle

    options = {name: getattr(arguments, name) for name in ("duration", "dt", "forcing")}
    options["state"] = assignments("--state", arguments.state) or None
    return act_vibration(arguments, functools.partial(study_cycle, **options))


def act_bifurcation(arguments: argparse.Namespace) -> int:
    """``nonsmooth study bifurcation``."""
    from nonsmooth.studies.bifurcation import study_bifurcation

    typed = arguments.forcing
    options = {
        "coordinate": arguments.coordinate or 0, "duration": arguments.duration, "dt": arguments.dt,
        "forcing": number(typed) if typed and is_number(typed) else typed, "workers": arguments.workers,
        "progress": False, "state": assignments("--state", arguments.state) or None,
    }  # fmt: skip
    return act_vibration(arguments, functools.partial(study_bifurcation, **options))


def act_vibration(arguments: argparse.Namespace, study: Any) -> int:
    """A study of a model along the given axes: its table, then its figure."""
    model = typed_model(arguments)
    typed = [read_axis(text) for text in arguments.axis]
    axes, units = {axis.name: axis.values for axis in typed}, {axis.name: axis.unit for axis in typed}
    if len(axes) < len(arguments.axis):
        raise InvalidInput("--axis gives a parameter twice; give it once")
    require_units(model, typed)
    figure = figure_path(arguments)
    require_writable(arguments.out, JSON_ENDINGS)
    with part_told(f"the study of {arguments.model}", arguments):
        found = study(model, axes, units)
    results = functools.partial(study_as_json, arguments.model, found)
    save_json(arguments.out, results)
    tell(arguments, lambda: found.text, results)
    tell_file(arguments, "result", arguments.out)
    if found.is_interrupted:
        complain("interrupted: what stands above is finished; nothing is drawn")
        return INTERRUPTED
    if figure and found.draw:
        found.draw(figure)
        tell_file(arguments, "figure", figure)
    return 0


def study_as_json(model: str, found: StabilityStudy) -> dict[str, Any]:
    """What a script wants to know of the study of an equilibrium, of a cycle or of what a motion settles into."""
    from nonsmooth.commands.results_of_studies import as_json

    return {"model": model, "interrupted": found.is_interrupted, **as_json(found.results)}


def act_limit(arguments: argparse.Namespace) -> int:
    """``nonsmooth study penalty`` and ``nonsmooth study convergence``."""
    model = typed_model(arguments, takes_scenes=arguments.make is study_penalty)
    figure = figure_path(arguments)
    require_writable(arguments.out, JSON_ENDINGS)
    study = limit_study(model, arguments)
    results = functools.partial(limit_as_json, study)
    save_json(arguments.out, results)
    tell(arguments, study.table, results)
    tell_file(arguments, "result", arguments.out)
    if study.is_interrupted:
        more = "; the same command goes on with the rest" if arguments.journal else ""
        complain(f"interrupted: what stands above is finished{more}; nothing is drawn")
        return INTERRUPTED
    if figure:
        study.plot(figure)
        tell_file(arguments, "figure", figure)
    return 0


def limit_as_json(study: Study) -> dict[str, Any]:
    """Every error and cost over what was varied, observed orders, fitted laws, and the notes of the table."""
    laws = {name: [{"law": fit.law, "constant": fit.constant, "spread": fit.spread} for fit in study.fits(name)]
            for name in study.kinds}  # fmt: skip
    orders = {name: study.orders(name).tolist() for name in study.kinds}
    return {"title": study.title, "of": study.of, "about": attrs_as_json(study.data.attrs), "orders": orders,
            "laws": laws, "notes": study.notes(), **dataset_as_json(study.data)}  # fmt: skip


def limit_study(model: Any, arguments: argparse.Namespace) -> Study:
    """The study that the arguments ask for."""
    from nonsmooth.mechanics.start import own_time

    t_end = own_time(model, "t_end") if arguments.t_end is None else arguments.t_end
    if t_end is None:
        raise InvalidInput(f"the model {arguments.model} has no t_end of its own; give --t-end")
    return arguments.make(model, (0.0, t_end), *start_of(model, arguments), arguments)


def start_of(model: Any, arguments: argparse.Namespace) -> tuple[Any, Any]:
    """q0 and u0; of a scene none."""
    if not is_scene(model):
        return initial_state(model, arguments)
    for option in ("state", "q0", "u0", "delay"):
        if getattr(arguments, option) not in (None, []):
            raise InvalidInput(f"--{option} is no option for {arguments.model}, a scene of bodies; leave it out")
    return None, None


def study_penalty(model: Any, span: tuple[float, float], q0: Any, u0: Any, arguments: argparse.Namespace) -> Study:
    """``nonsmooth study penalty``."""
    from nonsmooth.studies.penalty_study import penalty_study

    time = arguments.damping_time
    if time is not None and arguments.damping is not None:
        raise InvalidInput("give either --damping or --damping-time; got both")
    return penalty_study(
        model, span, q0, u0, stiffness=arguments.stiffness, damping_ratio=arguments.damping_ratio,
        restitution=arguments.restitution,
        damping=arguments.damping if time is None else lambda k: k * time, times=arguments.times,
        delay=arguments.delay, workers=arguments.workers, journal=arguments.journal, progress=progress_of(arguments),
    )  # fmt: skip


def study_convergence(model: Any, span: tuple[float, float], q0: Any, u0: Any, arguments: argparse.Namespace) -> Study:
    """``nonsmooth study convergence``."""
    from nonsmooth.studies.convergence_study import STUDY_STEPS, convergence_study
    from nonsmooth.studies.reference import EXACT

    name, own, options = given_options(arguments)
    dt, rtol = options.pop("dt", None), options.pop("rtol", None)
    if "dt" in own:
        options["dt"] = (dt or STUDY_STEPS)[0]
    reference = None if arguments.reference is None else EXACT
    return convergence_study(
        model, span, q0, u0, dt=dt, rtol=rtol, integrator=integrator_class(name)(**options), times=arguments.times,
        delay=arguments.delay, workers=arguments.workers, journal=arguments.journal, reference=reference,
        progress=progress_of(arguments),
    )  # fmt: skip
