"""Runs as datasets and tables: the same numbers under their names, and files that other programs open."""

import dataclasses
from typing import NamedTuple

import numpy as np
import pytest

import nonsmooth as ns
from models import BouncingBall, PainleveRod
from models.scenes import BoxStack, Conveyor

xarray = pytest.importorskip("xarray")
pandas = pytest.importorskip("pandas")
STEP = ns.MoreauJean(dt=1e-3)


@pytest.fixture(scope="module", params=[2, 3])
def scene_run(request):
    return ns.simulate(Conveyor(n=2) if request.param == 2 else BoxStack(n=2), (0, 0.02), integrator=STEP)


@pytest.fixture(scope="module")
def rod_run():
    """Sliding ends without force: a paradox, and impacts."""
    rod = PainleveRod(mu=1.6)
    event, never = lambda t, q, u: q[2] - 0.79, lambda t, q, u: 1.0
    start = rod.state(th=0.8, thdot=-1.0, slip=1.0)
    return ns.simulate(rod, (0, 0.1), *start, integrator=ns.MoreauJean(dt=2e-4), events=[event, never])


def test_a_dataset_of_a_scene_has_its_numbers_by_the_names_of_bodies(scene_run):
    data = scene_run.to_xarray()
    for k, name in enumerate(scene_run.names):
        for column in ("position", "turn", "velocity", "spin"):
            np.testing.assert_array_equal(data[column].sel(body=name), getattr(scene_run, column)[:, k])
    np.testing.assert_array_equal(data.kinetic, scene_run.ledger["kinetic"])
    assert data.position.dims == ("t", "body", "axis") and data.position.units == "m" and data.t.units == "s"
    offsets = data.contact_offset.values
    for k in (0, 7, len(scene_run.t) - 1):
        contacts = scene_run.contacts(scene_run.t[k])
        rows = slice(offsets[k], offsets[k + 1])
        np.testing.assert_array_equal(data.contact_P[rows], contacts.P)
        np.testing.assert_array_equal(data.contact_mode[rows], contacts.mode)
        assert (data.contact_record[rows] == k).all()


def test_a_table_of_contacts_names_their_bodies(scene_run):
    table = scene_run.to_dataframe("contacts")
    last, contacts = table[table.record == len(scene_run.t) - 1], scene_run.contacts()
    assert list(last.i) == [scene_run.names[i] for i in contacts.i] and len(last) == len(contacts) > 0
    assert list(last["mode"]) == [ns.ContactMode(mode).name for mode in contacts.mode]
    np.testing.assert_array_equal(last.P_N, contacts.P_N)
    np.testing.assert_array_equal(last.P_F, contacts.P_F)


def test_a_table_of_bodies_has_a_row_for_each_at_each_time(scene_run):
    table = scene_run.to_dataframe()
    assert len(table) == len(scene_run.t) * len(scene_run.names)
    name = scene_run.names[-1]
    own = table[table.body == name]
    np.testing.assert_array_equal(own.position_y, scene_run[name].position[:, 1])
    np.testing.assert_array_equal(own.t, scene_run.t)
    records = scene_run.to_dataframe("records")
    np.testing.assert_array_equal(records["friction [J]"], scene_run.ledger["friction"])


def test_a_dataset_of_a_system_has_modes_events_and_what_the_user_looked_for(rod_run):
    data = rod_run.to_xarray()
    for name in ("q", "u", "g_N", "P_N", "P_F", "mode", "slip", "kinetic"):
        values = rod_run.ledger["kinetic"] if name == "kinetic" else getattr(rod_run, name)
        np.testing.assert_array_equal(data[name], values)
    assert data["mode"].flag_meanings.split()[: len(ns.ContactMode)] == [mode.name.lower() for mode in ns.ContactMode]
    np.testing.assert_array_equal(data.event_t, [event.t for event in rod_run.events])
    np.testing.assert_array_equal(data.t_events_0, rod_run.t_events[0])
    assert len(data.t_events_0) > 0 and len(data.t_events_1) == 0
    assert list(data.coordinate.values) == [name for name, _ in PainleveRod.coordinates]
    assert data.attrs["status"] == "FINISHED" and data.attrs["mu"] == "1.6"
    ball = BouncingBall(e=0.5)
    falls = ns.simulate(ball, (0, 1), *ball.state(height=0.1), integrator=ns.EventDriven())
    table = falls.to_dataframe("events")
    assert list(table.kind) == [event.kind.name for event in falls.events] and len(table) > 0
    np.testing.assert_array_equal(falls.to_xarray().event_t, table.t)
    records = rod_run.to_dataframe()
    np.testing.assert_array_equal(records["x"], rod_run.q[:, 0])
    assert records["mode[0]"][0] == ns.ContactMode(rod_run.mode[0, 0]).name


def test_xarray_opens_what_was_saved_as_netcdf(scene_run, rod_run, tmp_path):
    pytest.importorskip("netCDF4")
    for number, run in enumerate((scene_run, rod_run)):
        path = run.save(tmp_path / f"{number}.nc")
        with xarray.open_dataset(path) as found:
            xarray.testing.assert_equal(found.load(), run.to_xarray())
        loaded = type(run).load(path)
        xarray.testing.assert_equal(loaded.to_xarray(), run.to_xarray())


def test_what_was_not_recorded_is_not_in_the_dataset():
    run = ns.simulate(BoxStack(n=2), (0, 0.01), integrator=STEP, record="ledger")
    data = run.to_xarray()
    assert "kinetic" in data and "position" not in data and "contact_P" not in data
    with pytest.raises(ns.InvalidInput, match="all_contacts was not recorded"):
        run.to_dataframe("contacts")


@pytest.mark.parametrize("what", ["xarray", "pandas"])
def test_a_library_that_is_missing_is_named_with_its_cure(scene_run, rod_run, monkeypatch, what):
    monkeypatch.setitem(__import__("sys").modules, what, None)
    for run in (scene_run, rod_run):
        act = run.to_xarray if what == "xarray" else run.to_dataframe
        with pytest.raises(ns.MissingExtra, match=rf'labelled data need {what}; pip install "nonsmooth\[data\]"'):
            act()


@pytest.mark.parametrize("what", ["body", 3, None])
def test_a_table_that_is_none_is_refused(scene_run, rod_run, what):
    for run in (scene_run, rod_run):
        with pytest.raises(ns.InvalidInput, match="there is no table"):
            run.to_dataframe(what)


@pytest.fixture(scope="module")
def cart_run():
    """A cart, a turning wheel on it and two named contacts: metres, radians, names of everything."""

    def mass(t, q, p, M):
        M[0, 0] = M[1, 1] = 1.0

    def force(t, q, u, p, h):
        h[0] = -9.81

    def gap(t, q, p, g_N):
        g_N[0], g_N[1] = q[0], 1.0 - q[1]

    cart = ns.System(
        coordinates=[("x", "m"), ("th", "rad")], mass=mass, force=force, gap=gap, name="cart", parameters=Nothing(),
        contacts=[ns.Contact(e_N=0.5, name="floor"), ns.Contact(name="stop")],
    )  # fmt: skip
    return ns.simulate(cart, (0, 0.5), state={"x": 0.2, "thdot": 1.0}, integrator=STEP)


class Nothing(NamedTuple):
    m: float = 1.0


def test_a_table_has_the_names_and_the_units_of_a_users_own_system(cart_run):
    table = cart_run.to_dataframe()
    named = ["t", "x", "th", "xdot", "thdot", "g_N[floor]", "g_N[stop]", "P_N[floor]", "P_N[stop]"]
    assert list(table.columns[: len(named)]) == named
    for name in ("x", "th", "xdot", "thdot"):
        np.testing.assert_array_equal(table[name], cart_run[name])
    units = table.attrs["units"]
    assert [units[name] for name in named] == ["s", "m", "rad", "m/s", "rad/s", "m", "m", "N s", "N s"]
    assert set(table["mode[stop]"]) <= {mode.name for mode in ns.ContactMode} and units["kinetic [J]"] == "J"
    events = cart_run.to_dataframe("events")
    assert set(events.contact_name) == {"floor"} and events.attrs["units"]["gamma_N"] == "m/s"


def test_a_dataset_has_the_names_and_the_units_of_a_users_own_system(cart_run):
    data = cart_run.to_xarray()
    np.testing.assert_array_equal(data.g_N.sel(contact="stop"), cart_run.g_N[:, 1])
    np.testing.assert_array_equal(data.u.sel(velocity="th"), cart_run["thdot"])
    assert data.coordinate_units.values.tolist() == ["m", "rad"]
    assert data.velocity_units.values.tolist() == ["m/s", "rad/s"]
    assert data.q.units == "" and data.event_P_N.units == "N s" and data.event_t.units == "s"


def test_coordinates_of_one_unit_have_it_as_their_variable():
    ball = BouncingBall()
    data = ns.simulate(ball, (0, 0.1), *ball.state(), integrator=STEP).to_xarray()
    assert data.q.units == "m" and data.u.units == "m/s"


def test_without_names_columns_are_counted(cart_run):
    bare = dataclasses.replace(cart_run.system, coordinates=(), n_q=2, contacts=[ns.Contact()] * 2)
    table = ns.simulate(bare, (0, 0.1), [0.2, 0.0], [0.0, 1.0], integrator=STEP).to_dataframe()
    assert list(table.columns[:7]) == ["t", "q[0]", "q[1]", "u[0]", "u[1]", "g_N[0]", "g_N[1]"]
