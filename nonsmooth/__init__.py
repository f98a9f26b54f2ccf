"""Nonsmooth mechanics: rigid contact with friction and impact, Painlevé paradoxes, and their compliant limits.

Public names are loaded when they are first used.
"""

import importlib

__version__ = "0.1.0"

_HOME = {
    "System": "mechanics.system",
    "Contact": "mechanics.system",
    "ContactMode": "mechanics.system",
    "Coulomb": "mechanics.laws",
    "StaticKinetic": "mechanics.laws",
    "Polynomial": "mechanics.laws",
    "Stribeck": "mechanics.laws",
    "Smoothed": "mechanics.laws",
    "Scene": "scenes.scene",
    "Body": "scenes.scene",
    "Material": "scenes.materials",
    "Disc": "scenes.shapes",
    "Sphere": "scenes.shapes",
    "Box": "scenes.shapes",
    "Capsule": "scenes.shapes",
    "Polygon": "scenes.shapes",
    "Segment": "scenes.shapes",
    "HalfPlane": "scenes.shapes",
    "HalfSpace": "scenes.shapes",
    "Compound": "scenes.shapes",
    "SceneSolution": "results.scene_solution",
    "SceneStats": "results.scene_solution",
    "SceneContacts": "results.scene_solution",
    "BodyMotion": "results.scene_solution",
    "ContactSolver": "integrators.moreau_jean.contact_solver",
    "lagrangian": "symbolic.lagrangian",
    "lagrangian_of": "symbolic.lagrangian",
    "simulate": "runs.simulate",
    "Solution": "results.solution",
    "Stats": "results.solution",
    "Event": "results.solution",
    "StateAt": "results.motion",
    "Motion": "results.motion",
    "ParadoxEvent": "results.solution",
    "EventKind": "results.solution",
    "MoreauJean": "integrators.moreau_jean.options",
    "Adaptive": "integrators.adaptive.options",
    "EventDriven": "integrators.event_driven.options",
    "Auto": "runs.choice",
    "classify": "paradox.classify",
    "Classification": "paradox.classify",
    "ParadoxKind": "paradox.classify",
    "ParadoxFlag": "paradox.classify",
    "ImpactLaw": "mechanics.laws",
    "paradox_map": "studies.paradox_map",
    "paradox_boundaries": "paradox.boundaries",
    "plot_map": "drawing.paradox_plots",
    "plot_graphical_problem": "drawing.paradox_plots",
    "critical_friction": "paradox.friction",
    "least_critical_friction": "paradox.friction",
    "Compliance": "integrators.moreau_jean.compliance",
    "Penalty": "integrators.penalty.options",
    "Regularised": "integrators.penalty.law",
    "penalty_study": "studies.penalty_study",
    "convergence_study": "studies.convergence_study",
    "work_precision": "studies.work_precision",
    "TimedMotion": "studies.work_precision",
    "OwnMethod": "studies.work_precision",
    "WorkPrecision": "studies.work_precision_result",
    "force_episode": "studies.force_history",
    "Episode": "studies.force_history",
    "Study": "studies.study",
    "solve_lcp": "lcp.solve",
    "solve_mlcp": "lcp.mixed",
    "is_p_matrix": "lcp.p_matrix",
    "lcp_solutions": "lcp.enumerate",
    "LCPResult": "lcp.result",
    "LCPStatus": "lcp.result",
    "solve_contact": "contact.blocks.solve",
    "ContactResult": "contact.blocks.result",
    "ContactStatus": "contact.blocks.result",
    "ContactProblem": "results.fclib",
    "GlobalContactProblem": "results.fclib",
    "read_fclib": "results.fclib",
    "write_fclib": "results.fclib",
    "sweep": "sweeps.sweep",
    "RunTask": "sweeps.run_task",
    "MapTask": "sweeps.map_task",
    "Axis": "sweeps.axes",
    "CellStatus": "sweeps.task",
    "LocalPool": "sweeps.pool",
    "load_sweep": "sweeps.sweep_files",
    "save_sweep": "sweeps.sweep_files",
    "plot_sweep": "drawing.sweep_plot",
    "CellFailure": "errors",
    "CheckpointFailure": "errors",
    "equilibrium": "equilibria.equilibrium",
    "Equilibrium": "equilibria.equilibrium",
    "linearise": "equilibria.linearise",
    "Linearisation": "equilibria.linearise",
    "Verdict": "equilibria.linearise",
    "eigen_path": "equilibria.eigen_path",
    "EigenPath": "equilibria.eigen_path",
    "eigenvalue_sensitivity": "equilibria.sensitivity",
    "flutter_boundary": "equilibria.flutter_boundary",
    "StabilityBoundary": "equilibria.flutter_boundary",
    "stability_map": "equilibria.stability_map",
    "averaged_amplitude": "equilibria.averaging",
    "AveragedMotion": "equilibria.averaging",
    "limit_cycle": "cycles.limit_cycle",
    "LimitCycle": "cycles.cycle",
    "continue_cycle": "cycles.cycle_branch",
    "CycleBranch": "cycles.cycle_branch",
    "bifurcation_diagram": "studies.bifurcation_diagram",
    "BifurcationDiagram": "studies.bifurcation_diagram",
    "NonsmoothError": "errors",
    "InvalidInput": "errors",
    "UnknownName": "errors",
    "MissingExtra": "errors",
    "UnsupportedVersion": "errors",
    "StepFailure": "results.failures",
    "ModelFunctionError": "results.failures",
    "FileFailure": "errors",
    "BudgetSpent": "results.failures",
    "EventFunctionError": "results.failures",
    "ProgressError": "results.failures",
    "NonsmoothWarning": "errors",
    "InterpretedWarning": "errors",
    "InitialStateWarning": "errors",
    "EnergyGainWarning": "errors",
    "PenetrationWarning": "errors",
    "ResidualWarning": "errors",
    "UnsettledWarning": "errors",
    "Status": "errors",
}

_RENAMED: dict[str, str] = {}  # for one release

__all__ = ["__version__", *_HOME]


def __getattr__(name):
    if name in _RENAMED:
        new = _RENAMED[name]
        raise AttributeError(f"nonsmooth.{name} is called nonsmooth.{new} now: write ns.{new}(...)", name=name)
    if name not in _HOME:
        raise AttributeError(f"module 'nonsmooth' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"nonsmooth.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(__all__)
