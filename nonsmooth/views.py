"""Who draws, saves and words a result, and makes a system of a scene: one table, from the name of a class to functions.

A result says ``view(self, "plot")(self, path)``, and the module is imported then: it need not know who draws it, and
Matplotlib or h5py are loaded for those who use them. The first argument of each function is the result; ``load`` is
given a path.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

VIEWS: dict[str, dict[str, str]] = {
    "Worded": {"repr": "results.wording.as_text", "html": "results.wording.as_html"},
    "Solution": {
        "plot": "drawing.plots.plot_solution", "picture": "drawing.scene.picture", "animate": "drawing.scene.animate",
        "film": "drawing.player.solution_film.film_of_solution", "view": "drawing.player.page.show",
        "dataset": "results.labelled.system_dataset", "table": "results.labelled.system_table",
        "netcdf": "results.labelled.write_netcdf", "save": "results.store.save", "load": "results.store.load",
        "name model": "catalogue.named.name_model", "find model": "catalogue.named.find_model",
        "summary": "results.summary.summary", "html": "results.summary.as_html",
    },
    "SceneSolution": {
        "plot": "drawing.scene_histories.plot_scene", "picture": "drawing.scene_figures.picture",
        "animate": "drawing.scene_figures.animate",
        "film": "drawing.player.scene_film.film_of_scene", "view": "drawing.player.page.show",
        "joint": "results.joint_motion.motion_of_joint",
        "spring": "results.spring_forces.forces_of_spring",
        "dataset": "results.labelled.scene_dataset", "table": "results.labelled.scene_table",
        "netcdf": "results.labelled.write_netcdf",
        "save": "results.store.save", "load": "results.store.load_scene",
        "summary": "results.summary.scene_summary", "html": "results.summary.as_html",
    },
    "Ongoing": {"live": "drawing.live.view.live_model"}, "SceneRun": {"live": "drawing.live.view.live_scene"},
    "Scene": {
        "system": "scenes.as_system.system_of", "state": "scenes.as_system.state_of",
        "save": "scenes.scene_files.save_scene", "load": "scenes.scene_files.load_scene",
    },
    "FailedProblem": {"exchange": "results.fclib_form.write_fclib_form"},
    "Classification": {
        "plot": "drawing.classification_plots.plot_classification", "text": "paradox.text.as_text",
        "dictionary": "paradox.text.as_dictionary", "html": "results.wording.as_lines",
    },
    "SpatialClassification": {
        "plot": "drawing.classification_plots.plot_spatial_classification", "text": "paradox.text.spatial_text",
        "dictionary": "paradox.text.spatial_dictionary", "html": "results.wording.as_lines",
    },
    "AveragedMotion": {"plot": "drawing.stability_plots.plot_averaged_motion"},
    "EigenPath": {"plot": "drawing.stability_plots.plot_eigen_path"},
    "stability map": {"plot": "drawing.stability_plots.plot_stability_map"},
    "LimitCycle": {"plot": "drawing.cycle_plots.plot_cycle"},
    "CycleBranch": {"plot": "drawing.cycle_plots.plot_branch"},
    "BifurcationDiagram": {"plot": "drawing.cycle_plots.plot_bifurcations"},
    "Study": {"plot": "drawing.study_plots.plot_study", "html": "results.wording.as_lines"},
    "WorkPrecision": {"plot": "drawing.work_precision_plots.plot_work_precision"},
}  # fmt: skip


class Worded:
    """A result that says what it holds in a few lines, and in a notebook as a table."""

    __slots__ = ()

    def __repr__(self) -> str:
        return view(Worded, "repr")(self)

    def _repr_html_(self) -> str:
        return view(Worded, "html")(self)


def view(result: Any, act: str) -> Callable[..., Any]:
    """The function that does ``act`` to a result, to those of a class, or to what has a name here but no class of ours.

    A derived class is seen as its base is.
    """
    kind = result if isinstance(result, type) else type(result)
    names = [result] if isinstance(result, str) else [base.__name__ for base in kind.__mro__]
    path = next(VIEWS[name][act] for name in names if act in VIEWS.get(name, ()))
    module, _, name = path.rpartition(".")
    return getattr(importlib.import_module(f"nonsmooth.{module}"), name)
