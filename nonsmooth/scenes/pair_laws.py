"""What two materials of a scene do to one another: what the pair was given, or the rules of `Material`."""

from __future__ import annotations

from nonsmooth.errors import InvalidInput
from nonsmooth.mechanics.laws import FrictionLaw
from nonsmooth.scenes.elliptic_friction import EllipticFriction
from nonsmooth.scenes.materials import RESISTANCES, Material, of_pair, resistances_by_rule
from nonsmooth.scenes.scene import Scene


def coefficients_of(scene: Scene, a: Material, b: Material) -> tuple[float | FrictionLaw | EllipticFriction, float]:
    """mu, or its law, and e of two materials: those that the pair was given, or by the rule of `Material`."""
    mu, e = of_pair(a, b)
    own_mu, own_e = scene.pairs.get(frozenset((a.name, b.name)), (None, None))
    mu = mu if own_mu is None else own_mu
    if mu is None:
        raise InvalidInput(
            f"{a} and {b} rub by unlike laws, which have no mean; give both a name, and scene.pair(one, other, mu=...)"
        )
    return mu, e if own_e is None else own_e


def resistances_of(scene: Scene, a: Material, b: Material) -> tuple[float, ...]:
    """The ``RESISTANCES`` of two materials: those that the pair was given, or by the rule."""
    own = scene.resistances.get(frozenset((a.name, b.name)), {})
    return tuple(own.get(what, mean) for what, mean in zip(RESISTANCES, resistances_by_rule(a, b), strict=True))


def resistance_in(scene: Scene) -> str:
    """What of ``RESISTANCES`` a contact of a scene may have, or `EllipticFriction`, in words; nothing for none."""
    materials = {id(body.material): body.material for body in scene.bodies}.values()
    if any(isinstance(material.mu, EllipticFriction) for material in materials):
        return "EllipticFriction"
    for a in materials:
        for b in materials:
            *lengths, adhesion = resistances_of(scene, a, b)
            if any(lengths) or adhesion:
                return "rolling or spinning friction" if any(lengths) else "adhesion"
    return ""


def require_known_pairs(scene: Scene) -> None:
    """Raise `InvalidInput` for coefficients of a pair of which no body is made, or two materials of a name."""
    materials: dict[str, set[Material]] = {}
    for body in scene.bodies:
        materials.setdefault(body.material.name, set()).add(body.material)
    for name in sorted(frozenset().union(*scene.pairs, *scene.resistances)):
        if name not in materials:
            raise InvalidInput(f"scene.pair names a material {name!r} that no body is made of")
        if len(materials[name]) > 1:
            first, second = sorted(map(repr, materials[name]))[:2]
            raise InvalidInput(
                f"scene.pair names a material {name!r}, and bodies are made of two, {first} and {second}; give one of "
                "them another name"
            )
