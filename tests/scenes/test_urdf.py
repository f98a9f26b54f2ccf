"""URDF files as scenes: against closed forms, statics and MuJoCo's own reader; what is not understood is listed."""

import sys

import numpy as np
import pytest

import nonsmooth as ns

yourdfpy = pytest.importorskip("yourdfpy")
pytestmark = pytest.mark.filterwarnings("ignore::nonsmooth.NotUnderstoodWarning")

INERTIAL = """<inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{m}"/>
    <inertia ixx="{ixx}" ixy=".001" ixz="0" iyy=".03" iyz="0" izz=".03"/></inertial>"""


def link(name, shape="", xyz="0 0 0", rpy="0 0 0", m=1.0, ixx=0.02):
    body = INERTIAL.format(xyz=xyz, rpy=rpy, m=m, ixx=ixx) if m else ""
    return f'<link name="{name}">{body}{shape}</link>'


def joint(name, kind, parent, child, more="", xyz="0 0 0", rpy="0 0 0", axis="0 1 0"):
    return f"""<joint name="{name}" type="{kind}"><origin xyz="{xyz}" rpy="{rpy}"/><parent link="{parent}"/>
        <child link="{child}"/><axis xyz="{axis}"/>{more}</joint>"""


def collision(geometry, xyz="0 0 0"):
    return f'<collision><origin xyz="{xyz}"/><geometry>{geometry}</geometry></collision>'


def written(tmp_path, *parts, name="robot.urdf"):
    (tmp_path / name).write_text(f'<robot name="robot">{"".join(parts)}</robot>')
    return tmp_path / name


def run(scene, t_end, dt=1e-3):
    return ns.simulate(scene, (0, t_end), integrator=ns.MoreauJean(dt=dt))


ARM = (
    link("base", m=0.0),
    link("upper", xyz=".2 0 .1", rpy=".3 .2 .1", m=2.0),
    link("flange", xyz="0 .1 0", m=0.5),
    link("lower", xyz=".1 0 -.2", rpy="0 .5 0"),
    joint("shoulder", "continuous", "base", "upper", '<dynamics damping=".4"/>', "0 0 1", "0 .3 .2", "0 1 .5"),
    joint("bolt", "fixed", "upper", "flange", xyz=".4 0 0", rpy=".2 0 0"),
    joint(
        "rail", "prismatic", "flange", "lower", '<limit lower="-9" upper="9" effort="9" velocity="9"/>', axis="1 0 1"
    ),
)


def test_an_arm_that_falls_is_where_mujoco_has_it(tmp_path):
    mujoco = pytest.importorskip("mujoco")
    path = written(tmp_path, *ARM)
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.integrator, model.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 1e-4
    data = mujoco.MjData(model)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    scene = ns.Scene.load(path)
    sol = run(scene, 0.1, 1e-4)
    assert [body.name for body in scene.bodies] == ["world", "upper", "lower"]
    for name in ("upper", "lower"):
        place = data.xipos[mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)]
        np.testing.assert_allclose(sol[name].position[-1], place, atol=1e-6, err_msg=name)
        assert np.abs(sol[name].position[-1] - sol[name].position[0]).max() > 1e-2


def test_a_robot_stands_on_its_feet_with_its_weight(tmp_path):
    foot = collision('<cylinder radius=".1" length=".05"/>')
    path = written(
        tmp_path, link("trunk", collision('<box size=".3 .2 .1"/>'), m=5.0), link("left", foot), link("right", foot),
        joint("a", "fixed", "trunk", "left", xyz="-.2 0 -.4"), joint("b", "fixed", "trunk", "right", xyz=".2 0 -.4"),
    )  # fmt: skip
    scene = ns.Scene.load(path)
    scene.fixed(ns.HalfSpace((0, 0, 1)), position=(0, 0, -0.425), name="ground")
    sol = run(scene, 0.5)
    np.testing.assert_allclose(sol["trunk"].position[-1], sol["trunk"].position[0], atol=1e-9)
    assert sol.contacts().of("ground").P_N.sum() / 1e-3 == pytest.approx(7 * 9.81, rel=1e-6)


def test_a_root_stands_still_without_a_mass_or_where_it_is_asked_for(tmp_path):
    path = written(tmp_path, link("trunk"), link("arm", xyz="1 0 0"), joint("j", "continuous", "trunk", "arm"))
    assert run(ns.Scene.load(path), 0.1)["trunk"].position[-1, 2] == pytest.approx(-9.81 * 0.1**2 / 2, rel=1e-9)
    held = ns.Scene.load(path, fixed_base=1)
    assert [body.name for body in held.bodies] == ["world", "arm"]
    assert run(held, 0.1).joint("j").angle[-1] == pytest.approx(9.81 / (0.03 + 1) * 0.1**2 / 2, rel=1e-3)


@pytest.mark.upkeep
def test_limits_effort_and_friction_of_joints(tmp_path):
    limits = '<limit lower="-.5" upper=".25" effort="3" velocity="1"/><dynamics friction=".5"/>'
    path = written(tmp_path, link("base", m=0.0), link("arm"), joint("j", "revolute", "base", "arm", limits))
    assert run(ns.Scene.load(path, j=0.49), 1).joint("j").angle[-1] == pytest.approx(0.0, abs=1e-9)
    pushed = run(ns.Scene.load(path, j=0.8), 1)
    assert pushed.joint("j").angle[100] == pytest.approx(0.5 * 0.3 / 0.03 * 0.1**2, rel=1e-3)
    assert pushed.joint("j").angle[-1] == pytest.approx(0.25, abs=1e-6)
    with pytest.raises(ns.InvalidInput, match="j must lie between -3 and 3, its effort; got 4"):
        ns.Scene.load(path, j=4)
    with pytest.raises(ns.InvalidInput, match="has no joint k that moves along an axis"):
        ns.Scene.load(path, k=1)


def test_links_touch_one_another_where_it_is_asked_for(tmp_path):
    ball = collision('<sphere radius=".1"/>')
    free = joint("free", "floating", "base", "ball", xyz="0 0 1")
    path = written(tmp_path, link("base", collision('<box size="1 1 .2"/>'), m=0.0), link("ball", ball), free)
    heights = {touch: run(ns.Scene.load(path, self_collision=touch), 1)["ball"].position[-1, 2] for touch in (0, 1)}
    assert heights[0] == pytest.approx(1 - 9.81 / 2, rel=1e-9)
    assert heights[1] == pytest.approx(0.2, abs=1e-6)


def test_a_mesh_is_its_convex_hull(tmp_path):
    pytest.importorskip("trimesh")
    corners = [(x, y, z) for x in (0, 0.2) for y in (0, 0.2) for z in (0, 0.2)]
    faces = ["1 2 4 3", "5 6 8 7", "1 2 6 5", "3 4 8 7", "1 3 7 5", "2 4 8 6"]
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *(f"f {face}" for face in faces)]
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "cube.obj").write_text("\n".join(lines))
    mesh = collision('<mesh filename="package://robot/meshes/cube.obj" scale="1 1 2"/>')
    missing = collision('<mesh filename="package://robot/meshes/none.stl"/>')
    scene = ns.Scene.load(written(tmp_path, link("block", mesh + missing, xyz=".1 .1 .2")))
    scene.fixed(ns.HalfSpace((0, 0, 1)), position=(0, 0, -0.3), name="ground")
    assert run(scene, 1)["block"].position[-1, 2] == pytest.approx(-0.1, abs=1e-6)
    said = " | ".join(scene.not_understood)
    assert "meshes, of which the convex hulls are taken: block" in said
    assert "meshes that cannot be read, which are left out: block (FileNotFoundError: there is no file package" in said


def test_what_is_not_understood_is_listed_by_name(tmp_path):
    mimic = '<mimic joint="j"/><limit lower="1" upper="2" effort="1" velocity="3"/><safety_controller k_velocity="1"/>'
    path = written(
        tmp_path, link("base", m=0.0), link("arm"), link("hand"),
        '<transmission name="gears"/><gazebo reference="arm"/>',
        joint("j", "continuous", "base", "arm"), joint("k", "revolute", "arm", "hand", mimic),
    )  # fmt: skip
    with pytest.warns(ns.NotUnderstoodWarning, match="robot.urdf has what the scene does not: elements <transmission>"):
        scene = ns.Scene.load(path)
    for said in (
        "elements <transmission>: gears", "elements <gazebo>: arm", "elements <mimic>: k",
        "elements <safety_controller>: k", "the largest speeds of joints: k",
        "a start outside of its limits, which is moved to the nearer one: k",
    ):  # fmt: skip
        assert said in scene.not_understood


@pytest.mark.parametrize(
    ("parts", "message"),
    [
        (("<link/>",), "robot.urdf is no URDF that yourdfpy reads: KeyError"),
        ((link("a"), joint("j", "fixed", "a", "b")), "joint j joins b, which is no link"),
        ((link("a"), link("b"), joint("j", "fixed", "a", "b"), joint("k", "fixed", "b", "a")), "hangs on itself"),
        (
            (link("a"), link("b"), link("c"), joint("j", "fixed", "a", "c"), joint("k", "fixed", "b", "c")),
            "link c has two parents; a URDF is a tree, hold loops by scene.joint",
        ),
        ((link("a"), link("b"), joint("j", "helical", "a", "b")), "joint j is of no known type; got helical"),
        (
            (link("a"), link("b", m=0.0), joint("j", "continuous", "a", "b")),
            "link b moves and has no mass; give it one",
        ),
        ((link("a"), link("b", ixx=1.0), joint("j", "continuous", "a", "b")), "inertia of b is that of no body"),
    ],
)
def test_a_wrong_file_is_refused_with_one_sentence(parts, message, tmp_path):
    with pytest.raises(ns.InvalidInput, match=message) as refusal:
        ns.Scene.load(written(tmp_path, *parts))
    assert "\n" not in str(refusal.value)


def test_without_yourdfpy_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "yourdfpy", None)
    with pytest.raises(ns.MissingExtra, match=r'need yourdfpy; pip install "nonsmooth\[urdf\]" brings it'):
        ns.Scene.load(written(tmp_path, *ARM))


def test_a_planar_joint_leaves_a_plane_and_a_turn(tmp_path):
    path = written(tmp_path, link("base", m=0.0), link("disc"), joint("j", "planar", "base", "disc", axis="0 1 0"))
    scene = ns.Scene.load(path)
    scene.force("disc", (2.0, 5.0, 0), at=(0, 0, 0.1))
    sol = run(scene, 0.1)
    np.testing.assert_allclose(sol["disc"].position[-1], (0.01, 0, -9.81 * 0.1**2 / 2), rtol=1e-3, atol=1e-9)
    assert sol["disc"].spin[-1, 1] == pytest.approx(0.2 / 0.03 * 0.1, rel=1e-2)  # the arm turns along
    assert np.abs(sol["disc"].spin[-1, ::2]).max() < 1e-6
