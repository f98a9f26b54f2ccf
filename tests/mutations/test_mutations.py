"""One line of the mechanics is broken at a time, in a copy; the test that guards it must fail.

``pytest -m slow tests/mutations`` takes some minutes: each mutation compiles what it touches. A test that still passes
with a wrong sign guards nothing.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).parents[2]
PATIENCE = 600  # s


class Mutation(NamedTuple):
    """A line of a file, what is put in its place, and the test that must notice."""

    file: str
    line: str
    broken: str
    guard: str


STEPPING = "tests/integrators/moreau_jean/test_moreau_jean.py::"
COMPLIANT = "tests/integrators/penalty/test_penalty_contact.py::"
PLANAR = "tests/integrators/assembly/test_planar_scenes.py::"
FOUND = "tests/scenes/planar/test_find_contacts.py::"
SPATIAL = "tests/integrators/assembly/test_spatial_scenes.py::"
ELASTIC = "tests/integrators/assembly/test_elastic_impacts.py::"
PAIRS = "tests/integrators/assembly/test_pairs.py::"
GUIDED = "tests/integrators/assembly/test_guided_bodies.py::"
MUTATIONS = {
    "friction pushes the way it slides": Mutation(
        "contact/planar/single.py", "P_F = -s * mu * sigma * P_N", "P_F = s * mu * sigma * P_N",
        STEPPING + "test_block_stops_where_its_kinetic_energy_is_spent",
    ),
    "the coupling of slip and pressure has the other sign": Mutation(
        "contact/planar/single.py", "D = G_NN - s * mu * sigma * G_NF", "D = G_NN + s * mu * sigma * G_NF",
        STEPPING + "test_inconsistent_state_is_an_impact_without_collision_with_its_impulses",
    ),
    "sticking holds twice its limit": Mutation(
        "contact/planar/single.py", "most = static_coefficient(problem.laws, k) * reach",
        "most = 2.0 * static_coefficient(problem.laws, k) * reach",
        STEPPING + "test_block_holds_just_below_the_friction_limit_and_slides_just_above",
    ),
    "restitution takes the speed away twice": Mutation(
        "mechanics/contact_problem.py", "c[r] += sys.laws[i, LAW_E_N] * gamma_0[r]",
        "c[r] -= sys.laws[i, LAW_E_N] * gamma_0[r]",
        STEPPING + "test_ball_bounces_at_the_closed_form_times_within_one_step",
    ),
    "impacts are elastic": Mutation(
        "mechanics/contact_problem.py", "c[r] += sys.laws[i, LAW_E_N] * gamma_0[r]", "c[r] += gamma_0[r]",
        STEPPING + "test_ball_comes_to_rest_after_its_zeno_point",
    ),
    "the weights of theta are exchanged": Mutation(
        "integrators/moreau_jean/step.py", "q[i] += dt * ((1.0 - theta) * u[i] + theta * u_1[i])",
        "q[i] += dt * (theta * u[i] + (1.0 - theta) * u_1[i])",
        STEPPING + "test_positions_take_the_new_velocity_with_the_weight_theta",
    ),
    "forces are taken at the beginning of the step": Mutation(
        "integrators/moreau_jean/step.py", "q_mid[i] = q[i] + 0.5 * dt * u[i]", "q_mid[i] = q[i]",
        STEPPING + "test_pendulum_in_smooth_motion_is_of_second_order",
    ),
    "the implicit matrix loses its sign": Mutation(
        "mechanics/contact_problem.py", "Mhat[i, j] = M[i, j] + theta * dt *", "Mhat[i, j] = M[i, j] - theta * dt *",
        STEPPING + "test_implicit_step_is_stable_where_an_explicit_one_is_not",
    ),
    "the free velocity forgets the forces": Mutation(
        "mechanics/contact_problem.py", "            total += W[k, j] * du[j]",
        "            total += 0.0 * W[k, j] * du[j]",
        STEPPING + "test_block_stuck_on_an_oblique_plane_keeps_its_place_over_a_million_steps",
    ),
    "velocities that are not finite are accepted": Mutation(
        "integrators/moreau_jean/step.py", "    return total == 0.0", "    return True",
        "tests/runs/test_simulate.py::test_nan_written_by_a_model_function_names_the_function_and_keeps_the_past",
    ),
    "an impact without collision slides on as it was": Mutation(
        "mechanics/impact.py", "return -s * mu, abs(gamma_F / k) if s * k < 0.0 else math.inf",
        "return s * mu, abs(gamma_F / k) if s * k < 0.0 else math.inf",
        "tests/paradox/test_impact_map.py::test_impact_without_collision_has_the_published_closed_forms",
    ),
    "Poisson's ratio is squared": Mutation(
        "mechanics/impact.py", "return e * P_c", "return e * e * P_c",
        "tests/paradox/test_impact_map.py::test_closed_form_solves_the_equations_in_the_normal_impulse",
    ),
    "the energetic ratio is one of velocities": Mutation(
        "mechanics/impact.py", "work = e * e * compression_work", "work = e * compression_work",
        "tests/paradox/test_impact_map.py::test_closed_form_solves_the_equations_in_the_normal_impulse",
    ),
    "a seizure sticks on the wrong side of the cone": Mutation(
        "mechanics/impact.py", "return -math.copysign(mu, G_NF)", "return math.copysign(mu, G_NF)",
        "tests/paradox/test_impact_map.py::test_closed_form_solves_the_equations_in_the_normal_impulse",
    ),
    "the projection moves into the wall": Mutation(
        "integrators/moreau_jean/projection.py", "change = -gap / work.G[a, a]", "change = gap / work.G[a, a]",
        "tests/integrators/moreau_jean/test_position_projection.py::test_a_bead_stays_on_its_wire_to_rounding",
    ),
    "the ratio test takes the largest": Mutation(
        "lcp/lemke.py", "            if ratio < least:", "            if ratio > least or least == np.inf:",
        "tests/lcp/test_lcp_lemke.py::test_lemke_solves_random_frictional_problems",
    ),
    "the natural map has the other sign": Mutation(
        "contact/blocks/natural_map.py", "cone_project(mu, P_N - gamma_N,", "cone_project(mu, P_N + gamma_N,",
        "tests/contact/blocks/test_contact_local.py::test_single_contact_satisfies_the_inclusion_of_one_of_its_modes",
    ),
    "a kink in a model counts as a wrong derivative": Mutation(
        "mechanics/agreement.py", "KINK_SAFETY * (abs(E) + abs(J))", "KINK_SAFETY * abs(E)",
        "tests/mechanics/test_agreement.py::test_a_kink_or_a_jump_wherever_it_is_contradicts_no_derivative",
    ),
    "one step alone decides that a derivative is wrong": Mutation(
        "mechanics/agreement.py", "        if contradicted & suspects:",
        "        suspects |= contradicted\n        if contradicted:",
        "tests/mechanics/test_agreement.py::test_a_ripple_as_short_as_one_step_is_no_contradiction",
    ),
    "runs are not looked at on their way": Mutation(
        "runs/system_run.py", "if status == Status.RUNNING and is_due(self.system, self.state.mode.tobytes()):",
        "if False:", "tests/mechanics/test_agreement.py::test_a_long_run_is_looked_at_on_its_way",
    ),
    "a dual cosine falls the wrong way": Mutation(
        "numerics/dual.py", "complex(math.cos(z.real), -math.sin(z.real) * z.imag)",
        "complex(math.cos(z.real), math.sin(z.real) * z.imag)",
        "tests/mechanics/test_derived_rows.py::test_derived_rows_are_those_written_by_hand_to_rounding",
    ),
    "a cycle has to close in what drifts": Mutation(
        "cycles/shooting.py", "return self.across @ missed if", "return missed if",
        "tests/cycles/test_drifting_cycles.py::test_two_discs_on_a_shaft_turn_on_together",
    ),
    "a compliant contact is driven by its damper": Mutation(
        "integrators/penalty/law.py", "return k * d + c * d_rate", "return k * d - c * d_rate",
        COMPLIANT + "test_clipped_contact_bounces_with_the_restitution_of_its_damping_ratio",
    ),
    "bodies of a scene rebound elastically": Mutation(
        "integrators/assembly/impact.py", "network.b[c, 0] = contacts.e[c] * gamma_minus",
        "network.b[c, 0] = gamma_minus",
        PLANAR + "test_ball_rebounds_with_its_coefficient_and_never_goes_into_the_ground",
    ),
    "a body lands with the velocity of the end of the step": Mutation(
        "integrators/assembly/impact.py", "approach(found.gap[c], gamma_0, gamma_free, dt)", "gamma_free",
        ELASTIC + "test_a_ball_that_falls_keeps_its_energy_to_rounding_at_any_step",
    ),
    "a contact that is open is held when others rebound": Mutation(
        "integrators/assembly/impact.py", "left + far if left > 0.0 and contacts.e[c] > 0.0 else max(0.0, left)",
        "max(0.0, left)", ELASTIC + "test_a_gas_of_smooth_bodies_gains_no_energy_and_without_loss_keeps_it",
    ),
    "contacts that rebound together give back what they ask for": Mutation(
        "integrators/assembly/energy_limit.py", "if hits < 2 or work <= given_back:", "if True:",
        ELASTIC + "test_a_gas_of_smooth_bodies_gains_no_energy_and_without_loss_keeps_it",
    ),
    "a contact closes before its bodies meet": Mutation(
        "integrators/assembly/contacts.py", "found.gap[c] / dt if found.gap[c] > 0.0 else 0.0", "0.0",
        PLANAR + "test_ball_rebounds_with_its_coefficient_and_never_goes_into_the_ground",
    ),
    "bodies in flight move with the velocity at the end": Mutation(
        "integrators/assembly/project.py", "weight = 2.0 if k >= 0 and moves.lands[k] > 0 else 2.0 * theta",
        "weight = 2.0", PLANAR + "test_free_flight_is_the_parabola_to_rounding",
    ),
    "the arm of a force turns its body the other way": Mutation(
        "integrators/assembly/planar.py", "sign * (arm_x * n_x + arm_y * n_y)", "-sign * (arm_x * n_x + arm_y * n_y)",
        PLANAR + "test_rolling_disc_has_two_thirds_of_its_sliding_speed",
    ),
    "a free body turns back in its own axes": Mutation(
        "integrators/assembly/spatial.py", "-0.5 * dt * o_0, -0.5 * dt * o_1, -0.5 * dt * o_2, P_0",
        "0.5 * dt * o_0, 0.5 * dt * o_1, 0.5 * dt * o_2, P_0",
        SPATIAL + "test_tumbling_about_the_middle_axis_is_of_second_order",
    ),
    "gravity works on the velocity at the end": Mutation(
        "integrators/assembly/book.py", "mean = 0.5 * (bodies.v_0[b, k] + network.v[b, k])", "mean = network.v[b, k]",
        PLANAR + "test_energy_ledger_closes_to_rounding_through_impacts",
    ),
    "a belt takes what it gives": Mutation(
        "integrators/assembly/book.py", "        surface -= P * given", "        surface += P * given",
        PLANAR + "test_work_of_a_belt_under_a_body_that_stands_is_booked_at_every_step",
    ),
    "what is left out at rest exchanges nothing": Mutation(
        "integrators/assembly/pairs.py", "            pairs.times[row] += steps\n", "",
        PAIRS + "test_what_sleeps_goes_on_with_its_weight_and_no_bit_depends_on_its_sleep",
    ),
    "pairs that rebound have the impulse of their landing alone": Mutation(
        "integrators/assembly/stages.py", "        book_by_pairs(places, 1, False)\n", "",
        PAIRS + "test_two_discs_that_collide_at_an_angle_exchange_what_each_loses",
    ),
    "the point beneath what is carried stays behind": Mutation(
        "integrators/assembly/guided.py", "total -= turn_of_guide(", "total -= 0.0 * turn_of_guide(",
        GUIDED + "test_what_lies_on_a_turntable_goes_out_to_third_order_and_back_to_second",
    ),
    "a jump of a guided body is an acceleration": Mutation(
        "integrators/assembly/world.py", "np.fmin(np.abs(told), most)", "np.abs(told)",
        GUIDED + "test_a_kick_that_begins_within_a_step_throws_at_its_speed",
    ),
    "what stands on one floor is one island": Mutation(
        "contact/network/islands.py", "if can_move(network.M_inv, body, n) else -1", "",
        "tests/contact/network/test_network.py::test_islands_are_the_components_of_the_bodies_that_can_move",
    ),
    "a sweep forgets what the contact itself does": Mutation(
        "contact/network/gauss_seidel.py", "b_N -= W[c, 0, 0] * P_N + W[c, 0, 1] * P_1",
        "b_N += W[c, 0, 0] * P_N + W[c, 0, 1] * P_1",
        "tests/contact/network/test_network.py::test_sweeps_find_the_motion_that_block_solvers_find",
    ),
    "a body is told of the impulse of the other side": Mutation(
        "contact/network/lagrangian.py", "        g[row, x] -= total", "        g[row, x] += total",
        "tests/contact/network/test_direct.py::test_stack_carries_the_weight_that_stands_on_each_of_its_boxes",
    ),
    "a sphere slides with the friction of a smaller weight": Mutation(
        "contact/network/spheres.py", "x_2 * x_2, mu * x_N", "x_2 * x_2, 0.9 * mu * x_N",
        "tests/contact/network/test_spheres.py::test_conjugate_sweeps_are_those_of_the_rows_of_the_network",
    ),
    "a factor keeps what was to be eliminated": Mutation(
        "contact/network/block_factor.py", "subtract_product(factor.D, columns.row[at], L, at, U, at, n)", "pass",
        "tests/contact/network/test_factor.py::test_factors_solve",
    ),
    "hulls part along the face that is nearest": Mutation(
        "scenes/planar/hulls.py", "        if s > best:", "        if s < best or face < 0:",
        "tests/scenes/planar/test_hulls.py::test_gap_normal_and_point_are_those_of_the_hull_of_differences",
    ),
    "what approaches is looked at where it is": Mutation(
        "scenes/planar/find_contacts.py", "gap + dt * min(nx * rate_x + ny * rate_y, 0.0) < margin", "gap < margin",
        FOUND + "test_a_gap_that_closes_within_the_step_is_kept_and_one_that_does_not_is_not",
    ),
    "parts of a body weigh nothing away from its centre": Mutation(
        "scenes/mass_properties.py", "part.inertia + carried(part, centroid)", "part.inertia",
        "tests/scenes/test_mass_properties.py::test_a_box_cut_in_two_and_put_together_is_that_box",
    ),
    "the spring of a scene is driven by its damper": Mutation(
        "integrators/springs/law.py", "la = normal_force(law.law, law.k, c, d, d_rate)",
        "la = normal_force(law.law, law.k, -c, d, d_rate)",
        "tests/integrators/springs/test_spring_scenes.py::test_damped_ball_rebounds_with_the_closed_form_restitution",
    ),
    "a belt takes what it gives, pair by pair": Mutation(
        "integrators/springs/exchange.py", "= friction, -given", "= friction, given",
        "tests/integrators/springs/test_spring_pairs.py::"
        "test_pairs_on_springs_sum_up_to_the_ledger_and_to_the_momenta",
    ),
    "the step to come begins without what springs do": Mutation(
        "integrators/springs/steps.py", "write_exchange(network, springs, 0, c, c, d, given)", "given = 0.0",
        "tests/integrators/springs/test_spring_pairs.py::test_two_discs_on_springs_exchange_what_each_loses",
    ),
}  # fmt: skip


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


def outcome(copy, guard, cache):
    """Exit code and words of the guard, run on a copy."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", guard]
    environment = {**os.environ, "PYTHONPATH": str(copy), "NONSMOOTH_CACHE_DIR": str(cache)}
    done = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True, timeout=PATIENCE,
                          stdin=subprocess.DEVNULL)  # fmt: skip
    return done.returncode, done.stdout[-2000:]


def copied(tmp_path):
    """Package, models, tests and what they use, where they can be broken."""
    for folder in ("nonsmooth", "models", "benchmarks", "tests"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    for file in ("pyproject.toml", "conftest.py"):
        shutil.copy(ROOT / file, tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", MUTATIONS)
def test_the_line_that_is_broken_stands_in_its_file_once(name):
    file, line, broken, guard = MUTATIONS[name]
    assert (ROOT / "nonsmooth" / file).read_text().count(line) == 1
    path, test = guard.split("::")
    assert f"def {test}(" in (ROOT / path).read_text() and broken != line


@pytest.mark.slow
def test_every_guard_passes_on_what_is_not_broken(tmp_path, cache):
    copy = copied(tmp_path)
    for guard in sorted({mutation.guard for mutation in MUTATIONS.values()}):
        code, words = outcome(copy, guard, cache)
        assert code == 0, words


@pytest.mark.slow
@pytest.mark.parametrize("name", MUTATIONS)
def test_a_wrong_sign_or_rule_is_caught(name, tmp_path, cache):
    file, line, broken, guard = MUTATIONS[name]
    copy = copied(tmp_path)
    path = copy / "nonsmooth" / file
    path.write_text(path.read_text().replace(line, broken))
    code, words = outcome(copy, guard, cache)
    assert code == 1, f"{name}: {guard} does not notice\n{words}"  # 1: tests ran, and some failed
