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
        "spin": (0, 0, 1), "density": None, "mass": 2.0, "inertia": (1, 1, 1), "centre": (0, 0, 0.1),
        "material": ns.Material(),
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
    "pair": {"a": "rubber", "b": "steel", "mu": 0.3, "e": 0.1, "rolling": 0.01, "spinning": 0.01, "adhesion": 1.0},
    "joint": {"a": "hook", "b": "rod", "at": (0, 0, 1), "friction": ns.PinFriction(0.1, 0.01), "name": "pin"},
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
        ("body", {"centre": (0, 0)}, r"centre of crate must have 3 entries; got 2"),
        ("body", {"inertia": None}, r"crate has centre= without inertia=, which is about it; give both"),
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
        ("body", {"mass": 1e300}, r"mass of crate must lie within 1e-45 and 1e\+45 kg; got 1e\+300"),
        ("body", {"mass": 1e-300}, r"mass of crate must lie within .* got 1e-300"),
        ("body", {"position": (0, 1e200, 0)}, r"position of crate must not be larger than 1e\+25 in SI units"),
        ("body", {"velocity": (0, 0, -1e200)}, r"velocity of crate must not be larger .* its largest entry is 1e\+200"),
        ("body", {"spin": (1e300, 0, 0)}, r"spin of crate must not be larger than 1e\+25 rad/s"),
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
        ("pair", {"mu": 1e160}, r"mu must be at most 1e\+12; got 1e\+160"),
        (
            "pair",
            {"mu": None, "e": None, "rolling": None, "spinning": None, "adhesion": None},
            r"the pair rubber, steel needs mu=, e=, rolling=, spinning= or adhesion=; got none",
        ),
        ("pair", {"rolling": -1.0}, r"rolling must not be negative; got -1"),
        ("pair", {"adhesion": math.nan}, r"adhesion must be finite; got nan"),
        ("pair", {"spinning": float("inf")}, r"spinning"),
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
def test_scene_with_a_joint_in_space_is_no_system(ask):
    scene = ns.Scene(gravity=(0, 0, -9.81))
    scene.fixed(ns.Sphere(0.1), name="hook")
    scene.body(ns.Capsule(0.1, 1.0), density=1000, position=(0, 0, -0.5), name="rod")
    scene.joint("hook", "rod", at=(0, 0, 0), name="pin")
    with pytest.raises(ns.InvalidInput, match="pin is a joint in space, which no system of a scene holds"):
        ask(scene)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"q0": [1.0]}, "a scene takes no q0="),
        ({"selection": "lift-of"}, "no selection rule 'lift-of'; did you mean 'lift-off'"),
        ({"checkpoint": 3}, "checkpoint must be the path of a file; got 3"),
        ({"checkpoint": "a", "resume": "b"}, "checkpoint and resume must be the same path"),
        (
            {"record": "body"},
            "record must be some of 'bodies', 'contacts', 'ledger', 'events', 'pairs', 'motion'; got 'body'",
        ),
        ({"record": 3}, "record must be some of"),
        ({"record": ["bodies", 1]}, "record must be some of"),
        ({"integrator": ns.MoreauJean(dt=1e-3, projection=True)}, "leave out projection= of MoreauJean"),
        ({"integrator": ns.MoreauJean(dt=1e-3, specialise=True)}, "leave out specialise= of MoreauJean"),
        ({"integrator": 3}, "integrator must be an integrator, as ns.MoreauJean"),
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


def test_coefficients_of_a_pair_are_given_one_after_the_other_and_its_materials_have_names_of_their_own():
    rubber, steel, other = ns.Material(mu=0.8, name="rubber"), ns.Material(name="steel"), ns.Material(1.0, name="steel")
    scene = ns.Scene(gravity=(0, -9.81))
    scene.fixed(ns.HalfPlane((0, 1)), material=steel, name="ground")
    scene.body(ns.Box(0.2, 0.2), mass=1.0, position=(0, 0.1), velocity=(1, 0), material=rubber, name="box")
    scene.pair("rubber", "steel", mu=0.25)
    scene.pair("steel", "rubber", e=0.0)  # which leaves mu as it was given
    box = ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=1e-3))["box"]
    assert box.velocity[-1, 0] == pytest.approx(1.0 - 0.25 * 9.81 * 0.1, rel=1e-12)
    scene.fixed(ns.Disc(0.1), position=(3, 3), material=other)
    with pytest.raises(ns.InvalidInput, match="scene.pair names a material 'steel', and bodies are made of two, "):
        ns.simulate(scene, (0, 0.1), integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.parametrize(
    "shape",
    [
        lambda: ns.Disc(1e300), lambda: ns.Sphere(1e-300), lambda: ns.Box(1, 1e30), lambda: ns.Capsule(1e-30, 1.0),
        lambda: ns.Cylinder(1.0, 1e26), lambda: ns.Ellipsoid(1.0, 1e-26, 1.0), lambda: ns.Segment((0, 0), (1e200, 0)),
        lambda: ns.Polygon([(0, 0), (1e200, 0), (0, 1e200)]), lambda: ns.HalfSpace((0, 0, 1), 1e200),
        lambda: ns.Polyhedron(1e90 * np.eye(4)[:, :3]), lambda: ns.Compound((ns.Disc(1.0), (1e99, 0))),
        lambda: ns.Polygon([(0, 0), (1, 0), (0, 1)], radius=1e99), lambda: ns.Scene(gravity=(0, -1e99)),
        lambda: ns.Material(mu=1e160),
    ],
)  # fmt: skip
def test_what_no_product_of_a_step_holds_is_refused_when_it_is_made(shape):
    """Such bodies once fell through the ground with a residual of 0."""
    with pytest.raises(ns.InvalidInput, match=r"must (lie within|not be larger than|be at most) .*1e\+"):
        shape()


def test_normals_of_any_length_are_directions():
    for length in (1e-300, 1e-160, 1.0, 1e160, 1e300):
        assert ns.HalfPlane((3 * length, 4 * length)).normal == pytest.approx([0.6, 0.8], rel=1e-15)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.filterwarnings("ignore::nonsmooth.errors.SimultaneousImpactWarning")
@pytest.mark.parametrize("length, mass, time", [(2.0**80, 2.0**146, 2.0**39), (2.0**-76, 2.0**-140, 2.0**-39)])
def test_at_the_ends_of_what_is_taken_motions_have_the_bits_of_those_of_a_metre_and_a_kilogram(dim, length, mass, time):
    def thrown(of_length, of_mass, of_time):
        speed = of_length / of_time
        scene = ns.Scene(gravity=-9.81 * speed / of_time * np.eye(dim)[-1], material=ns.Material(mu=0.4, e=0.3))
        scene.fixed((ns.HalfPlane if dim == 2 else ns.HalfSpace)(np.eye(dim)[-1]))
        for k in range(4):
            shape = ns.Box(*[0.2 * of_length] * dim) if k % 2 else ns.Capsule(0.1 * of_length, 0.08 * of_length)
            place = of_length * (0.2 + 0.32 * k) * np.eye(dim)[-1]
            turn = 0.3 * k if dim == 2 else (math.cos(0.3 * k), 0, math.sin(0.3 * k), 0)
            velocity = speed * (1 - k) * np.eye(dim)[0]
            scene.body(shape, mass=(1 + k) * of_mass, position=place, turn=turn, velocity=velocity)
        integrator = ns.MoreauJean(dt=2e-3 * of_time)
        return ns.simulate(scene, (0, 0.3 * of_time), integrator=integrator, every=10)

    one, other = thrown(1.0, 1.0, 1.0), thrown(length, mass, time)
    np.testing.assert_array_equal(one.position * length, other.position)
    np.testing.assert_array_equal(one.velocity * (length / time), other.velocity)
    assert np.abs(one.position[-1] - one.position[0]).max() > 0.1


def test_masses_and_moments_that_come_of_a_density_are_looked_at_too():
    for density, of in ((1e-60, "mass"), (1e60, "mass")):
        scene = ns.Scene()
        scene.body(ns.Disc(1.0), density=density, name="cloud")
        with pytest.raises(ns.InvalidInput, match=f"{of} of cloud must lie within"):
            ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    scene = ns.Scene()
    scene.body(ns.Disc(1.0), mass=1.0, inertia=1e-300, name="point")
    with pytest.raises(ns.InvalidInput, match="moment of inertia of point must lie within 1e-95"):
        ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))


@pytest.mark.parametrize("project", [False, True])
def test_a_body_too_far_out_for_the_digits_of_its_place_is_refused_by_name(project):
    scene = ns.Scene()
    scene.body(ns.Disc(0.1), mass=1.0, name="near")
    scene.body(ns.Disc(0.1), mass=1.0, position=(1e16, 0), name="far")
    with pytest.raises(ns.InvalidInput, match="^far is nowhere at the start: .*; put the origin nearer$"):
        ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3), project=project)


@pytest.mark.parametrize(
    "shape, message",
    [
        (ns.Compound((ns.Capsule(1.0, 0.1), (0, 0, 0))), "beam has a shape of the space, Compound"),
        (
            ns.Compound((ns.Disc(0.1), (0, 0)), (ns.Segment((0, 0), (1, 0)), (0, 0))),
            "beam has no mass, its shape",
        ),
    ],
)
def test_compounds_that_lie_elsewhere_or_weigh_nothing_are_refused(shape, message):
    with pytest.raises(ns.InvalidInput, match=message):
        ns.Scene(gravity=(0, -9.81)).body(shape, mass=1.0, name="beam")
    with pytest.raises(ns.InvalidInput, match="the parts of a Compound must all be planar, or all spatial"):
        ns.Compound((ns.Capsule(1.0, 0.1), (0, 0)), (ns.Capsule(1.0, 0.1), (0, 0, 0)))


@pytest.mark.parametrize(
    "motion, said",
    [
        (lambda t: (((0, 0), 0), 0), "must be an array of numbers"),
        (lambda t: (0, nan), r"must be finite"),
        (lambda t: (0, 1e99), r"must not be larger than"),
        (lambda t: 1 / 0, "raised ZeroDivisionError"),
    ],
)
def test_a_motion_that_says_no_place_is_refused_at_the_start_and_later_ends_the_run_with_its_past(motion, said):
    for begins in (0.0, 0.005):
        scene = ns.Scene(gravity=(0, -9.81))
        scene.kinematic(ns.Disc(0.1), motion=lambda t, begins=begins: motion(t) if t >= begins else (0, t), name="hand")
        scene.body(ns.Disc(0.1), mass=1.0, position=(0, 1))
        kind = ns.InvalidInput if begins == 0.0 else ns.ModelFunctionError
        with pytest.raises(kind, match=f"^motion of hand.*{said}") as refusal:
            ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
        if begins:
            assert "stopped at t = 0.004 s" in str(refusal.value) and len(refusal.value.solution.t) == 5


def test_a_place_that_is_written_into_and_no_number_is_refused_at_the_start():
    scene = hung()
    scene["rod"].position[0] = nan
    with pytest.raises(ns.InvalidInput, match="^rod is nowhere at the start"):
        ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))


def test_a_run_is_drawn_as_it_was_when_its_scene_has_grown(tmp_path):
    scene = hung()
    solution = ns.simulate(scene, (0, 0.01), integrator=ns.MoreauJean(dt=1e-3))
    scene.body(ns.Disc(0.1), mass=1.0, position=(3, 3), name="later")
    scene.hinge("rod", "later", at=(2, 3), limits=(-1, 1))
    scene.hinge("hook", "rod", at=(2, 3), name="second")
    solution.picture(tmp_path / "run.png")
    solution.plot(tmp_path / "plot.png")
    solution.view(tmp_path / "run.html")
    assert [body.name for body in solution.bodies] == ["hook", "rod"] and "later" not in (
        tmp_path / "run.html"
    ).read_text()
