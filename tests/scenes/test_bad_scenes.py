"""Bad input to the methods of a scene: refused in one sentence with the name of the body."""

import inspect
import math

import numpy as np
import pytest

import nonsmooth as ns

nan = math.nan
SPATIAL = {
    "body": {
        "shape": ns.Box(0.2, 0.2, 0.2), "position": (0, 0, 1), "turn": (1, 0, 0, 0), "velocity": (0, 0, 0),
        "spin": (0, 0, 1), "density": None, "mass": 2.0, "inertia": (1, 1, 1), "material": ns.Material(),
        "surface_velocity": (0, 0, 0),
        "name": "crate",
    },
    "fixed": {
        "shape": ns.HalfSpace((0, 0, 1)), "position": (0, 0, 0), "turn": (1, 0, 0, 0), "material": ns.Material(),
        "surface_velocity": (1, 0, 0), "name": "crate",
    },
    "kinematic": {
        "shape": ns.HalfSpace((0, 0, 1)), "position": (0, 0, 0), "turn": (1, 0, 0, 0), "velocity": (0, 0, 0),
        "spin": (0, 0, 1), "motion": None, "material": ns.Material(), "surface_velocity": (1, 0, 0), "name": "crate",
    },
    "pair": {"a": "rubber", "b": "steel", "mu": 0.3, "e": 0.1},
    "joint": {"a": "hook", "b": "rod", "at": (0, 0, 1), "name": "pin"},
}  # fmt: skip


NOT_GIVEN = dict.fromkeys(("position", "turn", "velocity", "spin"))


def call(method, **changes):
    scene = ns.Scene(gravity=(0, 0, -9.81))
    if method == "joint":
        for name in ("hook", "wall"):
            scene.fixed(ns.Sphere(0.1), position=(0, 0, 1), name=name)
        scene.body(ns.Box(0.1, 0.1, 1.0), mass=1.0, position=(0, 0, 0.5), name="rod")
    return getattr(scene, method)(**SPATIAL[method] | changes)


@pytest.mark.parametrize("method", SPATIAL)
def test_the_table_has_every_argument(method):
    call(method)
    assert list(SPATIAL[method]) == list(inspect.signature(getattr(ns.Scene, method)).parameters)[1:]


@pytest.mark.parametrize(
    "method, changes, message",
    [
        ("body", {"shape": 3}, r"shape of crate must be a shape"),
        ("body", {"shape": ns.Disc(0.1)}, r"crate has a shape of the plane, Disc.*the scene is one of the space"),
        ("body", {"shape": ns.HalfSpace((0, 0, 1))}, r"crate has no mass.*scene.fixed or scene.kinematic"),
        ("body", {"mass": None}, r"crate needs either density= or mass=; got neither"),
        ("body", {"density": 1.0}, r"crate needs either density= or mass=; got both"),
        ("body", {"mass": 0}, r"mass of crate must be positive \[kg\]; got 0"),
        ("body", {"mass": None, "density": -1.0}, r"density of crate must be positive \[kg/m\^3\]; got -1"),
        ("body", {"inertia": (1, 1, 3)}, r"inertia of crate is that of no body"),
        ("body", {"inertia": (1, 0, 1)}, r"inertia of crate must be positive definite; its smallest moment is 0"),
        ("body", {"inertia": (1, 1)}, r"inertia of crate must"),
        ("body", {"position": (0, 0)}, r"position of crate must have 3 entries; got 2"),
        ("body", {"position": (0, 0, nan)}, r"position of crate must be finite"),
        (
            "body",
            {"turn": (1, 1, 0, 0)},
            r"turn of crate must be a unit quaternion.*its length is 1.41421",
        ),
        ("body", {"turn": 0.5}, r"turn of crate must"),
        ("body", {"velocity": 1.0}, r"velocity of crate must"),
        ("body", {"spin": 1.0}, r"spin of crate must"),
        ("body", {"material": 0.5}, r"material of crate must be a Material\(mu=..., e=...\); got 0.5"),
        ("body", {"surface_velocity": (1, 0)}, r"surface_velocity of crate must have 3 entries; got 2"),
        ("body", {"name": 3}, r"the name of a body must be a text; got 3"),
        ("fixed", {"turn": (0, 0, 0, 0)}, r"turn of crate must be a unit quaternion"),
        (
            "kinematic",
            {"motion": 3.0, **NOT_GIVEN},
            r"motion of crate must",
        ),
        ("kinematic", {"motion": lambda t: (0, 0, t)}, r"crate takes either motion= or position=.*got both"),
        ("pair", {"a": ""}, r"a pair is one of materials with names.*got ''"),
        ("pair", {"b": ns.Material()}, r"a pair is one of materials with names"),
        ("pair", {"mu": -1.0}, r"mu must not be negative; got -1"),
        ("pair", {"e": 2.0}, r"e must lie in \[0, 1\]; got 2"),
        ("joint", {"a": "hock"}, r"pin joins 'hock', which is no body of the scene; did you mean 'hook'"),
        ("joint", {"b": 3}, r"pin joins 3, which is no body of the scene"),
        ("joint", {"b": ns.Scene().body(ns.Disc(0.1), mass=1.0)}, r"pin joins body 0, a body of another scene"),
        ("joint", {"a": "rod"}, r"pin joins rod to itself; a joint is one of two bodies"),
        ("joint", {"b": "wall"}, r"pin joins hook and wall, and no impulse moves either; .* as scene.body makes it"),
        ("joint", {"at": (0, 1)}, r"at of pin must have 3 entries; got 2"),
        ("joint", {"at": (0, nan, 1)}, r"at of pin must be finite"),
        ("joint", {"name": 3}, r"the name of a joint must be a text; got 3"),
    ],
)
def test_bad_input_is_named(method, changes, message):
    with pytest.raises(ns.InvalidInput, match=message):
        call(method, **changes)


NOWHERE = {
    "an object": object(), "complex": 1 + 2j, "a matrix of nan": np.full((2, 2, 2), nan), "a huge int": 10**400,
    "rows of different lengths": [[1], [1, 2]], "bytes": b"\0", "a set": {1.5}, "nan": nan,
    "an array of objects": np.array([None, {}]), "a date": np.datetime64("2020-01-01"), "a dict": {1: 2},
}  # fmt: skip


@pytest.mark.parametrize("method", SPATIAL)
def test_what_fits_nowhere_is_refused_in_one_sentence_by_every_argument(method):
    for argument in SPATIAL[method]:
        for label, value in NOWHERE.items():
            with pytest.raises(ns.InvalidInput) as refusal:
                call(method, **{argument: value})
            assert "\n" not in str(refusal.value) and len(str(refusal.value)) > 15, (method, argument, label)


def test_two_bodies_of_one_name_are_refused_and_a_name_that_is_not_there_suggests_the_nearest():
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    with pytest.raises(ns.InvalidInput, match="there is a body 'ground' already; names of bodies must differ"):
        scene.fixed(ns.HalfSpace((0, 0, 1)), name="ground")
    with pytest.raises(ns.InvalidInput, match="there is no body 'grund'; did you mean 'ground'"):
        _ = scene["grund"]


def test_two_joints_of_one_name_are_refused_and_a_name_that_is_not_there_suggests_the_nearest():
    scene = hung()
    with pytest.raises(ns.InvalidInput, match="there is a joint 'pin' already; names of joints must differ"):
        scene.joint("hook", "rod", at=(0, 0), name="pin")
    solution = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    with pytest.raises(ns.InvalidInput, match="there is no joint 'pim'; did you mean 'pin'"):
        solution.joint("pim")
    motion = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3), record="motion")
    with pytest.raises(ns.InvalidInput, match="joint_impulses was not recorded"):
        motion.joint("pin")


def hung():
    scene = ns.Scene()
    scene.fixed(ns.Disc(0.01), name="hook")
    scene.body(ns.Box(0.02, 1.0), mass=1.0, position=(0, -0.5), name="rod")
    scene.joint("hook", "rod", at=(0, 0), name="pin")
    return scene


@pytest.mark.parametrize(
    "options, message",
    [
        (
            {"integrator": ns.Penalty(1e5)},
            r"Penalty does not hold joints, and the scene has pin; take MoreauJean\(dt\)",
        ),
        (
            {"integrator": ns.MoreauJean(dt=1e-3, theta=1.0, compliance=ns.Compliance(1e5))},
            r"MoreauJean with compliance= does not hold joints, and the scene has pin; take MoreauJean\(dt\), rigid",
        ),
        ({"project": True}, r"project=True moves bodies apart that no joint holds, and the scene has pin; move them"),
    ],
)
def test_what_knows_no_joints_says_so(options, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(hung(), (0, 0.01), **{"integrator": ns.MoreauJean(dt=1e-3)} | options)


@pytest.mark.parametrize("ask", [lambda scene: scene.system(), lambda scene: scene.state()])
def test_scene_with_a_joint_is_no_system(ask):
    with pytest.raises(ns.InvalidInput, match=r"pin is a joint, which a system of a scene does not hold; simulate\("):
        ask(hung())


@pytest.mark.parametrize(
    "options, message",
    [
        ({"q0": [1.0]}, "a scene takes no q0="),
        ({"selection": "lift-off"}, "a scene takes no selection="),
        ({"checkpoint": 3}, "checkpoint must be the path of a file; got 3"),
        ({"checkpoint": "a", "resume": "b"}, "checkpoint and resume must be the same path"),
        ({"record": "body"}, "record must be some of 'bodies', 'contacts', 'ledger', 'events', 'motion'; got 'body'"),
        ({"record": 3}, "record must be some of"),
        ({"record": ["bodies", 1]}, "record must be some of"),
        ({"integrator": ns.EventDriven()}, r"a scene is integrated by MoreauJean\(dt=...\); got EventDriven"),
        ({"integrator": ns.MoreauJean(dt=1e-3, projection=True)}, "leave out projection= of MoreauJean"),
        ({"integrator": 3}, "a scene is integrated by MoreauJean|integrator must be"),
    ],
)
def test_simulate_refuses_what_means_nothing_for_a_scene(options, message):
    scene = ns.Scene()
    scene.body(ns.Disc(0.1), mass=1.0)
    with pytest.raises(ns.InvalidInput, match=message):
        ns.simulate(scene, (0, 0.01), **{"integrator": ns.MoreauJean(dt=1e-3)} | options)


def test_pair_of_a_material_that_no_body_is_made_of_is_refused():
    scene = ns.Scene()
    scene.body(ns.Disc(0.1), mass=1.0)
    scene.pair("rubber", "steel", mu=0.2)
    with pytest.raises(ns.InvalidInput, match="scene.pair names a material 'rubber' that no body is made of"):
        ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
