"""The figures of docs/penalty.md: ``python docs/figures/penalty.py [FOLDER]``."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np

import nonsmooth as ns
from nonsmooth.catalogue import BouncingBall, BoxStack, MasonryArch, PainleveRod, SpragSlip
from nonsmooth.drawing.colours import BLUE, GREY, RED, cycled
from nonsmooth.drawing.labels import LETTER, legend_above
from nonsmooth.drawing.paradox_plots import plot_map
from nonsmooth.drawing.plots import WIDTH, new_figure, save_figure
from nonsmooth.drawing.study_plots import draw_errors

TH = math.pi / 3
TITLE_PAD = 44.0  # points between a panel and its title, where the legend stands
STARTS = [(0.60, 0.0), (0.85, 0.0), (0.90, 2.0), (0.80, 3.5), (1.00, 4.0), (0.78, 1.0), (0.73, 3.3)]


def regular_contact(folder: Path) -> None:
    """Slip, stick and slip of the rod: first order."""
    rod = PainleveRod(mu=1.0)
    start = rod.state(th=math.radians(75), thdot=-0.5, slip=-0.5)
    ns.penalty_study(rod, (0, 0.7), *start, stiffness=np.logspace(4, 9, 11), damping_ratio=1.0, times=[0.3, 0.7]).plot(
        folder / "penalty_regular.png"
    )


def bounces(folder: Path) -> None:
    """An elastic ball on a spring: late, and right after each bounce."""
    ball = BouncingBall(e=1.0)
    ns.penalty_study(ball, (0, 2.0), *ball.state(height=1.0), stiffness=np.logspace(4, 10, 7)).plot(
        folder / "penalty_bounces.png"
    )


def seizure(folder: Path) -> None:
    """A seizure of the sprag-slip rod: ln k/k."""
    rod = SpragSlip()
    ns.penalty_study(
        rod, (0, 0.4), *rod.state(th=0.78, thdot=1.0), stiffness=np.logspace(4, 9, 11), damping=lambda k: k,
        times=[0.1, 0.4],
    ).plot(folder / "penalty_seizure.png")  # fmt: skip


def restitution(folder: Path) -> None:
    """Impact without collision: velocity against k for some damping ratios, and the effective restitution."""
    figure = new_figure(WIDTH, 6.2)
    left, right = figure.subplots(2, 1)
    rod = PainleveRod(mu=2.0)
    k = np.logspace(5, 12, 15)
    elastic = rod.impact_without_collision(th=TH, e=1.0, law="energetic").gamma_N
    for j, zeta in enumerate((0.0, 0.1, 0.5, 1.0)):
        colour, _, marker = cycled(j)
        limit = rod.compliant_limit(th=TH, zeta=zeta).gamma_N
        penalty = ns.Penalty(1.0, damping_ratio=zeta, mass=rod.m, rtol=1e-10, atol=1e-12)
        study = ns.penalty_study(
            rod, (0, 0.02), *rod.state(th=TH, slip=-1.0), stiffness=k, damping_ratio=zeta, penalty=penalty, limit=limit,
            reference=([[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.0]]), beside=[],
        )  # fmt: skip
        left.loglog(k, study.errors("error_gamma_N"), marker + "-", ms=4, lw=1, color=colour,
                    label=f"$\\zeta={zeta:g}$")  # fmt: skip
    left.loglog(k, 3 * k**-0.5 * np.log(k), ":", color=GREY, label="$\\propto k^{-1/2}\\,\\ln k$")
    left.set(xlabel="stiffness $k$ [N/m]", ylabel="$|\\gamma_N^+ -$ limit$|$ [m/s]")
    legend_above(left)
    zetas = np.concatenate(([0.0], np.linspace(0.02, 2.0, 60)))
    for j, mu in enumerate((1.5, 2.0, 3.0)):
        colour, style, _ = cycled(j)
        other = PainleveRod(mu=mu)
        whole = other.impact_without_collision(th=TH, e=1.0, law="energetic").gamma_N
        e = [other.compliant_limit(th=TH, zeta=zeta).gamma_N / whole for zeta in zetas]
        right.plot(zetas, e, style, color=colour, label=f"impact without collision, $\\mu={mu:g}$")
    bounce = [math.exp(-2 * z * (math.acos(z) if z < 1 else math.acosh(z)) / math.sqrt(abs(1 - z * z)))
              if z != 1 else math.exp(-2) for z in zetas]  # fmt: skip
    right.plot(zetas, bounce, "-", color=GREY, label="ordinary collision, frictionless")
    right.set(
        xlabel="damping ratio $\\zeta$ [-]",
        ylabel="effective energetic\nrestitution $e$ [-]",
        ylim=(0, 1.03),
        xlim=(0, 2),
    )
    right.legend(fontsize=LETTER, frameon=False)
    assert abs(elastic - 0.255296505) < 1e-9
    figure.savefig(folder / "penalty_restitution.png", dpi=150)


def branches(folder: Path) -> None:
    """The saddle of an indeterminate state: below it the contact opens, beyond it it seizes."""
    figure = new_figure(WIDTH, 6.2)
    left, right = figure.subplots(2, 1)
    rod, k, k_t = PainleveRod(mu=2.0), 1e10, 1e5
    slide = rod.normal_forces(th=TH, thdot=6.0, slip=-1.0)[1]
    for share in (0.5, 0.9, 0.99, 1.0, 1.01, 1.1, 1.5):
        q0, u0 = rod.state(th=TH, thdot=6.0, slip=-1.0)
        q0[1] -= share * slide / k
        sol = ns.simulate(rod, (0, 2.5e-4), q0, u0, integrator=ns.Penalty(k, rtol=1e-10, atol=1e-12))
        colour = RED if any(e.mode_after == ns.ContactMode.STICK for e in sol.events) else BLUE
        left.plot(k_t * sol.t[1:], sol.la[1:, 0, 0] / slide, color=colour, lw=1.2)
    left.axhline(1.0, color=GREY, lw=0.8, ls=":")
    left.set(
        xlabel="$\\sqrt{k/m}\\;t$ [-]", ylabel="normal force over\nthat of sliding [-]", xlim=(0, 12), ylim=(-0.1, 4)
    )
    left.plot([], [], color=BLUE, label="lifts off")
    left.plot([], [], color=RED, label="impact without collision")
    left.legend(fontsize=LETTER, frameon=False)
    ks = np.logspace(6, 11, 11)
    right.loglog(ks, [threshold(rod, value, slide) - 1 for value in ks], "o-", color=BLUE, ms=4, lw=1)
    right.loglog(ks, 60 * ks**-0.5, ":", color=GREY, label="$\\propto k^{-1/2}$")
    right.set(xlabel="stiffness $k$ [N/m]", ylabel="$N_0/N^* - 1$ at the threshold [-]")
    right.legend(fontsize=LETTER, frameon=False)
    figure.savefig(folder / "penalty_branches.png", dpi=150)


def threshold(rod: PainleveRod, k: float, slide: float) -> float:
    """The initial force, over that of sliding, between lift-off and an impact, by bisection."""
    low, high = 1.0, 1.5
    while high - low > 1e-8:
        share = 0.5 * (low + high)
        q0, u0 = rod.state(th=TH, thdot=6.0, slip=-1.0)
        q0[1] -= share * slide / k
        sol = ns.simulate(rod, (0, 200 / math.sqrt(k)), q0, u0, integrator=ns.Penalty(k, rtol=1e-10, atol=1e-12))
        seizes = any(e.mode_after == ns.ContactMode.STICK for e in sol.events)
        low, high = (low, share) if seizes else (share, high)
    return high


def over_the_regions(folder: Path) -> None:
    """The seven compliant motions over the regions of the rigid problem."""
    rod = SpragSlip()
    axes = {"th": np.linspace(0.55, 1.25, 601), "thdot": np.linspace(-3.5, 4.5, 601)}
    code = rod.region(*np.meshgrid(*axes.values(), indexing="ij"))
    chart = ns.paradox_map(rod, **axes)
    motions = []
    for th, thdot in STARTS:
        penalty = ns.Penalty(stiffness=1e6, damping=1e6)
        sol = ns.simulate(rod, (0.0, 0.4), *rod.state(th=th, thdot=thdot), integrator=penalty)
        motions.append(np.column_stack([sol.q[:, 1], sol.u[:, 1]]))
    plot_map(
        chart, folder / "penalty_over_regions.png", motions=motions,
        boundaries=ns.paradox_boundaries(rod, **{name: values[::10] for name, values in axes.items()}),
        regions=(code, lambda k: f"$A_{k}$: {chart.n_solutions.values[code == k].max()}"),
        title="sprag-slip rod, compliant contact $k_c = c_c = 10^6$: seven motions of 0.4 s over the rigid regions",
    )  # fmt: skip


def scenes(folder: Path) -> None:
    """A stack and an arch on springs, against their rigid contacts."""
    figure = new_figure(WIDTH, 7.2)
    motions = (BoxStack(n=5, dim=2), 0.5, "boxes"), (MasonryArch(n=15, ratio=0.15), 0.2, "stones")
    for axes, (model, t_end, what) in zip(figure.subplots(2, 1), motions, strict=True):
        study = ns.penalty_study(model, (0, t_end), stiffness=np.logspace(7, 11, 5), beside=[])
        print(study.table())
        draw_errors(axes, study)
        axes.set_title(f"{model.name}, {model.n} {what}", fontsize=9, pad=TITLE_PAD)
    save_figure(figure, folder / "penalty_scenes.png")


def main(folder: Path) -> None:
    """Draw all of them."""
    folder.mkdir(parents=True, exist_ok=True)
    for draw in (regular_contact, bounces, seizure, restitution, branches, over_the_regions, scenes):
        draw(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
