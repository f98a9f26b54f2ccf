"""Scenes in files: TOML, each table a call of a method of `Scene` with the names of its arguments.

    gravity = [0, -9.81]            and material, name, t_end, dt: those of Scene
    include = ["ground.toml"]       tables of other files, first
    [values]                        numbers by name, that formulas use and --set changes
    [[materials]]  [[pairs]]        Material(...), Scene.pair(...)
    [[bodies]]                      kind = "body", "fixed" or "kinematic"; shape = {Box = [0.2, 0.1]}
    [[joints]]                      kind = "joint", "hinge", ...
    [[springs]]  [[forces]]         kind = "spring" or "torsion_spring"; Scene.force(...)
    [[ignored]]                     bodies = ["a", "b"]: Scene.ignore(...)

A text is a formula (formulas.py) but where names belong; a table with repeat = {k = "n"} stands for k = 0, ..., n - 1,
and "{k}" in its names for the number. What a file says is checked where the methods check it, and refused with the
file, the line and the table.
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import itertools
import json
import tomllib
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import nonsmooth.mechanics.laws as laws
import nonsmooth.scenes.shapes as shapes
from nonsmooth.checks.arrays import as_number
from nonsmooth.checks.files import as_path, as_place, whole_file
from nonsmooth.errors import InvalidInput, NotUnderstoodWarning, nearest, shown, warn_caller
from nonsmooth.mechanics.laws import FrictionLaw
from nonsmooth.scenes.elements import Joint, Kind, Motor
from nonsmooth.scenes.elliptic_friction import EllipticFriction
from nonsmooth.scenes.formulas import value_of
from nonsmooth.scenes.heightfields import heightfield
from nonsmooth.scenes.joint_friction import GuideFriction, PinFriction
from nonsmooth.scenes.joint_kinds import JOINT_KINDS
from nonsmooth.scenes.materials import RESISTANCES, Material
from nonsmooth.scenes.scene import Scene
from nonsmooth.scenes.shapes import SPATIAL, Shape

ENDING = ".toml"
FOREIGN = (".xml", ".urdf", ".mjcf")  # endings of files of other programs, in XML
READERS = {"mujoco": "mjcf", "robot": "urdf"}  # the root of such a file: the module that reads it
KINDS = {  # the methods of Scene that the tables of a list call; the first one where a table names none
    "bodies": ("body", "fixed", "kinematic"), "joints": tuple(JOINT_KINDS), "springs": ("spring", "torsion_spring"),
    "forces": ("force",), "pairs": ("pair",), "ignored": ("ignore",),
}  # fmt: skip
OF_JOINTS = {"motors": "motor", "springs": "spring"}  # lists in a table of a joint, and the method that each calls
ORDER = ("materials", *KINDS)
OF_SCENE = ("name", "gravity", "material", "t_end", "dt")
TEXTS = ("name", "kind", "material", "a", "b", "body", "bodies", "impact", "along")  # keys whose texts are names
SHAPES: dict[str, Any] = {
    cls.__name__: cls for cls in vars(shapes).values() if isinstance(cls, type) and issubclass(cls, Shape)
} | {heightfield.__name__: heightfield}
LAWS = {cls.__name__: cls for cls in vars(laws).values() if isinstance(cls, type) and issubclass(cls, FrictionLaw)}
PINS: dict[str, type] = {cls.__name__: cls for cls in (PinFriction, GuideFriction)}
DIRECTED: dict[str, type] = {EllipticFriction.__name__: EllipticFriction}
BUILT = SHAPES | LAWS | PINS | DIRECTED  # what {Name = arguments} makes


class Reader(NamedTuple):
    """Of files of another program."""

    load: Callable[[Path, Mapping[str, float]], tuple[Scene, list[str]]]
    values: Callable[[Path], dict[str, float]]


class Table(NamedTuple):
    """A table of a file."""

    entries: dict[str, Any]
    where: str  # file, list and number, line


def load_scene(path: str | Path, **values: float) -> Scene:
    """The scene of a file, with other values by name."""
    place = as_path("path", path)
    reader = foreign_reader(place)
    if reader is None:
        return load_toml(place, values)
    scene, missed = reader.load(place, {name: as_number(f"value {name}", value) for name, value in values.items()})
    scene.not_understood = tuple(missed)
    if missed:
        warn_caller(f"{place} has what the scene does not: {'; '.join(missed)}", NotUnderstoodWarning)
    return scene


def foreign_reader(place: Path) -> Reader | None:
    """Who reads a file of another program: by its ending and, of XML, by its root; None for TOML."""
    if place.suffix not in FOREIGN:
        return None
    try:
        root = next(iter(ElementTree.iterparse(place, events=("start",))))[1].tag
    except OSError as error:
        raise InvalidInput(f"{place} cannot be read: {error.strerror}") from error
    except (ElementTree.ParseError, StopIteration) as error:
        raise InvalidInput(f"{place} is no XML: {error}") from error
    if root not in READERS:
        raise InvalidInput(f"{place} is no scene: its root must be <mujoco> or, of URDF, <robot>; got <{root}>")
    module = importlib.import_module(f"nonsmooth.scenes.robots.{READERS[root]}")
    return Reader(*(getattr(module, f"{act}_{READERS[root]}") for act in ("load", "values_of")))


def load_toml(place: Path, values: dict[str, float]) -> Scene:
    """The scene of a TOML file."""
    top, tables = _read(place, ())
    own = top.pop("values")
    for name in values:
        if name not in own:
            raise InvalidInput(f"{place} has no value {name}; {nearest(name, [*own])}")
    known = _numbers(place, {**own, **values})
    if unknown := [key for key in top if key not in OF_SCENE]:
        raise InvalidInput(f"{place}: {unknown[0]} is unknown; {nearest(unknown[0], [*OF_SCENE, *ORDER])}")
    scene = _call(Scene, Table(top, str(place)), known, {})
    scene.built_from = known
    materials: dict[str, Material] = {}
    for name in ORDER:
        for table in tables.get(name, []):
            for entries, numbers in _repeated(table, known):
                _add(scene, name, Table(entries, table.where), numbers, materials)
    return scene


def values_in(path: str | Path) -> dict[str, float]:
    """The values of a file, by name."""
    place = as_path("path", path)
    reader = foreign_reader(place)
    return _numbers(place, _read(place, ())[0]["values"]) if reader is None else reader.values(place)


def _read(place: Path, above: tuple[Path, ...]) -> tuple[dict[str, Any], dict[str, list[Table]]]:
    """What stands above the lists of a file, and its lists, with those of the files that it includes."""
    if place.resolve() in above:
        raise InvalidInput(f"{place} includes itself, by {', '.join(map(str, above))}")
    try:
        text = place.read_text(encoding="utf-8")
        found = tomllib.loads(text)
    except OSError as error:
        raise InvalidInput(f"{place} cannot be read: {error.strerror}") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{place} is no TOML: {error}") from error
    top: dict[str, Any] = {}
    lists: dict[str, list[Table]] = {}
    for name in _listed(place, "include", found.pop("include", []), str):
        others, more = _read(place.parent / name, (*above, place.resolve()))
        top |= {**others, "values": {**top.get("values", {}), **others.get("values", {})}}
        for kind, tables in more.items():
            lists.setdefault(kind, []).extend(tables)
    for name in [name for name in ORDER if name in found]:
        for k, entries in enumerate(_listed(place, name, found.pop(name), dict)):
            line = line_of(text, name, k)
            lists.setdefault(name, []).append(Table(entries, f"{place}, {name}[{k}]{line}"))
    own = _listed(place, "values", [found.pop("values", {})], dict)[0]
    return {**top, **found, "values": {**top.get("values", {}), **own}}, lists


def _listed(place: Path, name: str, value: Any, kind: type) -> list[Any]:
    if not isinstance(value, list) or not all(isinstance(one, kind) for one in value):
        raise InvalidInput(
            f"{place}: {name} must be {'tables' if kind is dict else 'a list of texts'}; got {shown(value)}"
        )
    return value


def line_of(text: str, name: str, k: int) -> str:
    """Where the k-th table of a list begins, in words; nothing where it is not written as ``[[name]]``."""
    lines = [number for number, line in enumerate(text.splitlines(), 1) if line.split("#")[0].strip() == f"[[{name}]]"]
    return f" (line {lines[k]})" if k < len(lines) else ""


def _numbers(place: Path, values: Mapping[str, Any]) -> dict[str, float]:
    """The values as numbers, each from those above it."""
    known: dict[str, float] = {}
    for name, value in values.items():
        try:
            known[name] = value_of(value, known) if isinstance(value, str) else float(value)
        except (InvalidInput, TypeError, ValueError) as error:
            raise InvalidInput(f"{place}, values: {name} must be a number or a formula; {error}") from error
    return known


def _repeated(table: Table, known: Mapping[str, float]) -> Iterator[tuple[dict[str, Any], dict[str, float]]]:
    """The table as often as it is to be repeated, each time with the numbers that formulas know."""
    entries = dict(table.entries)
    repeat = entries.pop("repeat", {})
    if not isinstance(repeat, dict):
        raise InvalidInput(f"{table.where}: repeat must be a table of counts, as {{k = 10}}; got {shown(repeat)}")
    counts = [range(_count(table, name, count, known)) for name, count in repeat.items()]
    for numbers in itertools.product(*counts):
        yield entries, {**known, **dict(zip(repeat, numbers, strict=True))}


def _count(table: Table, name: str, count: Any, known: Mapping[str, float]) -> int:
    number = value_of(count, known) if isinstance(count, str) else count
    if not isinstance(number, int | float) or number != int(number) or number < 0:
        raise InvalidInput(f"{table.where}: {name} is repeated a whole number of times; got {shown(count)}")
    return int(number)


def _add(scene: Scene, name: str, table: Table, numbers: dict[str, float], materials: dict[str, Material]) -> None:
    """Add what a table of a list describes."""
    if name == "materials":
        made = _call(Material, table, numbers, {})
        materials[made.name] = made
        return
    if name == "ignored":
        _call(lambda bodies: scene.ignore(*bodies), table, numbers, materials)
        return
    entries = dict(table.entries)
    methods = KINDS[name]
    kind = entries.pop("kind", methods[0])
    if kind not in methods:
        raise InvalidInput(f"{table.where}: kind {shown(kind)} is unknown; {nearest(str(kind), [*methods])}")
    parts = {key: entries.pop(key, []) if name == "joints" else [] for key in OF_JOINTS}
    joint = _call(getattr(scene, kind), Table(entries, table.where), numbers, materials)
    for key, method in OF_JOINTS.items():
        for part in parts[key]:
            _call(getattr(joint, method), Table(part, f"{table.where}, {key}"), numbers, materials)


def _call(act: Any, table: Table, numbers: Mapping[str, float], materials: Mapping[str, Material]) -> Any:
    """Call what a table stands for with its entries."""
    try:
        require_arguments(act, table.entries)
        return act(**{key: _made(key, value, numbers, materials) for key, value in table.entries.items()})
    except InvalidInput as refusal:
        raise InvalidInput(f"{table.where}: {refusal}") from refusal


def require_arguments(act: Any, entries: Mapping[str, Any]) -> None:
    """Raise `InvalidInput` for an entry that is no argument, and for one that is missing."""
    taken = inspect.signature(act).parameters
    for key in entries:
        if key not in taken:
            raise InvalidInput(f"there is no {key} here; {nearest(key, [*taken])}")
    for key, one in taken.items():
        if one.default is inspect.Parameter.empty and key not in entries and one.kind is not one.VAR_POSITIONAL:
            raise InvalidInput(f"{key} is missing")


def _made(key: str, value: Any, numbers: Mapping[str, float], materials: Mapping[str, Material]) -> Any:
    """An entry as an argument."""
    match value:
        case str() if key == "material":
            if value not in materials:
                raise InvalidInput(f"there is no material {shown(value)}; {nearest(value, [*materials])}")
            return materials[value]
        case str() if key in TEXTS:
            return _named(value, numbers)
        case str():
            return value_of(value, numbers)
        case dict() if key == "material":
            return _call_plain(Material, value, numbers)
        case dict():
            return _built(key, value, numbers)
        case list():
            return [_made(key, one, numbers, materials) for one in value]
    return value


def _named(text: str, numbers: Mapping[str, float]) -> str:
    """A name, with the numbers in its braces."""
    try:
        return text.format(**{k: f"{v:g}" if isinstance(v, float) else str(v) for k, v in numbers.items()})
    except (KeyError, IndexError, ValueError) as error:
        raise InvalidInput(f"the name {shown(text)} has braces about what is no number: {error}") from error


def _built(key: str, value: dict[str, Any], numbers: Mapping[str, float]) -> Any:
    """A shape, a law of friction, or that of a joint, as {Name = arguments}: one, a list of them, or by name."""
    if len(value) != 1:
        raise InvalidInput(f"{key} must be one {{Name = arguments}}; got {shown(value)}")
    ((name, arguments),) = value.items()
    if name not in BUILT:
        raise InvalidInput(f"{key} {name} is unknown; {nearest(name, [*BUILT])}")
    if isinstance(arguments, dict):
        return _call_plain(BUILT[name], arguments, numbers)
    listed = arguments if isinstance(arguments, list) else [arguments]
    try:
        return BUILT[name](*(_made(key, one, numbers, {}) for one in listed))
    except TypeError as error:
        raise InvalidInput(f"{key} {name} takes {', '.join(inspect.signature(BUILT[name]).parameters)}") from error


def _call_plain(act: Any, entries: dict[str, Any], numbers: Mapping[str, float]) -> Any:
    require_arguments(act, entries)
    return act(**{key: _made(key, value, numbers, {}) for key, value in entries.items()})


def save_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene into a file, number by number."""
    place = as_place("path", path, (ENDING,))
    blocks = [_lines({"name": scene.name or None, "gravity": scene.gravity, "t_end": scene.t_end, "dt": scene.dt,
                      "material": _material(scene.material)})]  # fmt: skip
    named = {body.material.name: body.material for body in scene.bodies if body.material.name}
    blocks += [f"[[materials]]\n{_lines(_material(material))}" for material in named.values()]
    blocks += [f"[[bodies]]\n{_lines(_body(scene, body))}" for body in scene.bodies]
    blocks += [f"[[joints]]\n{_lines(_joint(scene, joint))}" for joint in scene.joints]
    blocks += [f"[[springs]]\n{_lines(_spring(spring))}" for spring in scene.springs]
    blocks += [f"[[forces]]\n{_lines(_force(force))}" for force in scene.forces]
    for names in dict.fromkeys((*scene.pairs, *scene.resistances)):
        (a, b), (mu, e) = (*names, *names)[:2], scene.pairs.get(names, (None, None))
        own = {"a": a, "b": b, "mu": mu, "e": e, **scene.resistances.get(names, {})}
        blocks.append(f"[[pairs]]\n{_lines(own)}")
    blocks += [f"[[ignored]]\n{_lines({'bodies': [a.name, b.name]})}" for a, b in scene.ignored]
    with whole_file(place) as part:
        part.write_text("\n\n".join(blocks) + "\n", encoding="utf-8")


def _lines(entries: Mapping[str, Any]) -> str:
    """Entries of a table, but those that are None."""
    return "\n".join(f"{key} = {_text(value)}" for key, value in entries.items() if value is not None)


def _text(value: Any) -> str:
    """A value in TOML."""
    match value:
        case Shape():
            return _text({type(value).__name__: _arguments(value)})
        case FrictionLaw() | PinFriction() | GuideFriction() | EllipticFriction():
            return _text({type(value).__name__: {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}})
        case dict():
            inner = ", ".join(f"{key} = {_text(one)}" for key, one in value.items() if one is not None)
            return f"{{{inner}}}"
        case np.ndarray():
            return _text(value.tolist())
        case list() | tuple():
            return f"[{', '.join(map(_text, value))}]"
        case str() | bool():
            return json.dumps(value, ensure_ascii=False)
        case int() | float():
            return repr(float(value)) if isinstance(value, float | np.floating) else str(value)
    raise InvalidInput(f"a file holds numbers and names, and the scene has {shown(value)}")


def _arguments(shape: Shape) -> list[Any]:
    """Those that make a shape again."""
    match shape:
        case shapes.Box():
            return [*shape.lengths]
        case shapes.Compound():
            return [*shape.parts]
        case shapes.Polyhedron():
            return [shape.vertices]
    return [getattr(shape, f.name) for f in dataclasses.fields(shape)]  # type: ignore[arg-type]


def _material(material: Material) -> dict[str, Any]:
    others = {what: getattr(material, what) or None for what in RESISTANCES}
    return {"name": material.name or None, "mu": material.mu, "e": material.e, "impact": material.impact, **others}


def _body(scene: Scene, body: Any) -> dict[str, Any]:
    """The arguments of the method that adds it."""
    if body.motion is not None:
        raise InvalidInput(f"a file holds numbers and names, and {body.name} moves as a function says")
    kind = {Kind.DYNAMIC: "body", Kind.FIXED: "fixed", Kind.KINEMATIC: "kinematic"}[body.kind]
    material = None if body.material is scene.material else body.material.name or _material(body.material)
    moves = {} if body.kind is Kind.FIXED else {"velocity": body.velocity, "spin": body.spin}
    return {
        "kind": kind, "name": body.name, "shape": body.shape, "position": body.position, "turn": body.turn, **moves,
        "mass": body.mass, "density": body.density, "inertia": body.inertia, "centre": body.centre,
        "material": material, "surface_velocity": body.surface_velocity,
    }  # fmt: skip


def _joint(scene: Scene, joint: Joint) -> dict[str, Any]:
    bodies = {"kind": joint.kind, "name": joint.name, "a": joint.a.name, "b": joint.b.name}
    if joint.is_tie:
        own = {"length": joint.length, "e": joint.e or None} if joint.kind == "rope" else {}
        return {**bodies, "at_a": joint.at, "at_b": joint.at_b, **own}
    has_axis = joint.kind not in ("joint", "fix") and (scene.dim == SPATIAL or joint.kind != "hinge")
    along = "travel" if joint.kind != "hinge" else "angle"
    return {
        **bodies, "at": joint.at,
        "axis": joint.axes[0] if has_axis else None,
        "axis_b": joint.axes_b[0] if joint.kind == "universal" else None,
        "limits": joint.limits.get(along),
        "angle_limits": joint.limits.get("angle") if joint.kind == "cylindrical" else None,
        "e": joint.e or None, "friction": joint.friction,
        "motors": [_motor(joint, motor) for motor in joint.motors] or None,
        "springs": [dataclasses.asdict(spring) for spring in joint.springs] or None,
    }  # fmt: skip


def _motor(joint: Joint, motor: Motor) -> dict[str, Any]:
    if callable(motor.load) or callable(motor.speed):
        raise InvalidInput(f"a file holds numbers and names, and a motor of {joint.name} is a function")
    if motor.speed is not None:
        return {"speed": motor.speed, "limit": motor.limit}
    return {"torque" if motor.along == "angle" else "force": motor.load}


def _spring(spring: Any) -> dict[str, Any]:
    own = {"kind": "torsion_spring" if spring.is_torsion else "spring", "name": spring.name, "a": spring.a.name}
    ends = {} if spring.is_torsion else {"at_a": spring.at_a, "at_b": spring.at_b}
    length = {"angle" if spring.is_torsion else "length": spring.length}
    return {**own, "b": spring.b.name, **ends, "stiffness": spring.stiffness, "damping": spring.damping, **length}


def _force(force: Any) -> dict[str, Any]:
    if callable(force.value):
        raise InvalidInput(f"a file holds numbers and names, and the force on {force.body.name} is a function")
    return {"body": force.body.name, "value": force.value, "at": force.at}
