"""The figures of docs/theory/painleve_in_space.md: ``python docs/figures/paradoxes_in_space.py [FOLDER]``."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import nonsmooth as ns
from models.spatial_painleve_rod import SpatialRodImpact
from nonsmooth.catalogue import SpatialPainleveRod

ROD = SpatialPainleveRod(mu=2.0)
UNIT = math.sqrt(ROD.g / (0.5 * ROD.l))  # rad/s
AXES = {
    "th": np.linspace(0.02, math.pi / 2 - 0.02, 481),
    "phi": np.linspace(-1.3, 1.3, 481),
    "psidot": np.linspace(0.0, 6.2 * UNIT, 481),
}


def mapped(names: tuple[str, str], title: str, **held: float) -> plt.Figure:
    """A plane of the rod's states, with the zero curves of p and b."""
    axes = {name: AXES[name] for name in names}
    coarse = {name: values[::8] for name, values in axes.items()}
    curves = ns.paradox_boundaries(ROD, **coarse, **held)
    return ns.plot_map(ns.paradox_map(ROD, **axes, **held), boundaries=curves, title=title)


def elevation_and_azimuth(folder: Path) -> None:
    """Numbers of solutions where the tip drags obliquely, at a spin above Psi_c."""
    figure = mapped(("th", "phi"), f"ψ' = 2 √(g/s): paradoxes for |φ| < φ_max, μ = {ROD.mu:g}", psidot=2 * UNIT)
    phi_max = math.degrees(ROD.critical_azimuth())
    figure.axes[0].annotate(
        f"φ_max = {phi_max:.4f}°", (ROD.least_critical_friction()[1], ROD.critical_azimuth()), (-60, 14),
        textcoords="offset points", fontsize=9, arrowprops={"arrowstyle": "->"},
    )  # fmt: skip
    figure.savefig(folder / "space_th_phi.png", dpi=150)


def elevation_and_spin(folder: Path) -> None:
    """The tip drags ahead: the spin alone lifts it above Psi_c, and p = b = 0 at Psi_1 and Psi_2."""
    figure = mapped(("th", "psidot"), f"φ = 0, θ' = 0: the spins Ψ_c, Ψ_1, Ψ_2, μ = {ROD.mu:g}", phi=0.0)
    spin, th = ROD.least_lift_off_spin()
    figure.axes[0].plot(th, spin, "ko", ms=4)
    at = zip(ROD.paradoxical_angles(), ROD.critical_spins(), strict=True)
    for name, (x, y), offset in zip(("Ψ_c", "Ψ_1", "Ψ_2"), ((th, spin), *at), (-50, 60, 22), strict=True):
        figure.axes[0].annotate(f"{name} = {y / UNIT:.4f} √(g/s)", (x, y), (-104, offset),
                                textcoords="offset points", fontsize=9, arrowprops={"arrowstyle": "->"})  # fmt: skip
    figure.savefig(folder / "space_th_spin.png", dpi=150)


def azimuth_and_spin(folder: Path) -> None:
    """At one elevation both curves are straight."""
    figure = mapped(("phi", "psidot"), f"θ = 1 rad: both curves are straight, μ = {ROD.mu:g}", th=1.0)
    figure.savefig(folder / "space_phi_spin.png", dpi=150)


def genot_brogliato_surface(folder: Path) -> None:
    """theta' of p = b = 0 over azimuth and spin, for th_1 and th_2."""
    figure = plt.figure(figsize=(7.0, 5.0), layout="constrained")
    axes = figure.add_subplot(projection="3d")
    phi = np.linspace(-ROD.critical_azimuth(), ROD.critical_azimuth(), 121)
    for sheet, colour in ((0, "C0"), (1, "C1")):
        angles = [(ROD.paradoxical_angles(x) or 2 * (ROD.least_critical_friction()[1],))[sheet] for x in phi]
        part = np.linspace(0.0, 1.0, 61)  # of the spin at which theta' = 0
        spins = np.array([ROD.lift_off_spin(th) * part for th in angles]).T
        rates = np.array([[ROD.genot_brogliato_rate(th, psi * (1 - 1e-12)) for th, psi in zip(angles, row, strict=True)]
                          for row in spins])  # fmt: skip
        azimuths = np.broadcast_to(phi, spins.shape)
        axes.plot_surface(azimuths, spins / UNIT, rates / UNIT, color=colour, alpha=0.6, lw=0, rstride=2, cstride=2)
        axes.plot([], [], color=colour, lw=6, label=f"θ = θ_{sheet + 1}(φ)")
    axes.set(xlabel="φ [rad]", ylabel="ψ' / √(g/s)", zlabel="θ' / √(g/s)", title=f"p = b = 0, μ = {ROD.mu:g}")
    axes.set_xticks([-0.8, -0.4, 0.0, 0.4, 0.8])
    axes.view_init(34, -35)
    axes.legend(loc="upper left", fontsize=8)
    figure.savefig(folder / "space_genot_brogliato.png", dpi=150)


def impacts(folder: Path) -> None:
    """How the sliding velocity turns in an impact without collision, and how fast the tip leaves."""
    figure, (plane, exits) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
    th = ROD.least_critical_friction()[1]
    for phi in np.radians([-45, -30, -15, 0, 15, 30, 45]):
        path = ROD.impact_without_collision(th, phi, e=1.0, law="energetic").path
        plane.plot(path[:, 2], path[:, 3], lw=1.2)
        plane.plot([path[0, 2], 0.0], [path[0, 3], 0.0], color="0.6", lw=0.6, ls=":", zorder=0)
        plane.plot(*path[0, 2:], "ko", ms=3)
    plane.set(
        xlabel="γ_F along h [m/s]", ylabel="γ_F across [m/s]", title=f"the slide turns, θ = {math.degrees(th):.1f}°"
    )
    azimuths = np.linspace(-0.9999, 0.9999, 161) * ROD.critical_azimuth(th)
    for law, style in (("poisson", "--"), ("energetic", "-")):
        speeds = [ROD.impact_without_collision(th, phi, e=1.0, law=law).gamma_N for phi in azimuths]
        exits.plot(np.degrees(azimuths), speeds, style, label=f"{law}, e = 1")
    exits.set(xlabel="φ [°]", ylabel="γ_N after the impact [m/s]", title="the tip leaves, slip 1 m/s")
    exits.legend(fontsize=9)
    figure.savefig(folder / "space_impacts.png", dpi=150)


def compliant_limit(folder: Path) -> None:
    """How springs stop a slide without a rigid solution, and how far from the energetic impact they end."""
    figure, (plane, errors) = plt.subplots(1, 2, figsize=(9.0, 4.2), layout="constrained")
    for phi in np.radians([-45, -30, -15, 0, 15, 30, 45]):
        _, sol, last = sprung(1e4, phi)
        plane.plot(*sol.gamma_F[: last + 1, 0].T, lw=2.4, alpha=0.5)
        plane.plot(*energetic(phi).path[:, 2:].T, "k--", lw=0.8)
    plane.set(xlabel="γ_F along x [m/s]", ylabel="γ_F along y [m/s]", title="the slide stops: k = 10⁴ N/m, and limit")
    stiffness = np.logspace(3, 12, 10)
    wrong = [sprung(float(k), 0.4)[0] for k in stiffness]
    errors.loglog(stiffness, wrong, "o-", ms=4, label="max |u - u of the limit|")
    scale = wrong[-1] / (math.log(stiffness[-1]) / math.sqrt(stiffness[-1]))
    errors.loglog(stiffness, scale * np.log(stiffness) / np.sqrt(stiffness), "k:", lw=1.0, label="ln k/√k")
    errors.set(xlabel="k [N/m]", ylabel="error [m/s, rad/s]", title="after the impact, φ = 23°")
    errors.legend(fontsize=9)
    figure.savefig(folder / "space_compliant_limit.png", dpi=150)


def energetic(phi: float) -> SpatialRodImpact:
    """The impact of the rod at th = 1 that gives back the work it took."""
    return ROD.impact_without_collision(1.0, phi, slip=1.0, e=1.0, law="energetic")


def sprung(k: float, phi: float) -> tuple[float, ns.Solution, int]:
    """The error of the velocities after that impact by springs, its run, and the record at which the tip leaves."""
    start = ROD.state(1.0, phi, slip=1.0)
    sol = ns.simulate(ROD, (0, 30 / math.sqrt(k)), *start, integrator=ns.Penalty(k, rtol=1e-10, atol=1e-12))
    end = next(event.t for event in sol.events if event.mode_after == ns.ContactMode.OPEN)
    last = int(np.searchsorted(sol.t, end))
    return float(np.abs(sol.u[last] - energetic(phi).u).max()), sol, last


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    folder.mkdir(parents=True, exist_ok=True)
    maps = elevation_and_azimuth, elevation_and_spin, azimuth_and_spin, genot_brogliato_surface
    for figure in (*maps, impacts, compliant_limit):
        figure(folder)


if __name__ == "__main__":
    main()
