"""Any small planar system by SciPy's solve_ivp: DOP853 between events, the modes after each by trying all.

Of a `System` only the equations are taken, its functions of t, q, u; forces, modes, events and impacts are done here:

    M u' = h + sum_k (W_N la_N + W_F la_F),    closed: gamma_N' = 0,  sticking: gamma_F' = 0,
    sliding: la_F = -s mu(|gamma_F|) sigma la_N

as one linear system in the forces, by least squares where contacts share a load; the rates of the rows are central
differences of order 6. After an event every combination of modes is tried at accelerations, a moment later where the
event is a border of two modes, and one that fits is taken; impacts are solved likewise, with Newton's restitution.
"""

import itertools
import math

import numpy as np
from scipy.integrate import solve_ivp

OPEN, STICK = "open", "stick"
STEP = 2e-4  # s, and m: the difference that gives the rates of rows, exact to 1e-12 at 120 rad/s
SIXTH = ((-3, -1 / 60), (-2, 3 / 20), (-1, -3 / 4), (1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
SLOW = 1e-11  # m/s and m: a velocity or a gap that is none
MOMENT = 1e-7  # s ahead, where modes of a border are decided
LOW = 1e-13  # m: what is left of bounces, v^2/2a, closes
WEAK = 1e-9  # of the largest force
MOST = 40  # impacts at an instant


def coefficient(law, v):
    """mu(v) of a friction law."""
    values = law.coefficients({})
    name = type(law).__name__
    if name == "Coulomb":
        return values[0]
    if name == "StaticKinetic":
        return values[1]
    if name == "Polynomial":
        return values[0] - values[1] * v + values[2] * v**3
    if name == "Stribeck":
        mu_s, mu_k, v_s, delta, m_v = values
        return mu_k + (mu_s - mu_k) * math.exp(-((v / v_s) ** delta)) + m_v * v
    raise NotImplementedError(name)


def static(law):
    return law.coefficients({})[0]


class Equations:
    """The equations of a system, as its functions of t, q, u give them, and the kinds of its contacts."""

    def __init__(self, system):
        self.system, self.n, self.n_c, self.d = system, system.n_q, system.n_c, system.d
        self.kinds = [
            "given" if c.normal_force else "bilateral" if c.bilateral else "unilateral" for c in system.contacts
        ]
        self.laws = [contact.law if contact.has_friction else None for contact in system.contacts]
        self.p = system.unpacked

    def call(self, name, shape, *arguments):
        out = np.zeros(shape)
        function = getattr(self.system, name)
        if function is not None:
            function(*arguments, self.p, out)
        return out

    def gaps(self, t, q):
        return self.call("gap", (self.n_c,), t, q)

    def rows(self, t, q):
        """(2 n_c, n) rows and (2 n_c,) their own velocities, normal and tangential of each contact."""
        W, w = np.zeros((2 * self.n_c, self.n)), np.zeros(2 * self.n_c)
        W[::2], w[::2] = self.call("normal", (self.n_c, self.n), t, q), self.call("gap_rate", (self.n_c,), t, q)
        if self.d:
            W[1::2] = self.call("tangent", (self.n_c, 1, self.n), t, q)[:, 0]
            w[1::2] = self.call("surface_velocity", (self.n_c, 1), t, q)[:, 0]
        return W, w

    def velocities(self, t, q, u):
        W, w = self.rows(t, q)
        return W @ u + w

    def row_rates(self, t, q, u):
        """d/dt of the velocities for constant u."""
        e = STEP / max(1.0, np.abs(u).max())
        return sum(weight * self.velocities(t + k * e, q + k * e * u, u) for k, weight in SIXTH) / e


class Modes(Equations):
    """A system, its contacts and their modes: per contact `OPEN`, `STICK`, or (s, sigma) of a slide."""

    def __init__(self, system):
        super().__init__(system)
        self.e_N = [float(contact.e_N) for contact in system.contacts]
        self.e_F = [float(contact.e_F) for contact in system.contacts]

    def loads(self, t, q, u):
        return np.maximum(self.call("normal_force", (self.n_c,), t, q, u), 0.0)

    def dynamics(self, t, y, modes):
        """(u', forces (n_c, 2), rates of the contact velocities (2 n_c,), size of the terms of these)."""
        q, u = y[: self.n], y[self.n :]
        M, h = self.call("mass", (self.n, self.n), t, q), self.call("force", (self.n,), t, q, u)
        closed = [k for k in range(self.n_c) if modes[k] != OPEN]
        W, w = self.rows(t, q)
        gamma, rates, N = W @ u + w, self.row_rates(t, q, u), self.loads(t, q, u)
        held, directions, names = [], [], []
        for k in closed:
            mode, given = modes[k], self.kinds[k] == "given"
            friction = np.zeros(self.n)
            if mode != STICK and self.laws[k] is not None:
                s, sigma = mode
                mu = coefficient(self.laws[k], max(0.0, s * gamma[2 * k + 1]))
                friction = -s * mu * sigma * W[2 * k + 1]
            if given:
                h = h + friction * N[k]
            else:
                held.append(2 * k)
                directions.append(W[2 * k] + friction)
                names.append((k, 0))
            if mode == STICK and self.laws[k] is not None:
                held.append(2 * k + 1)
                directions.append(W[2 * k + 1])
                names.append((k, 1))
        forces = np.zeros((self.n_c, 2))
        free = np.linalg.solve(M, h)
        size = (np.abs(W) @ np.abs(free) + np.abs(rates)).max(initial=1e-12)
        if held:
            X = np.linalg.solve(M, np.array(directions).T)
            R = W[held]
            x = np.linalg.lstsq(R @ X, -(R @ free + rates[held]), rcond=1e-11)[0]
            free = free + X @ x
            for (k, part), value in zip(names, x, strict=True):
                forces[k, part] = value
        for k in closed:
            if self.kinds[k] == "given":
                forces[k, 0] = N[k]
            if modes[k] != STICK and self.laws[k] is not None:
                s, sigma = modes[k]
                mu = coefficient(self.laws[k], max(0.0, s * gamma[2 * k + 1]))
                forces[k, 1] = -s * mu * sigma * forces[k, 0]
        return free, forces, W @ free + rates, max(size, (np.abs(W) @ np.abs(free)).max(initial=0.0))

    def reserve(self, k, forces):
        return static(self.laws[k]) * abs(forces[k, 0]) - abs(forces[k, 1])

    def functions(self, modes):
        """(Function of (t, y), contact, what ends) of these modes."""
        found = []
        for k, mode in enumerate(modes):
            if mode == OPEN:
                found.append((lambda t, y, k=k: self.gaps(t, y[: self.n])[k], k, "lands"))
                continue
            if self.kinds[k] == "unilateral":
                found.append((lambda t, y, k=k: self.dynamics(t, y, modes)[1][k, 0], k, "border"))
            if self.laws[k] is None:
                continue
            if mode == STICK:
                found.append((lambda t, y, k=k: self.reserve(k, self.dynamics(t, y, modes)[1]), k, "border"))
                continue
            s, sigma = mode
            found.append(
                (lambda t, y, k=k, s=s: s * self.velocities(t, y[: self.n], y[self.n :])[2 * k + 1], k, "rests")
            )
            if self.kinds[k] == "bilateral":
                found.append((lambda t, y, k=k, sigma=sigma: sigma * self.dynamics(t, y, modes)[1][k, 0], k, "border"))
        return found

    def fits(self, t, y, modes, resting):
        """How far the modes (of contacts that touch) are from fitting: 0 if all their inequalities hold."""
        try:
            _, forces, rates, speed = self.dynamics(t, y, modes)
        except np.linalg.LinAlgError:
            return math.inf
        size = max(1e-12, np.abs(forces).max())
        worst = 0.0
        for k in self.touching:
            mode = modes[k]
            if mode == OPEN:
                worst = max(worst, -rates[2 * k] / speed)
                continue
            held = [rates[2 * k]] if self.kinds[k] != "given" else []
            if mode == STICK and self.laws[k] is not None:
                held.append(rates[2 * k + 1])
            worst = max(worst, *(abs(value) / speed for value in held)) if held else worst
            if self.kinds[k] == "unilateral":
                worst = max(worst, -forces[k, 0] / size)
            if self.laws[k] is None:
                continue
            if mode == STICK:
                worst = max(worst, -self.reserve(k, forces) / size)
                continue
            s, sigma = mode
            if self.kinds[k] == "bilateral":
                worst = max(worst, -sigma * forces[k, 0] / size)
            if k in resting:
                worst = max(worst, -s * rates[2 * k + 1] / speed)
        return worst

    def choices(self, k, gamma, resting, was_stuck):
        """The modes that a touching contact may have."""
        signs = (1, -1) if k in resting else (1 if gamma[2 * k + 1] > 0 else -1,)
        if self.laws[k] is None:
            found = [STICK]
        elif self.kinds[k] == "bilateral":
            found = [(s, sigma) for s in signs for sigma in (1, -1)]
        else:
            found = [(s, 1) for s in signs]
        if self.laws[k] is not None and k in resting:
            found = [STICK, *found] if was_stuck else [*found, STICK]
        return [*found, OPEN] if self.kinds[k] == "unilateral" else found

    def decide(self, t, y, resting, later, was_stuck):
        """Modes of the contacts in self.touching at a state; at the state ``later`` the inequalities are asked."""
        t_1, y_1 = later
        gamma = self.velocities(t, y[: self.n], y[self.n :])
        options = [
            self.choices(k, gamma, resting, k in was_stuck) if k in self.touching else [OPEN] for k in range(self.n_c)
        ]
        scored = [
            (self.fits(t_1, y_1, list(modes), resting), i, list(modes))
            for i, modes in enumerate(itertools.product(*options))
        ]
        fitting = [entry for entry in scored if entry[0] < 1e-9]
        best = fitting[0] if fitting else min(scored)
        assert best[0] < 1e-4, f"no modes fit at t = {t}: {best}"
        return best[2]

    def impact(self, t, y):
        """One impact of all contacts that touch, by Newton's law with friction."""
        q, u = y[: self.n], y[self.n :]
        W, w = self.rows(t, q)
        gamma, M = W @ u + w, self.call("mass", (self.n, self.n), t, q)
        touching = [k for k in self.touching if self.kinds[k] != "given"]
        options = []
        for k in touching:
            slides = [1, -1] if self.laws[k] is not None else []
            options.append([*(["free"] if self.kinds[k] == "unilateral" else []), STICK, *slides])
        for modes in itertools.product(*options):
            held, directions, goals = [], [], []
            for k, mode in zip(touching, modes, strict=True):
                if mode == "free":
                    continue
                e = self.e_N[k] if self.kinds[k] == "unilateral" else 0.0
                held.append(2 * k)
                goals.append(-e * min(gamma[2 * k], 0.0) if self.kinds[k] == "unilateral" else 0.0)
                slide = mode in (1, -1)
                mu = coefficient(self.laws[k], abs(gamma[2 * k + 1])) if slide else 0.0
                directions.append(W[2 * k] - (mode * mu if slide else 0.0) * W[2 * k + 1])
                if mode == STICK and self.laws[k] is not None:
                    held.append(2 * k + 1)
                    goals.append(-self.e_F[k] * gamma[2 * k + 1])
                    directions.append(W[2 * k + 1])
            if not held:
                continue
            X = np.linalg.solve(M, np.array(directions).T)
            P = np.linalg.lstsq(W[held] @ X, np.array(goals) - gamma[held], rcond=1e-11)[0]
            after = W @ (u + X @ P) + w
            if self.impact_fits(touching, modes, P, gamma, after, after[held] - goals):
                return np.concatenate([q, u + X @ P])
        raise AssertionError(f"no impulses fit at t = {t}")

    def impact_fits(self, touching, modes, P, gamma, after, missed):
        """Whether impulses P fit their modes; ``missed``: by how much the velocities miss what the modes ask."""
        P, slack = list(P), 1e-11 * (1.0 + np.abs(gamma).max())
        if np.abs(missed).max() > slack:  # of more equations than impulses, by least squares
            return False
        for k, mode in zip(touching, modes, strict=True):
            e = self.e_N[k] if self.kinds[k] == "unilateral" else 0.0
            if mode == "free":
                if after[2 * k] < -e * gamma[2 * k] - slack:
                    return False
                continue
            normal = P.pop(0)
            if self.kinds[k] == "unilateral" and normal < -slack:
                return False
            if mode == STICK and self.laws[k] is not None:
                friction = P.pop(0)
                if abs(friction) > static(self.laws[k]) * abs(normal) + slack:
                    return False
            if mode in (1, -1) and mode * (after[2 * k + 1] + self.e_F[k] * gamma[2 * k + 1]) < -slack:
                return False
        return True

    def after(self, t, y, modes, event):
        """State and modes after an event: impacts, then modes; None is the start."""
        q = y[: self.n]
        gaps, gamma = self.gaps(t, q), self.velocities(t, q, y[self.n :])
        touching = {k for k in range(self.n_c) if self.kinds[k] != "unilateral" or modes[k] != OPEN or gaps[k] <= SLOW}
        is_border = event is not None and event[1] == "border"
        later = (t, y)
        if is_border:
            rates = np.concatenate([y[self.n :], self.dynamics(t, y, modes)[0]])
            later = (t + MOMENT, y + MOMENT * rates)
        resting = {k for k in touching if abs(gamma[2 * k + 1]) < SLOW}
        if event is not None and event[1] == "rests":
            resting.add(event[0])
        for _ in range(MOST):
            gamma = self.velocities(t, q, y[self.n :])
            self.touching = sorted(k for k in touching if self.kinds[k] != "unilateral" or gamma[2 * k] < SLOW)
            if not any(self.kinds[k] != "given" and gamma[2 * k] < -SLOW for k in self.touching):
                break
            y = self.impact(t, y)
            later = (t, y)
            gamma = self.velocities(t, q, y[self.n :])
            resting = {k for k in touching if abs(gamma[2 * k + 1]) < SLOW}
            y = self.drop_bounces(t, y, touching, gamma)
        gamma = self.velocities(t, q, y[self.n :])
        self.touching = sorted(k for k in touching if self.kinds[k] != "unilateral" or gamma[2 * k] < SLOW)
        was_stuck = {
            k
            for k in resting
            if self.laws[k] is not None and (modes[k] == STICK or static(self.laws[k]) > coefficient(self.laws[k], 0.0))
        }
        return y, self.decide(t, y, resting, later, was_stuck)

    def drop_bounces(self, t, y, touching, gamma):
        """Close the contacts whose next bounce is lower than LOW, by an impulse -gamma_N / G with its friction.

        The bounces of speed v would last 2 v / a (1 - e) and take (1 + e) / (1 - e) v / G; held closed for so long the
        contact takes 2 v / G (1 - e), which is v / G more. So the motion after is the same but for the order of v^2.
        """
        a = self.dynamics(t, y, [OPEN] * self.n_c)[0]
        W, _ = self.rows(t, y[: self.n])
        pull = W @ a + self.row_rates(t, y[: self.n], y[self.n :])
        low = [
            k
            for k in touching
            if self.kinds[k] == "unilateral" and 0 < gamma[2 * k] and gamma[2 * k] ** 2 < -2 * LOW * pull[2 * k]
        ]
        if not low:
            return y
        held, directions = self.holding([k for k in sorted(touching) if k in low or abs(gamma[2 * k]) < SLOW], W, gamma)
        X = np.linalg.solve(self.call("mass", (self.n, self.n), t, y[: self.n]), np.array(directions).T)
        P = np.linalg.lstsq(W[held] @ X, gamma[held], rcond=1e-11)[0]
        return np.concatenate([y[: self.n], y[self.n :] - X @ P])

    def holding(self, closed, W, gamma):
        """Rows that contacts stop, and directions of the impulses that do it: what slides has friction -s mu P_N."""
        held, directions = [], []
        for k in closed:
            v, law = gamma[2 * k + 1], self.laws[k]
            rests = law is not None and abs(v) < SLOW
            mu = 0.0 if law is None or rests else math.copysign(coefficient(law, abs(v)), v)
            if self.kinds[k] != "given":
                held.append(2 * k)
                directions.append(W[2 * k] - mu * W[2 * k + 1])
            if rests:
                held.append(2 * k + 1)
                directions.append(W[2 * k + 1])
        return held, directions


def motion(system, q0, u0, times, rtol=1e-13, max_step=np.inf):
    """(Coordinates (m, n_q) at the times (m,), the first of which is the start, number of events)."""
    contacts, n = Modes(system), system.n_q
    t, y, n_events = float(times[0]), np.concatenate([q0, u0]).astype(float), 0
    q = np.zeros((len(times), n))
    q[0] = q0
    start = [OPEN] * contacts.n_c
    y, modes = contacts.after(t, y, start, None)
    while t < times[-1]:
        functions = contacts.functions(modes)
        events = []
        for function, _, _ in functions:
            rising = function(t, y) < 1e-10  # begins at zero: a moment passes before it counts

            def event(s, x, function=function, rising=rising, begin=t):
                value = function(s, x)
                return value + (1e-9 if rising and s - begin < 1e-9 else 0.0)

            event.terminal, event.direction = True, -1.0
            events.append(event)
        rates = lambda s, x, modes=modes: np.concatenate([x[n:], contacts.dynamics(s, x, modes)[0]])
        piece = solve_ivp(rates, (t, times[-1]), y, method="DOP853", rtol=rtol, atol=rtol / 100, events=events or None,
                          dense_output=True, max_step=max_step)  # fmt: skip
        t_1 = piece.t[-1]
        inside = (times > t) & (times <= t_1)
        if inside.any():
            q[inside] = piece.sol(times[inside])[:n].T
        t, y = t_1, piece.y[:, -1]
        which = next((k for k, found in enumerate(piece.t_events or []) if len(found)), None)
        if which is None:
            break
        n_events += 1
        y, modes = contacts.after(t, y, modes, functions[which][1:])
    return q, n_events
