"""A declared contact from what was typed: a point at a plane, or a gap and a sliding velocity.

g_N = n.r + offset,    gamma_F = tau.(dr/dt - v_surface),    tau = (n_y, -n_x) in the plane
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import sympy as sp

from nonsmooth.errors import InvalidInput
from nonsmooth.symbolic.expressions import Expressions
from nonsmooth.symbolic.parts import DeclaredContact

DIRECTION_ACCURACY = 1e-12  # chosen: of a typed direction; 1e4 times that of a number


class TypedContact(NamedTuple):
    """The arguments of `Lagrangian.contact` that say where it is and how it slides."""

    point: Any
    normal: Any
    offset: Any
    gap: Any
    tangent: Any
    surface: Any
    slip: Any
    normal_force: Any


def declared_contact(check: Expressions, typed: TypedContact, arguments: str, number: int) -> DeclaredContact:
    """The contact with its expressions checked; ``arguments`` are those of `Contact` as Python."""
    what = f"contact {number}"
    has_friction = "mu=" in arguments
    _require_one_place(typed, what)
    _require_use(typed, what)
    point = () if typed.point is None else check.vector(f"the point of {what}", typed.point, "m")
    gap = _gap(check, typed, point, what, has_friction)
    tangent = _tangent(check, typed, point, what) if has_friction and typed.slip is None else ()
    made = DeclaredContact(
        arguments,
        gap=gap,
        normal_force=_of_state(check, f"the normal force of {what}", typed.normal_force, "N"),
        point=point if tangent else (),
        tangent=tangent,
        surface=_surface(check, typed, what, len(tangent)),
        slip=_of_state(check, f"the slip of {what}", typed.slip, "m/s"),
        place=_place(check, typed, point, tangent, what),
    )
    if has_friction and not made.slides:
        raise InvalidInput(
            f"{what} has friction and needs a sliding velocity: give point= with a normal or tangent, or slip="
        )
    if "normal_force=" in arguments and not has_friction:
        raise InvalidInput(f"{what} has a given normal force and needs friction; give it mu > 0")
    return made


def _require_one_place(typed: TypedContact, what: str) -> None:
    by_plane = typed.normal is not None
    places = [by_plane, typed.gap is not None, typed.normal_force is not None]
    if sum(places) != 1:
        raise InvalidInput(f"{what} needs a point with its normal, a gap, or a normal force: one of the three")
    if by_plane and typed.point is None:
        raise InvalidInput(f"{what} has a normal and needs the point that touches the plane: point=")


def _require_use(typed: TypedContact, what: str) -> None:
    """Nothing that was typed is passed over."""
    if typed.normal is None and not (isinstance(typed.offset, int) and typed.offset == 0):
        raise InvalidInput(f"the offset of {what} belongs to a normal; add it to the gap instead")
    if typed.slip is not None and (typed.tangent is not None or typed.surface is not None):
        raise InvalidInput(f"{what} has a slip, which is all of its sliding, and a tangent or surface: leave one")
    if typed.normal is None and typed.point is not None and typed.tangent is None:
        raise InvalidInput(f"the point of {what} has no use without a normal or a tangent")


def _of_state(check: Expressions, what: str, value: Any, unit: str) -> Any:
    return None if value is None else check.of_state(what, value, unit)


def _gap(check: Expressions, typed: TypedContact, point: tuple[Any, ...], what: str, has_friction: bool) -> Any:
    if typed.normal_force is not None:
        return None
    if typed.gap is not None:
        return check.of_configuration(f"the gap of {what}", typed.gap, "m" if has_friction else "")
    normal = check.vector(f"the normal of {what}", typed.normal)
    if len(normal) != len(point):
        raise InvalidInput(
            f"the normal of {what} has {len(normal)} components, its point {len(point)}: they must agree"
        )
    _require_length_one(check, f"the normal of {what}", normal)
    offset = check.of_configuration(f"the offset of {what}", typed.offset, "m")
    return sp.Add(*(n * r for n, r in zip(normal, point, strict=True)), offset)


def _require_length_one(check: Expressions, what: str, direction: tuple[Any, ...]) -> None:
    """By numbers, at the values of the parameters: to be simplified it might take long."""
    length = math.sqrt(check.sample(sp.Add(*(part * part for part in direction))))
    if not abs(length - 1) <= DIRECTION_ACCURACY:
        raise InvalidInput(f"{what} must have length 1; got {length:g}")


def _tangent(check: Expressions, typed: TypedContact, point: tuple[Any, ...], what: str) -> tuple[Any, ...]:
    if typed.tangent is not None and point:
        tangent = check.vector(f"the tangent of {what}", typed.tangent)
        if len(tangent) != len(point):
            raise InvalidInput(
                f"the tangent of {what} has {len(tangent)} components, its point {len(point)}: they must agree"
            )
        _require_length_one(check, f"the tangent of {what}", tangent)
        _require_perpendicular(check, typed, tangent, what)
        return tangent
    if typed.normal is None:
        return ()
    if len(point) != 2:
        raise InvalidInput(
            f"friction of {what} in space has two directions, which a system does not take; give tangent= for one of "
            "them, or mu=0"
        )
    n_x, n_y = check.vector(f"the normal of {what}", typed.normal)
    return n_y, -n_x


def _place(
    check: Expressions, typed: TypedContact, point: tuple[Any, ...], tangent: tuple[Any, ...], what: str
) -> tuple[Any, ...]:
    """Point, normal and tangent of a contact at a plane, in two dimensions."""
    if len(point) != 2 or typed.normal is None:
        return ()
    normal = check.vector(f"the normal of {what}", typed.normal)
    return *point, *normal, *(tangent or (normal[1], -normal[0]))


def _require_perpendicular(check: Expressions, typed: TypedContact, tangent: tuple[Any, ...], what: str) -> None:
    if typed.normal is not None:
        normal = check.vector(f"the normal of {what}", typed.normal)
        product = check.sample(sp.Add(*(n * tau for n, tau in zip(normal, tangent, strict=True))))
        if not abs(product) <= DIRECTION_ACCURACY:
            raise InvalidInput(f"the tangent of {what} must be perpendicular to its normal; n.tau = {product:g}")


def _surface(check: Expressions, typed: TypedContact, what: str, size: int) -> tuple[Any, ...]:
    if typed.surface is None:
        return (sp.S.Zero,) * size
    surface = check.vector(f"the surface velocity of {what}", typed.surface, "m/s")
    if len(surface) != size:
        raise InvalidInput(
            f"the surface velocity of {what} must have as many components as its point, and needs friction"
        )
    return surface
