"""The stability tag of a mode against the motion of a stiff contact."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import nonsmooth as ns
from models import PainleveRod
from nonsmooth.paradox.stability import Stability, effective_matrix, stability_of


def grows(P, c, seed):
    """Whether z'' = -P (z + c z') leaves its rest, integrated over many periods (stiffness 1)."""
    m = len(P)
    z_0 = np.random.default_rng(seed).normal(size=2 * m)

    def rate(t, z):
        return np.concatenate([z[m:], -P @ (z[:m] + c * z[m:])])

    slowest = np.abs(np.linalg.eigvals(np.block([[np.zeros((m, m)), np.eye(m)], [-P, -c * P]])).real).min()
    end = 12.0 / max(slowest, 1e-3)
    sol = solve_ivp(rate, (0.0, end), z_0, method="DOP853", rtol=1e-9, atol=1e-12, t_eval=[0.0, end])
    return np.linalg.norm(sol.y[:, -1]) > np.linalg.norm(sol.y[:, 0])


@pytest.mark.upkeep
def test_tag_agrees_with_the_motion_of_a_stiff_contact():
    # between 0.8 and 1.25 times the least damping the verdict turns; random matrices of two and three contacts
    rng = np.random.default_rng(3)
    met = {kind: 0 for kind in Stability}
    for trial in range(60):
        m = int(rng.integers(1, 4))
        P = rng.normal(size=(m, m)) + 1.2 * np.eye(m)
        tag = stability_of(P)
        met[tag.kind] += 1
        if tag.kind == Stability.SADDLE:
            assert grows(P, 0.3, trial)
        elif tag.kind == Stability.STABLE:
            assert not grows(P, 0.3, trial)
        else:
            assert grows(P, math.sqrt(0.8 * tag.damping), trial)
            assert not grows(P, math.sqrt(1.25 * tag.damping), trial)
    assert min(met.values()) >= 5, met


def test_slide_with_negative_p_is_a_saddle_and_with_positive_p_stable():
    for mu, kind in [(0.5, Stability.STABLE), (2.0, Stability.SADDLE)]:
        rod = PainleveRod(mu=mu)
        c = ns.classify(rod, 0.0, *rod.state(th=math.pi / 3, thdot=6.0 if mu == 2.0 else 0.0))
        slide = next(s for s in c.solutions if s.modes == ("slide -",))
        assert slide.stability.kind == kind
        assert slide.stability.rho == pytest.approx([c.p[0, 1]], rel=1e-14)


def test_separatrix_of_the_indeterminate_state_is_the_sliding_force():
    # NUMERICS 3: with z = z' = 0 at contact, the stiff contact lifts off, and above N* it is driven in
    rod = PainleveRod(mu=2.0)
    c = ns.classify(rod, 0.0, *rod.state(th=math.pi / 3, thdot=6.0))
    p, b = c.p[0, 1], c.b[0]
    star = next(float(s.la_N[0]) for s in c.solutions if s.modes != ("free",))
    k = 1e10

    def depth_rate(t, d):
        return [d[1], -b - p * max(0.0, k * d[0])]  # d'' = -gamma_N', la_N = k d

    for factor, sign in [(0.9, -1.0), (1.1, 1.0)]:
        d_0 = factor * star / k
        sol = solve_ivp(depth_rate, (0.0, 20.0 / math.sqrt(-p * k)), [d_0, 0.0], rtol=1e-10, atol=1e-18)
        assert sign * (sol.y[0, -1] - d_0) > 10 * d_0


def test_sticking_contact_yields_the_schur_complement():
    rng = np.random.default_rng(0)
    W = rng.normal(size=(4, 6))
    G = W @ W.T
    P = effective_matrix(G, G[:, [0, 2]], np.array([0, 2]), np.array([1, 3]))
    inverse = np.linalg.inv(G)[np.ix_([0, 2], [0, 2])]
    np.testing.assert_allclose(P @ inverse, np.eye(2), rtol=0, atol=1e-12 * np.linalg.cond(G))
    assert stability_of(P).kind == Stability.STABLE  # sticking stands on a symmetric positive definite matrix


def test_two_contacts_whose_friction_couples_them_crosswise_flutter(references):
    # G_NN = 1, G_NF = a [[0, 1], [-1, 0]]: P = [[1, -mu a], [mu a, 1]] with eigenvalues 1 +- i mu a, one solution
    make, _, _ = references
    mu, a = 0.5, 0.8
    G = np.eye(4) * [1.0, 2.0, 1.0, 2.0]
    G[0, 3] = G[3, 0] = a
    G[2, 1] = G[1, 2] = -a
    W = np.zeros((4, 6))
    W[:, :4] = np.linalg.cholesky(G)
    template = make(2, "uu")
    weight = np.linalg.lstsq(W, [-1.0, 0.0, -1.0, 0.0], rcond=None)[0]  # b = -1 at both
    values = np.concatenate([W.ravel(), weight, [mu, mu]])
    system = template.with_parameters(**dict(zip(template.parameter_values, values.tolist(), strict=True)))
    u = np.linalg.lstsq(W, [0.0, 1.0, 0.0, 1.0], rcond=None)[0]
    c = ns.classify(system, 0.0, np.ones(6), u)
    (slide,) = c.solutions
    assert slide.modes == ("slide +", "slide +") and c.flags == ns.ParadoxFlag.CONTACT_FLUTTER
    assert np.sort_complex(slide.stability.rho) == pytest.approx([1 - 1j * mu * a, 1 + 1j * mu * a], rel=1e-12)
    y = mu * a
    assert slide.stability.damping == pytest.approx(y**2 / (1 + y**2), rel=1e-12)
    P = np.array([[1.0, -y], [y, 1.0]])
    assert grows(P, math.sqrt(0.8 * slide.stability.damping), 0) and not grows(
        P, math.sqrt(1.25 * y**2 / (1 + y**2)), 0
    )
