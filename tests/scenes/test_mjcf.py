"""MJCF files as scenes: against MuJoCo itself, closed forms and statics; what is not understood is listed by name."""

import math
import sys

import numpy as np
import pytest

import nonsmooth as ns

mujoco = pytest.importorskip("mujoco")
pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.NotUnderstoodWarning")

ROBOT = """<mujoco model="arm"><option timestep="0.002" gravity="0 0 -9.81"/><worldbody>{}</worldbody>{}</mujoco>"""
TWO_HINGES = """<body name="upper" pos="0 0 2"><joint name="shoulder" type="hinge" axis="0 1 0" damping=".3"/>
    <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/><body name="lower" pos=".4 0 0">
    <joint name="elbow" type="hinge" axis="0 1 0" stiffness="3" springref="20" armature=".02"/>
    <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".03"/></body></body>"""
FALLING = {
    "a double pendulum": TWO_HINGES,
    "a slide with damping": """<body name="cart" pos="0 0 1"><joint name="rail" type="slide" axis="1 0 -1" damping="2"/>
        <geom type="box" size=".1 .1 .1"/></body>""",
    "a ball joint": """<body name="bob" pos="0 0 1"><joint name="ball" type="ball"/>
        <geom type="capsule" fromto="0 0 0 .3 .1 .1" size=".03"/></body>""",
    "three hinges of one body": """<body name="leg" pos="0 0 1">
        <joint name="x" axis="1 0 0" damping=".5" armature=".01"/>
        <joint name="z" axis="0 0 1" stiffness="10"/><joint name="y" axis="0 1 0" damping=".1"/>
        <geom type="box" size=".05 .1 .2" pos=".3 .1 0"/></body>""",
    "two slides and a hinge": """<body name="torso" pos="0 0 1"><joint name="px" type="slide" axis="1 0 0"/>
        <joint name="pz" type="slide" axis="0 0 1"/><joint name="turn" type="hinge" axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 .3 0 .1" size=".03"/><body name="leg" pos=".3 0 .1">
        <joint name="hip" axis="0 1 0" stiffness="5" springref="40"/><geom type="sphere" size=".05" pos="0 0 -.2"/>
        </body></body>""",
    "a free tree, compensated": """<body name="base" pos="0 0 1" gravcomp="1"><freejoint/>
        <geom type="ellipsoid" size=".1 .2 .3"/>
        <body name="held" pos="0 .2 0"><geom type="cylinder" size=".05 .1" euler="40 20 0"/></body>
        <body name="tail" pos=".1 0 .3"><joint name="swings" axis="1 2 0"/>
        <geom type="box" size=".05 .1 .1" pos="0 0 .1"/></body></body>""",
    "a mesh": """<body name="stone" pos="0 0 1"><joint name="pin" axis="0 1 0" pos=".1 0 0"/>
        <geom type="mesh" mesh="wedge"/></body>""",
}  # fmt: skip
ASSETS = """<asset><mesh name="wedge" vertex="0 0 0  .3 0 0  0 .2 0  0 0 .1  .3 .2 0"/></asset>"""


def written(tmp_path, body, more="", name="robot.xml"):
    (tmp_path / name).write_text(ROBOT.format(body, more))
    return tmp_path / name


def by_mujoco(path, t_end, dt=1e-4, ctrl=()):
    """Where the centres of mass of the bodies are, by the Runge-Kutta method of MuJoCo."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, dt
    data = mujoco.MjData(model)
    data.ctrl[:] = ctrl
    for _ in range(round(t_end / dt)):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    own = {}
    for root in range(1, model.nbody):
        held = np.flatnonzero(model.body_weldid == root)
        if len(held):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, root)
            own[name] = np.average(data.xipos[held], axis=0, weights=model.body_mass[held])
    return own


def run(scene, t_end, dt=1e-4, **options):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt), **options)


@pytest.mark.parametrize("name", FALLING)
def test_what_falls_for_a_tenth_of_a_second_is_where_mujoco_has_it(name, tmp_path):
    path = written(tmp_path, FALLING[name], ASSETS)
    places, sol = by_mujoco(path, 0.1), run(ns.Scene.load(path), 0.1)
    for body, place in places.items():
        np.testing.assert_allclose(sol[body].position[-1], place, atol=1e-6, err_msg=body)
    assert max(np.abs(sol[body].position[-1] - sol[body].position[0]).max() for body in places) > 1e-4


ACTUATORS = """<actuator><motor name="torque" joint="shoulder" gear="20" ctrllimited="true" ctrlrange="-1 1"/>
    <position name="servo" joint="elbow" kp="30" kv="2" gear="2"/></actuator>"""


def test_motors_and_servos_drive_as_those_of_mujoco_do(tmp_path):
    path = written(tmp_path, TWO_HINGES, ACTUATORS)
    scene = ns.Scene.load(path, torque=0.4, servo=0.7)
    places, sol = by_mujoco(path, 0.1, ctrl=(0.4, 0.7)), run(scene, 0.1)
    for body, place in places.items():
        np.testing.assert_allclose(sol[body].position[-1], place, atol=1e-6, err_msg=body)
    assert scene.parameter_values == {"torque": 0.4, "servo": 0.7}
    assert np.abs(sol["lower"].position[-1] - run(ns.Scene.load(path), 0.1)["lower"].position[-1]).max() > 1e-2


def test_limits_are_held_from_where_the_model_starts(tmp_path):
    body = """<body name="bar" pos="0 0 1"><joint name="hinge" axis="0 1 0" range="-20 60" ref="10"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/></body>"""
    sol = run(ns.Scene.load(written(tmp_path, body)), 2, 1e-3)
    assert sol.joint("hinge").angle.max() <= math.radians(50) + 1e-6  # its coordinate starts at 10 degrees
    assert sol.joint("hinge").angle[-1] == pytest.approx(math.radians(50), abs=1e-6)


def test_a_start_outside_of_its_limits_is_moved_into_them_and_said(tmp_path):
    body = """<body name="bar" pos="0 0 1"><joint name="knee" axis="0 1 0" range="30 60"/>
        <geom type="capsule" fromto="0 0 0 .4 0 0" size=".03"/></body>"""
    scene = ns.Scene.load(written(tmp_path, body))
    centre = 0.2 * np.array((math.cos(math.radians(30)), 0, -math.sin(math.radians(30))))
    np.testing.assert_allclose(run(scene, 0.01)["bar"].position[0], centre + (0, 0, 1), atol=1e-12)
    assert "a start outside of its limits, which is moved to the nearer one: knee" in scene.not_understood


def test_friction_of_a_joint_holds_up_to_its_torque(tmp_path):
    turn = {}
    for loss in (1.01, 0.9):
        body = f"""<body name="bar" pos="0 0 1"><joint name="h" axis="0 1 0" frictionloss="{loss * 9.81 * 0.2}"/>
            <geom type="box" size=".2 .02 .02" pos=".2 0 0" mass="1"/></body>"""
        turn[loss] = run(ns.Scene.load(written(tmp_path, body)), 0.5, 1e-3).joint("h").angle[-1]
    assert abs(turn[1.01]) < 1e-9 < 0.1 < turn[0.9]


@pytest.mark.parametrize(("floor", "box", "mu"), [(0.2, 0.6, 0.6), (0.6, 0.2, 0.6), (0.3, 0.1, 0.3)])
def test_the_friction_of_a_pair_is_the_larger_one(floor, box, mu, tmp_path):
    body = f"""<geom name="floor" type="plane" size="1 1 1" friction="{floor}"/>
        <body name="box" pos="0 0 .1"><freejoint/><geom type="box" size=".1 .1 .1" friction="{box}" mass="2"/></body>"""
    scene = ns.Scene.load(written(tmp_path, body))
    scene.force("box", (2 * 9.81 * mu * 1.05, 0, 0), at=(0, 0, 0))
    slides = run(scene, 0.5, 1e-3)["box"].velocity[-1, 0]
    assert slides == pytest.approx(0.5 * 9.81 * mu * 0.05, rel=1e-3)


def test_what_has_no_friction_but_with_what_has(tmp_path):
    body = """<geom name="smooth" type="plane" size="1 1 1" condim="1" friction="1"/>
        <geom name="rough" type="box" size=".5 2 .1" pos="3 0 0" condim="3" friction=".5"/>
        <body name="a" pos="0 0 .1"><freejoint/>{box}</body><body name="b" pos="3 0 .2"><freejoint/>{box}</body>"""
    box = """<geom type="box" size=".1 .1 .1" condim="1" friction=".9" mass="1"/>"""
    scene = ns.Scene.load(written(tmp_path, body.format(box=box)))
    scene.force("a", (1.0, 0, 0))
    scene.force("b", (8.0, 0, 0), at=(3, 0, 0.1))
    sol = run(scene, 0.3, 1e-3)
    assert sol["a"].velocity[-1, 0] == pytest.approx(0.3, rel=1e-9)
    assert abs(sol["b"].velocity[-1, 0]) < 1e-9  # below 0.9 of its weight


def test_balls_roll_and_spin_to_rest_as_condim_says(tmp_path):
    """v^2 (1 + I/(m R^2))/(2 g b) R of rolling friction, I w/(m g c) of spinning, by the larger length of two."""
    body = """<geom type="plane" size="9 9 1" friction="1 .001 .001" condim="3"/>
        <body name="rolls" pos="0 0 .1"><freejoint/><geom type="sphere" size=".1" {lengths} condim="6"/></body>
        <body name="spins" pos="0 3 .1"><freejoint/><geom type="sphere" size=".1" {lengths} condim="4"/></body>
        <body name="slides" pos="0 6 .1"><freejoint/><geom type="sphere" size=".1" {lengths}/></body>"""
    scene = ns.Scene.load(written(tmp_path, body.format(lengths='friction="1 .02 .002"')))
    for k, name in enumerate(("rolls", "spins", "slides")):
        scene[name].velocity[:] = (0.2 if k != 1 else 0.0, 0, 0)
        scene[name].spin[:] = (0, 2.0, 0) if k != 1 else (0, 0, 3.0)
    sol = run(scene, 2.0, 1e-3)
    assert sol["rolls"].position[-1, 0] == pytest.approx(0.2**2 * 1.4 * 0.1 / (2 * 9.81 * 0.002), rel=1e-2)
    spin = sol["spins"].spin[:, 2]
    assert sol.t[np.argmax(np.abs(spin) < 1e-9)] == pytest.approx(0.4 * 0.1**2 * 3.0 / (9.81 * 0.02), abs=2e-3)
    assert sol["slides"].velocity[-1, 0] == pytest.approx(0.2, rel=1e-9)


def test_filters_say_what_touches(tmp_path):
    body = """<geom name="floor" type="plane" size="1 1 1"/>
        <body name="falls" pos="0 0 .5"><freejoint/><geom type="sphere" size=".1" contype="0" conaffinity="0"/></body>
        <body name="lands" pos="1 0 .5"><freejoint/><geom type="sphere" size=".1"/></body>
        <body name="under" pos="1 0 .15"><freejoint/><geom type="sphere" size=".1" contype="2" conaffinity="1"/></body>
        <body name="out" pos="1 0 1"><freejoint/><geom type="sphere" size=".1"/></body>"""
    excluded = """<contact><exclude body1="lands" body2="out"/><exclude body1="out" body2="under"/></contact>"""
    sol = run(ns.Scene.load(written(tmp_path, body, excluded)), 1, 1e-3)
    assert sol["falls"].position[-1, 2] == pytest.approx(0.5 - 9.81 / 2, rel=1e-9)
    assert sol["under"].position[-1, 2] == pytest.approx(0.1, abs=1e-6)
    assert sol["lands"].position[-1, 2] == pytest.approx(0.3, abs=1e-6)
    assert sol["out"].position[-1, 2] == pytest.approx(0.1, abs=1e-6)


def test_bodies_that_are_connected_and_welded_stay_together(tmp_path):
    body = """<body name="a" pos="0 0 1"><joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .3 0 .2" size=".02"/>
        </body><body name="b" pos=".6 0 1"><joint axis="0 1 0"/>
        <geom type="capsule" fromto="0 0 0 -.3 0 .2" size=".02"/></body>
        <body name="c" pos="0 1 1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>
        <body name="d" pos="0 1.4 1"><freejoint/><geom type="box" size=".1 .1 .1"/></body>"""
    held = """<equality><connect name="knee" body1="a" body2="b" anchor=".3 0 .2"/>
        <weld name="glue" body1="c" body2="d"/></equality>"""
    scene = ns.Scene.load(written(tmp_path, body, held))
    sol = run(scene, 0.3, 1e-3)
    np.testing.assert_allclose(sol["a"].position[-1], sol["a"].position[0], atol=1e-5)  # a roof of two rods
    np.testing.assert_allclose(sol["d"].position - sol["c"].position, np.tile((0, 0.4, 0), (301, 1)), atol=1e-9)
    assert sol["c"].position[-1, 2] == pytest.approx(1 - 9.81 * 0.3**2 / 2, rel=1e-6)


STRANGE = """<body name="a" pos="0 0 1"><joint name="j" axis="0 1 0"/><joint name="s" type="slide" axis="1 0 0"/>
    <geom name="g" type="sphere" size=".1" friction="1 .1 .1" condim="6"/>
    <geom type="box" size=".1 .1 .1" friction=".2"/><site name="tip" pos="0 0 .1"/></body>
    <body name="ball" pos="0 2 1"><joint name="socket" type="ball" damping="1"/>
    <geom type="sphere" size=".1" pos=".3 0 0"/></body>"""
NAMES = """<tendon><fixed name="cord" stiffness="3"><joint joint="j" coef="1"/></fixed></tendon>
    <sensor><jointpos name="eye" joint="j"/></sensor><keyframe><key name="home" qpos="0 0 1 0 0 0"/></keyframe>
    <equality><joint name="gears" joint1="j" joint2="s"/></equality>
    <actuator><motor name="pull" tendon="cord"/><muscle name="biceps" joint="j" lengthrange="0 1"/></actuator>"""


def test_what_is_not_understood_is_listed_by_name(tmp_path):
    with pytest.warns(ns.NotUnderstoodWarning, match="robot.xml has what the scene does not: .*tendons: cord"):
        scene = ns.Scene.load(written(tmp_path, STRANGE, NAMES))
    said = " | ".join(scene.not_understood)
    for name in ("cord", "eye", "home", "gears", "pull", "biceps", "socket", "solref"):
        assert name in said, name
    assert "unlike friction, of which the roughest counts: a" in said


def test_a_number_that_no_reader_knows_is_listed(tmp_path):
    body = """<body name="a" pos="0 0 1"><joint name="j" axis="0 1 0" actuatorfrcrange="-1 1"/>
        <geom name="g" type="sphere" size=".1"/></body>"""
    assert any("j" in said and "actfrc" in said for said in ns.Scene.load(written(tmp_path, body)).not_understood)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("hopper", "robot.xml is no XML"),
        ("<sdf/>", "robot.xml is no scene: its root must be <mujoco> or, of URDF, <robot>; got <sdf>"),
        ("<mujoco><worldbody><box/></worldbody></mujoco>", "robot.xml is no MJCF that MuJoCo compiles: .*box"),
        (ROBOT.format("<body name='a'><freejoint/></body>", ""), "is no MJCF that MuJoCo compiles: .*mass"),
    ],
)
def test_a_wrong_file_is_refused_with_one_sentence(text, message, tmp_path):
    (tmp_path / "robot.xml").write_text(text)
    with pytest.raises(ns.InvalidInput, match=message) as refusal:
        ns.Scene.load(tmp_path / "robot.xml")
    assert "\n" not in str(refusal.value)


def test_controls_that_are_none_or_out_of_range_are_refused(tmp_path):
    path = written(tmp_path, TWO_HINGES, ACTUATORS)
    with pytest.raises(ns.InvalidInput, match="has no actuator torqe; .*torque"):
        ns.Scene.load(path, torqe=0.1)
    with pytest.raises(ns.InvalidInput, match="control torque must lie between -1 and 1; got 3"):
        ns.Scene.load(path, torque=3)
    with pytest.raises(ns.InvalidInput, match="value servo must be a number"):
        ns.Scene.load(path, servo="fast")
    with pytest.raises(ns.InvalidInput, match="none.xml cannot be read"):
        ns.Scene.load(tmp_path / "none.xml")


def test_without_mujoco_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ns.MissingExtra, match=r'need mujoco; pip install "nonsmooth\[mjcf\]" brings it'):
        ns.Scene.load(written(tmp_path, TWO_HINGES))


def test_a_scene_of_a_model_is_saved_as_one_of_its_own(tmp_path):
    scene = ns.Scene.load(written(tmp_path, TWO_HINGES, ACTUATORS), torque=0.4)
    scene.save(tmp_path / "robot.toml")
    same = ns.Scene.load(tmp_path / "robot.toml")
    assert np.array_equal(run(same, 0.05)["lower"].position, run(scene, 0.05)["lower"].position)


def test_what_mujoco_warns_of_is_listed_and_no_log_is_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "old.xml"
    path.write_text(
        '<mujoco><compiler settotalmass="5"/><worldbody><body><freejoint/><geom size=".1"/></body></worldbody></mujoco>'
    )
    scene = ns.Scene.load(path)
    assert any("MuJoCo warns: " in said and "settotalmass" in said for said in scene.not_understood)
    assert [file.name for file in tmp_path.iterdir()] == ["old.xml"]
