"""The recipes of CONTRIBUTING.md: a selection rule, a friction law and a column of results are added by the two files
that each names."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

EDITS = {
    "Add a selection rule": {
        "contact/planar/selection.py": [
            ("    IMPACT = 2\n", "    IMPACT = 2\n    NEVER_STICK = 3\n"),
            ("    if candidate == FREE:\n", "    if selection == Selection.NEVER_STICK and candidate == STICK:\n"
                                            "        return 2 * SADDLE\n    if candidate == FREE:\n"),
        ],
        "runs/asked.py": [
            ('    "impact": Selection.IMPACT,\n',
             '    "impact": Selection.IMPACT,\n    "never-stick": Selection.NEVER_STICK,\n'),
        ],
    },
    "Add a friction law": {
        "mechanics/laws.py": [
            ("SMOOTHED = 0, 1, 2, 3, 4", "SMOOTHED, FALLING = 0, 1, 2, 3, 4, 5"),
            ("LAST_CODE = max", "@dataclass(frozen=True)\nclass Falling(FrictionLaw):\n"
                                '    """mu(v) = m0 / (1 + v / v_s)."""\n\n'
                                "    m0: Coefficient\n    v_s: Coefficient\n    code = FALLING\n\n\nLAST_CODE = max"),
            ("    c = laws[i, LAW_C + 2]\n", "    if code == FALLING:\n        return a / (1.0 + v / b)\n"
                                          "    c = laws[i, LAW_C + 2]\n"),
        ],
        "__init__.py": [('    "Smoothed": "mechanics.laws",\n',
                         '    "Smoothed": "mechanics.laws",\n    "Falling": "mechanics.laws",\n')],
    },
    "Add a column to the result of a scene": {
        "results/table.py": [
            ('        Column("velocity", REAL, ',
             '        Column("speed", REAL, ("n_t", "n_b"), "m/s", "speeds of the centres of mass", BODIES),\n'
             '        Column("velocity", REAL, '),
            ("    velocity: np.ndarray\n", "    velocity: np.ndarray\n    speed: np.ndarray\n"),
        ],
        "runs/recorder.py": [
            ('"spin": spin}\n',
             '"spin": spin}\n            columns["speed"] = np.linalg.norm(v[:, :, :dim], axis=2)\n'),
        ],
    },
}  # fmt: skip

PROBLEM = """
import numpy as np
import nonsmooth as ns
from nonsmooth.contact.planar.enumerate import select
from nonsmooth.contact.planar.problem import problem_of
from nonsmooth.contact.planar.single import SLIDE_PLUS, STICK, solve_single
from nonsmooth.jit import interpreted
from nonsmooth.mechanics.laws import law_row
from nonsmooth.mechanics.system import UNILATERAL, ContactMode

def problem(law, c):
    made = problem_of(np.array([[UNILATERAL, 1]]), np.eye(2), np.array(c), 0.5, 0.9)
    made.laws[:], made.mode[0] = law_row(law, 0.0, 0.0, "newton", {}), ContactMode.STICK
    return made
"""

CHECKS = {
    # Hysteresis: mu_s = 0.9 holds |P_F| = 0.7, mu_k = 0.5 lets it slide.
    "Add a selection rule": """
from types import SimpleNamespace
from nonsmooth.runs.asked import SELECTIONS

tree = SimpleNamespace(modes=np.array([[STICK], [SLIDE_PLUS]]))
for name, expected in (("compliant-limit", STICK), ("lift-off", STICK), ("never-stick", SLIDE_PLUS)):
    one = problem(ns.StaticKinetic(0.9, 0.5), [-1.0, 0.7])
    one.selection = SELECTIONS[name]
    assert interpreted(solve_single)(0, one)[0] == expected, name
    assert tree.modes[interpreted(select)(2, one, tree), 0] == expected, name
""",
    # It slides at v = 1 in the middle of the step: mu = 0.6 / (1 + 1/2) = 0.4, from 1.2 to 0.8.
    "Add a friction law": """
law = problem(ns.Falling(0.6, 2.0), [-1.0, 1.2])
law.offset[1], law.mode[0], law.slip[0] = 1.2, ContactMode.SLIDE, 1
candidate, P_N, P_F, found = interpreted(solve_single)(0, law)
assert candidate == SLIDE_PLUS and P_N == 1.0 and abs(P_F + 0.4) < 1e-15, (candidate, P_N, P_F)
assert ns.Contact(mu=ns.Falling(0.6, 2.0)).has_friction
""",
    # A ball is thrown; its speed is found wherever a run is kept.
    "Add a column to the result of a scene": """
scene = ns.Scene(gravity=(0, -10.0))
scene.body(ns.Disc(0.1), mass=1.0, position=(0, 0), velocity=(3.0, 4.0), name="ball")
run = dict(integrator=ns.MoreauJean(dt=0.01))
sol = ns.simulate(scene, (0, 0.1), **run)
speed = np.hypot(3.0, 4.0 - 10.0 * sol.t)[:, None]
found = [sol, ns.simulate(scene, (0, 0.1), **run, checkpoint="run.ckpt"), ns.SceneSolution.load("run.ckpt")]
found += [ns.SceneSolution.load(sol.save(f"run.{ending}")) for ending in ("npz", "h5", "nc")]
for each in found:
    assert each.speed.shape == (11, 1) and abs(each.speed - speed).max() < 1e-13
    assert abs(each.to_dataframe().speed - speed[:, 0]).max() < 1e-13
    variable = each.to_xarray().speed
    assert (variable.dims, variable.units) == (("t", "body"), "m/s")
try:
    ns.simulate(scene, (0, 0.1), **run, record="ledger").speed
except ns.InvalidInput as refusal:
    assert "speed was not recorded" in str(refusal) and "keeps the bodies" in str(refusal)
else:
    raise AssertionError("it was not recorded")
""",
}


@pytest.mark.upkeep
@pytest.mark.parametrize("recipe", EDITS)
def test_two_files_are_all_that_a_recipe_touches(recipe, tmp_path):
    section = re.search(rf"^## {recipe}\n(.*?)^## ", (ROOT / "CONTRIBUTING.md").read_text(), re.M | re.S)[1]
    named = re.findall(r"^\d\. `([^`]+)`", section, re.M)
    assert set(named) == EDITS[recipe].keys() and len(named) == 2
    shutil.copytree(ROOT / "nonsmooth", tmp_path / "nonsmooth", ignore=shutil.ignore_patterns("__pycache__"))
    for file, changes in EDITS[recipe].items():
        text = (tmp_path / "nonsmooth" / file).read_text()
        for before, after in changes:
            assert text.count(before) == 1, (file, before)
            text = text.replace(before, after)
        (tmp_path / "nonsmooth" / file).write_text(text)
    for library in ("h5py", "xarray", "netCDF4", "pandas") if "scene" in recipe else ():
        pytest.importorskip(library)
    own_cache = {} if "scene" in recipe else {"NONSMOOTH_CACHE_DIR": str(tmp_path)}  # no kernel differs in that one
    environment = os.environ | {"PYTHONPATH": str(tmp_path)} | own_cache
    done = subprocess.run(
        [sys.executable, "-c", PROBLEM + CHECKS[recipe]], cwd=tmp_path, env=environment, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
