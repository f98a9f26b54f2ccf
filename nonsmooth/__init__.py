"""Nonsmooth mechanics: rigid contact with friction and impact, Painlevé paradoxes, and their compliant limits.

Public names are loaded when they are first used.
"""

import importlib

__version__ = "0.1.0"

_HOME = {
    "System": "system",
    "Contact": "system",
    "ContactMode": "system",
    "Coulomb": "laws",
    "StaticKinetic": "laws",
    "Polynomial": "laws",
    "Stribeck": "laws",
    "Smoothed": "laws",
    "simulate": "simulation",
    "Solution": "solution",
    "Stats": "solution",
    "Event": "solution",
    "StateAt": "motion",
    "Motion": "motion",
    "ParadoxEvent": "solution",
    "EventKind": "solution",
    "MoreauJean": "integrators.moreau_jean",
    "Adaptive": "integrators.adaptive",
    "EventDriven": "integrators.event_driven",
    "Auto": "runs.choice",
    "classify": "paradox.classify",
    "Classification": "paradox.classify",
    "ParadoxKind": "paradox.classify",
    "ParadoxFlag": "paradox.classify",
    "ImpactLaw": "laws",
    "paradox_map": "studies.paradox_map",
    "paradox_boundaries": "paradox.boundaries",
    "plot_map": "output.paradox_plots",
    "plot_graphical_problem": "output.paradox_plots",
    "critical_friction": "paradox.friction",
    "least_critical_friction": "paradox.friction",
    "Compliance": "integrators.compliance",
    "Penalty": "integrators.penalty",
    "Regularised": "integrators.compliant_law",
    "penalty_study": "studies.penalty_study",
    "convergence_study": "studies.convergence_study",
    "work_precision": "studies.work_precision",
    "Scene": "studies.work_precision",
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
    "solve_contact": "contact_solvers.solve",
    "ContactResult": "contact_solvers.result",
    "ContactStatus": "contact_solvers.result",
    "ContactProblem": "output.fclib",
    "GlobalContactProblem": "output.fclib",
    "read_fclib": "output.fclib",
    "write_fclib": "output.fclib",
    "sweep": "studies.sweep",
    "RunTask": "studies.run_task",
    "MapTask": "studies.map_task",
    "Axis": "studies.axes",
    "CellStatus": "studies.task",
    "LocalPool": "studies.pool",
    "load_sweep": "studies.sweep_files",
    "save_sweep": "studies.sweep_files",
    "plot_sweep": "studies.sweep_plot",
    "CellFailure": "errors",
    "CheckpointFailure": "errors",
    "equilibrium": "stability.equilibrium",
    "Equilibrium": "stability.equilibrium",
    "linearise": "stability.linearise",
    "Linearisation": "stability.linearise",
    "Verdict": "stability.linearise",
    "eigen_path": "stability.eigen_path",
    "EigenPath": "stability.eigen_path",
    "eigenvalue_sensitivity": "stability.sensitivity",
    "flutter_boundary": "stability.flutter_boundary",
    "StabilityBoundary": "stability.flutter_boundary",
    "stability_map": "stability.stability_map",
    "averaged_amplitude": "stability.averaging",
    "AveragedMotion": "stability.averaging",
    "limit_cycle": "stability.limit_cycle",
    "LimitCycle": "stability.cycle",
    "continue_cycle": "stability.cycle_branch",
    "CycleBranch": "stability.cycle_branch",
    "bifurcation_diagram": "studies.bifurcation_diagram",
    "BifurcationDiagram": "studies.bifurcation_diagram",
    "NonsmoothError": "errors",
    "InvalidInput": "errors",
    "UnknownName": "errors",
    "MissingExtra": "errors",
    "UnsupportedVersion": "errors",
    "StepFailure": "errors",
    "ModelFunctionError": "errors",
    "FileFailure": "errors",
    "BudgetSpent": "errors",
    "EventFunctionError": "errors",
    "ProgressError": "errors",
    "NonsmoothWarning": "errors",
    "InterpretedWarning": "errors",
    "InitialStateWarning": "errors",
    "EnergyGainWarning": "errors",
    "UnsettledWarning": "errors",
    "Status": "errors",
}

__all__ = ["__version__", *_HOME]


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(f"module 'nonsmooth' has no attribute {name!r}")
    value = getattr(importlib.import_module(f"nonsmooth.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted(__all__)
