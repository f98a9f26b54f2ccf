"""Records that steps write by themselves are those that Python writes, to the last bit."""

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.integrators.assembly import written
from nonsmooth.runs import recorder
from nonsmooth.runs.scene_run import SceneRun

CONTACTS = ("i", "j", "mu", "gap", "normal", "point", "P")


def boxes_that_fall_asleep(dim):
    """One lands turned, so that steps are divided, one slides and comes to rest, one hangs on a hinge."""
    fill = (0,) * (dim - 2)
    scene = ns.Scene(gravity=(0, *fill, -9.81), material=ns.Material(mu=0.5), dt=2e-3)
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    box = ns.Box(0.4, 0.2) if dim == 2 else ns.Box(0.4, 0.3, 0.2)
    turn = 0.3 if dim == 2 else (np.cos(0.15), 0.0, np.sin(0.15), 0.0)
    scene.body(box, density=1000, position=(0, *fill, 0.5), turn=turn, name="lands")
    scene.body(box, density=1000, position=(2, *fill, 0.1), velocity=(0.5, *fill, 0), name="slides")
    scene.body(box, density=1000, position=(-2, *fill, 1.0), name="hangs")
    axis = {} if dim == 2 else {"axis": (0, 1, 0)}
    scene.hinge("ground", "hangs", at=(-2.2, *fill, 1.0), **axis)
    return scene


def boxes_alone(dim):
    """All of which sleep in the end."""
    scene = ns.Scene(gravity=(0,) * (dim - 1) + (-9.81,), material=ns.Material(mu=0.5), dt=2e-3)
    scene.fixed(ns.HalfPlane((0, 1)) if dim == 2 else ns.HalfSpace((0, 0, 1)), name="ground")
    box, fill = (ns.Box(0.4, 0.2), ()) if dim == 2 else (ns.Box(0.4, 0.3, 0.2), (0,))
    for k in range(3):
        scene.body(box, density=1000, position=(k, *fill, 0.1), velocity=(0.3 * k, *fill, 0), name=f"box {k}")
    return scene


def wood_on_wood(dim):
    wood = ns.Material(mu=ns.EllipticFriction(along=0.2, across=0.6, direction=(1, 0, 0)))
    scene = ns.Scene(gravity=(0, 0, -9.81), dt=2e-3)
    scene.fixed(ns.HalfSpace((0, 0, 1)), material=wood)
    scene.body(ns.Box(0.1, 0.1, 0.01), mass=1.0, position=(0, 0, 0.005), velocity=(0.3, 0.3, 0), name="block")
    return scene


def run(make, dim, monkeypatch, may_write, steps=400, **options):
    monkeypatch.setattr(SceneRun, "may_write", may_write)
    scene = make(dim)
    return ns.simulate(scene, (0, steps * scene.dt), integrator=ns.MoreauJean(scene.dt), progress=False, **options)


def require_same(one, other):
    def is_same(a, b):
        return a.dtype == b.dtype and np.ascontiguousarray(a).tobytes() == np.ascontiguousarray(b).tobytes()

    for name in ("t", "position", "turn", "velocity", "spin", "residual", "penetration"):
        assert is_same(getattr(one, name), getattr(other, name)), name
    for name in ("joint_impulses", "joint_torques"):
        assert is_same(getattr(one, name), getattr(other, name)), name
    assert all(is_same(one.ledger[name], other.ledger[name]) for name in one.ledger)
    for t in one.t:
        here, there = one.contacts(t), other.contacts(t)
        assert all(is_same(getattr(here, name), getattr(there, name)) for name in CONTACTS), t


@pytest.mark.parametrize("options", [{}, {"every": 3}, {"t_eval": [0.0, 0.1001, 0.35, 0.3521, 0.8]}])
@pytest.mark.parametrize(("make", "dim"), [
    (boxes_that_fall_asleep, 2), (boxes_that_fall_asleep, 3), (boxes_alone, 2), (boxes_alone, 3), (wood_on_wood, 3),
])  # fmt: skip
def test_both_ways_write_the_same(make, dim, options, monkeypatch):
    one, other = (run(make, dim, monkeypatch, may_write, **options) for may_write in (True, False))
    require_same(one, other)
    assert one.stats.asleep == other.stats.asleep and one.stats.steps == other.stats.steps
    assert one.stats.asleep > 0 or make is not boxes_alone


@pytest.mark.parametrize(("rows", "window"), [(5, 2**22), (2**13, 2048)])
def test_where_there_is_little_room_python_takes_over(rows, window, monkeypatch):
    """For more contacts than there is room for, and for records as many as the window holds."""
    monkeypatch.setattr(recorder, "CONTACT_ROWS", rows)
    monkeypatch.setattr(recorder, "SCENE_WINDOW", window)
    one, other = (run(boxes_that_fall_asleep, 2, monkeypatch, may_write) for may_write in (True, False))
    require_same(one, other)


def test_a_run_of_many_records_goes_back_to_python_some_times_alone(monkeypatch):
    calls = []
    take = written.take_recorded[2]
    monkeypatch.setattr(take, "compiled", lambda *given, take=take.compiled: calls.append(given) or take(*given))
    sol = run(boxes_alone, 2, monkeypatch, True, steps=2000)
    assert len(sol.t) == 2001 and 0 < len(calls) < 100


def test_what_is_kept_by_a_checkpoint_goes_on_to_the_same_bits(tmp_path, monkeypatch):
    whole = run(boxes_that_fall_asleep, 2, monkeypatch, True)
    with pytest.raises(ns.BudgetSpent):
        run(boxes_that_fall_asleep, 2, monkeypatch, True, checkpoint=tmp_path / "run", max_steps=173)
    require_same(run(boxes_that_fall_asleep, 2, monkeypatch, True, resume=tmp_path / "run"), whole)
