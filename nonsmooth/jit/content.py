"""The content of whatever can be called or kept: what a later process must find again to go on with numbers.

Machine code is made of less (`fingerprint`). To what stands there comes

    lists, dicts, sets, arrays     their entries; numpy's words for a long array leave most of it out
    partials, methods              what they call, and what they hand on
    objects                        their class, attributes and slots; what a library says of its own to copy them
    classes                        their methods, properties and attributes, and those of the classes below them
    installed packages             the name, and the version

What a function of a library answers may change though nobody changed the program: that of a file, of the environment,
of numpy's one generator. Whoever reads such a thing, a module of the user's that is handed on, or an object that cannot
be copied has no identity, and `Unidentified` says why. A text ``nonsmooth_version`` of a function, a class or an object
stands for all that it reads.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import importlib.metadata
import inspect
import re
import sys
import types
from collections.abc import Iterator
from typing import Any

import numpy as np

from nonsmooth.jit.bytecode import mentioned
from nonsmooth.jit.fingerprint import Survey, Unidentified
from nonsmooth.jit.libraries import is_installed, is_library

VERSION = "nonsmooth_version"  # code: the attribute that stands for what an object reads
CURE = (
    "Read numbers, texts, arrays, lists or objects of your own, or give what reads it a text that you change with it: "
    f'f.{VERSION} = "1"'
)

# Of Python's own modules, those that answer the same whatever stands on the disk, or in the environment.
PURE = set(
    "abc array base64 bisect builtins calendar cmath collections contextlib copy copyreg dataclasses datetime decimal "
    "enum fractions functools gc hashlib heapq itertools json logging math ntpath numbers operator pathlib posixpath "
    "pprint queue re shutil signal statistics string struct tempfile textwrap threading traceback types typing uuid "
    "unicodedata warnings weakref zlib".split()
)
PURE_NAMES = set(
    "builtins.open io.open io.BytesIO io.StringIO os.fspath os.fsync os.getpid os.kill os.makedirs os.mkdir os.remove "
    "os.replace os.unlink random.Random sys.stderr sys.stdout time.perf_counter time.perf_counter_ns time.monotonic "
    "time.process_time time.sleep time.thread_time".split()
)
OUTSIDE = {"h5py", "httpx", "netCDF4", "requests", "sqlalchemy", "zarr"}  # packages that are there to read something
OF_THE_PROGRAM = {f"builtins.{name}" for name in "input eval exec compile globals locals vars __import__".split()}
WHY = "whose answers depend on more than the program"
ON_DEMAND = {
    "builtins.open": "io",
    "io.open": "io",
    "pathlib": "pathlib",
    "datetime": "datetime",
}  # what reads if asked
ANSWERS = re.compile(
    "open|(im)?read(?!y)|load(?!s$)|scan_|from_?(file|txt|csv)|genfromtxt|memmap|now$|today$|utcnow|exists$|is_(file|dir)"
    "|isfile|isdir|iterdir|r?glob$|l?stat$|listdir|scandir|walk$|get(mtime|size)$|home$|cwd$"
)
NUMPYS_GENERATOR = re.compile(r"numpy\.random\.(mtrand\.)?[a-z](?!efault_rng)\w*$")  # its functions, not its classes


def identity(*values: Any) -> bytes:
    """A hash that is equal for values of equal content, in every process.

    Raises
    ------
    Unidentified
        Where something that is read cannot be distinguished from another one.
    """
    content, name = Content(owners(*values)), ""
    try:
        for value in values:
            name = _name_of(value)
            content.value(value, name)
        content.require_told()
    except Unidentified as reason:
        raise Unidentified(f"{name} reads {reason}") from None
    except RecursionError:
        raise Unidentified(f"{name} reads what is nested too deeply") from None
    return content.digest()


def owners(*values: Any) -> frozenset[str]:
    """The packages that functions and objects are of: their sources are looked at, wherever they are installed."""
    homes = {getattr(_innermost(value), "__module__", None) or "" for value in values}
    tops = {str(home).partition(".")[0] for home in homes}
    return frozenset(top for top in tops if top not in sys.stdlib_module_names | {"numpy", "nonsmooth", ""})


def _innermost(value: Any) -> Any:
    while isinstance(value, functools.partial):
        value = value.func
    return value


def _name_of(value: Any) -> str:
    return str(getattr(_innermost(value), "__name__", None) or f"a {type(value).__name__}")


class Content(Survey):
    """A hash of values, however deep.

    Parameters
    ----------
    own : set of str
        Packages whose sources are looked at.
    """

    def __init__(self, own: frozenset[str] = frozenset()) -> None:
        super().__init__()
        self._own = own
        self._failed: dict[int, str] = {}  # why what is at an address has no identity
        self._untold: dict[str, str] = {}  # the like of members and attributes by name, which nobody may ask for
        self._asked: set[str] = set()  # attributes that the functions met may ask for, and modules, as "<pathlib>"
        self._asked_by: dict[int, set[str]] = {}  # what is at an address
        self._asked_of: dict[str, set[str]] = {}  # by members and attributes, by their name

    def value(self, value: Any, name: str) -> None:
        """Add a value; its name is for messages."""
        if id(value) in self._failed:
            raise Unidentified(self._failed[id(value)])
        outer, self._asked = self._asked, set(self._asked_by.get(id(value), ()))
        try:
            self._value(value, name)
        except Unidentified as reason:
            self._failed[id(value)] = str(reason)
            self._met.append(value)
            raise
        finally:
            inner, self._asked = self._asked, outer | self._asked
        if id(value) in self._numbers:
            self._asked_by[id(value)] = inner

    def _value(self, value: Any, name: str) -> None:
        version = _version_of(value)
        if type(value) is str:
            self._asked.add(value)  # it may be the name of an attribute
        if version is None:
            super().value(value, name)
        elif type(version) is str:
            self.put(b"version", version.encode())
        else:
            raise Unidentified(f"{name}, whose {VERSION} is no text")

    def _named(self, name: str, what: str, *parts: Any) -> None:
        """Add a member or an attribute, which matters where somebody asks for its name; Python asks for operators."""
        is_operator = name.startswith("__")
        self.put(name.encode())
        outer, self._asked = self._asked, set()
        try:
            self._several(f"{what}.{name}", *parts)
        except Unidentified as reason:
            if is_operator:
                raise
            self._untold.setdefault(name, str(reason))
        finally:
            self._asked_of.setdefault(name, set()).update(self._asked)
            self._asked = outer | self._asked if is_operator else outer

    def require_told(self) -> None:
        """Raise where somebody asks for what has no identity, or reads a file."""
        asked, new = set(self._asked), set(self._asked)
        while new:
            new = set().union(*(self._asked_of.get(name, ()) for name in new)) - asked
            asked |= new
        for name in sorted(self._untold.keys() & asked):
            raise Unidentified(self._untold[name])
        for module in sorted(name for name in asked if name.startswith("<")):
            for name in sorted(filter(ANSWERS.match, asked)):
                raise Unidentified(f"{module[1:-1]}.{name}, {WHY}")

    # libraries

    def is_library(self, module: types.ModuleType) -> bool:
        """Python, this package, and what is installed, but for the packages that were asked for."""
        top = module.__name__.partition(".")[0]
        return top not in self._own and (top == "nonsmooth" or is_library(module) or is_installed(module))

    def library(self, path: str) -> None:
        """Add the name of something that a library has, with the version."""
        top, _, rest = path.partition(".")
        is_pythons, home = top in sys.stdlib_module_names, top.lstrip("_")
        name = f"{home}.{rest}" if is_pythons else path
        is_pure = home in PURE and name not in OF_THE_PROGRAM if is_pythons else top not in OUTSIDE
        is_open = ANSWERS.match(name.rpartition(".")[2]) or NUMPYS_GENERATOR.match(name)
        if name not in PURE_NAMES and (is_open or not is_pure):
            self.outside(path)
        if module := ON_DEMAND.get(name) or ON_DEMAND.get(home):
            self._asked.add(f"<{module}>")
        super().library(path)
        if not is_pythons and top != "nonsmooth":
            self.put(version_of(top).encode())

    def outside(self, path: str) -> None:
        """Nothing stands for what answers for the world outside."""
        raise Unidentified(f"{path}, {WHY}")

    def _path(self, value: Any, name: str, attributes: list[str]) -> None:
        """Also what is read of a class of a library: ``Solution.load``."""
        home = value if isinstance(value, types.ModuleType) else sys.modules.get(str(getattr(value, "__module__", "")))
        is_of_library = isinstance(value, types.ModuleType | type) and home is not None and self.is_library(home)
        if is_of_library and any(map(ANSWERS.match, attributes)):
            self.outside(".".join((name, *attributes)))
        super()._path(value, name, attributes)

    def imported(self, function: Any, module: str) -> None:
        """A module of a library by its name."""
        try:
            self._hand_on(importlib.import_module(module), f"{function.__name__}, which imports {module} as it runs")
        except ImportError:
            raise Unidentified(f"{function.__name__}, which imports {module}, which is not there") from None

    def _hand_on(self, module: types.ModuleType, what: str) -> None:
        if not self.is_library(module):
            raise Unidentified(what)
        self.library(module.__name__)
        self._asked.add(f"<{module.__name__}>")

    def copies(self, array: np.ndarray, layout: str) -> bool:
        """Arrays stand by their content."""
        return True

    # functions

    def function(self, function: Any) -> None:
        """A function, and its attributes; one that a library made by what it encloses."""
        module = sys.modules.get(function.__globals__.get("__name__") or "")
        if module is not None and vars(module) is function.__globals__ and self.is_library(module):
            if self._is_new(function):
                self.library(f"{module.__name__}.{function.__qualname__}")
                enclosed = tuple(self.watch.cell(cell) for cell in function.__closure__ or ())
                self._several(function.__name__, function.__defaults__, *enclosed)
            return
        is_met = id(function) in self._numbers
        self._asked |= mentioned(function.__code__)
        super().function(function)
        if not is_met and not str(function.__module__).startswith("nonsmooth."):
            self.value(tuple(sorted(vars(function).items())), f"an attribute of {function.__name__}")

    def unidentified(self, value: Any, what: str) -> None:
        """What machine code cannot be made from, by its parts."""
        if isinstance(value, types.FunctionType):
            raise Unidentified(what)
        if isinstance(value, types.ModuleType):
            self._hand_on(value, what)
        elif isinstance(value, functools.partial):
            self._several(what, b"partial", value.func, value.args, value.keywords)
        elif isinstance(value, types.MethodType):
            self._several(what, b"method", value.__func__, value.__self__)
        elif isinstance(value, types.BuiltinFunctionType | types.MethodWrapperType):
            self._several(what, b"method of a library", value.__name__, value.__self__)
        elif isinstance(getattr(value, "__wrapped__", None), types.FunctionType):  # of functools.lru_cache
            self._several(what, b"wrapped", type(value), value.__wrapped__)
        elif isinstance(value, type) and value.__flags__ & MADE_IN_PYTHON:
            self.members(value, what)
        elif isinstance(value, type):
            self.put(b"type", value.__qualname__.encode())
        elif self._is_new(value):
            self._object(value, what)

    def _several(self, what: str, *values: Any) -> None:
        self.put(len(values).to_bytes(8, "little"))
        for value in values:
            self.value(value, what)

    # containers and objects

    def _object(self, value: Any, what: str) -> None:
        """The class and the state of an object."""
        kind = type(value)
        self.value(kind, f"the class of {what}")
        if kind is dict or kind is types.MappingProxyType:
            self._several(what, *(part for entry in value.items() for part in entry))
        elif kind is list:
            self._several(what, *value)
        elif kind is set or kind is frozenset:
            self.put(*sorted(self._digest_of(entry, what) for entry in value))
        elif kind is np.ndarray:  # of objects
            self._several(what, value.shape, *value.ravel().tolist())
        else:
            self._state(value, what)

    def _digest_of(self, value: Any, what: str) -> bytes:
        content = Content(self._own)
        content._asked, content._asked_of, content._untold = self._asked, self._asked_of, self._untold
        content.value(value, what)
        self._asked = content._asked
        return content.digest()

    def _state(self, value: Any, what: str) -> None:
        """Attributes and slots; of an object of a library, or of a class above one, what it gives to be copied."""
        cls = type(value)
        if not self._keeps_more(cls):
            self._several(what, *(base(value) for base in BUILTIN if isinstance(value, base)))
            for name, held in attributes_of(value):
                self._named(name, what, held)
        if any(map(self._keeps_more, cls.__mro__)):
            self._several(what, *_reduced(value, what))

    def _keeps_more(self, cls: type) -> bool:
        """Whether objects of a class may hold what is neither attribute nor slot: those of libraries may."""
        module, top = sys.modules.get(cls.__module__), cls.__module__.partition(".")[0]
        is_plain = cls is object or cls in BUILTIN or top in ("nonsmooth", "abc", "typing")
        is_of_library = module is not None and self.is_library(module)
        return not is_plain and (is_of_library or not cls.__flags__ & MADE_IN_PYTHON)

    # classes

    def members(self, cls: type, what: str) -> None:
        """What a class of the user's has: methods, properties, attributes, and the classes below it."""
        self._several(what, b"class", type(cls), *(base for base in cls.__bases__ if base is not object))
        for name, member in sorted(vars(cls).items()):
            if not _is_made_by_python(cls, name, member):
                self._named(name, what, *_parts_of_member(member))


class Glance(Content):
    """A look at what a function reads in this process: what has no identity lives on, and is read where it stands."""

    def __init__(self, function: Any) -> None:
        super().__init__(owners(function))
        self.value(function, "")

    def value(self, value: Any, name: str) -> None:
        """Add a value, whatever text stands for it."""
        Survey.value(self, value, name)

    def outside(self, path: str) -> None:
        """Nothing is refused."""

    def unidentified(self, value: Any, what: str) -> None:
        """Nothing is added."""

    def imported(self, function: Any, module: str) -> None:
        """Nothing is imported for it."""


BUILTIN: tuple[Any, ...] = (
    int, float, complex, str, bytes, bytearray, tuple, list, dict, set, frozenset, np.ndarray
)  # fmt: skip
MADE_IN_PYTHON = 1 << 9  # defined: Py_TPFLAGS_HEAPTYPE
MADE_BY_DATACLASS = set("__init__ __eq__ __lt__ __le__ __gt__ __ge__ __hash__ __setattr__ __delattr__".split())
SUNDER = re.compile(r"_[^_].*_|_._")  # defined: by enum, names that are its own
MADE_BY_NAMEDTUPLE = set("__new__ _make _replace _asdict __getnewargs__".split())


def attributes_of(value: Any) -> Iterator[tuple[str, Any]]:
    """Attributes and slots of an object by name, but for what it derived from others and kept."""
    cls = type(value)
    for name, held in sorted(getattr(value, "__dict__", {}).items(), key=lambda entry: str(entry[0])):
        if not isinstance(getattr(cls, str(name), None), functools.cached_property):
            yield str(name), held
    for base in cls.__mro__:
        for name, member in sorted(vars(base).items()):
            if isinstance(member, types.MemberDescriptorType):
                yield name, getattr(value, name, "is not set")


def _reduced(value: Any, what: str) -> tuple[Any, ...]:
    """What is handed on to copy an object: its maker's name, arguments, state, entries.

    Raises
    ------
    Unidentified
        Where it cannot be copied.
    """
    try:
        reduced = value.__reduce_ex__(4)
    except Exception:  # what cannot be pickled says so in many ways
        raise Unidentified(what) from None
    if isinstance(reduced, str):
        return (reduced,)
    maker, arguments, *rest = reduced
    state, entries, pairs = (*rest, None, None, None)[:3]
    name = f"{getattr(maker, '__module__', '')}.{getattr(maker, '__qualname__', '')}"
    return name, arguments, state, list(entries or ()), list(pairs or ())


def _is_made_by_python(cls: type, name: str, member: Any) -> bool:
    """Whether a member follows from the others, or concerns the source or texts only."""
    if name in ("__repr__", "__str__", "_abc_impl") or isinstance(member, types.GetSetDescriptorType):
        return True
    if "_member_map_" in vars(cls) and (name in vars(cls)["_member_map_"] or SUNDER.fullmatch(name)):
        return True  # of an enumeration, whose members are known by their values
    if "_field_defaults" in vars(cls) and name in MADE_BY_NAMEDTUPLE:
        return True
    if dataclasses.is_dataclass(cls) and name in MADE_BY_DATACLASS:
        return getattr(getattr(member, "__code__", None), "co_filename", "") == "<string>"
    is_special = name.startswith("__") and name.endswith("__")
    return is_special and not isinstance(member, types.FunctionType | classmethod | staticmethod | property)


def _parts_of_member(member: Any) -> tuple[Any, ...]:
    """What a member of a class is made of."""
    if isinstance(member, classmethod | staticmethod):
        return type(member).__name__, member.__func__
    if isinstance(member, property):
        return "property", member.fget, member.fset
    if isinstance(member, functools.cached_property):
        return "cached property", member.func
    if isinstance(member, functools.partialmethod):
        return "partial method", member.func, member.args, member.keywords
    if isinstance(member, types.MemberDescriptorType):
        return ("slot",)
    return ("attribute", member)


def _version_of(value: Any) -> Any:
    """The text that an author gave a function, a class or an object; None where there is none."""
    if value is None or type(value) in BUILTIN or isinstance(value, types.ModuleType | np.generic):
        return None
    return inspect.getattr_static(value.__func__ if isinstance(value, types.MethodType) else value, VERSION, None)


@functools.cache
def version_of(top: str) -> str:
    """The version of an installed package, by the name of its uppermost module.

    Raises
    ------
    Unidentified
        Where it has none.
    """
    names = [top, *importlib.metadata.packages_distributions().get(top, ())] if not _is_distribution(top) else [top]
    found = sorted({importlib.metadata.version(name) for name in names if _is_distribution(name)})
    version = found or [str(getattr(sys.modules.get(top), "__version__", ""))]
    if not any(version):
        raise Unidentified(f"the package {top}, which has no version")
    return " ".join(version)


def _is_distribution(name: str) -> bool:
    try:
        importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return False
    return True
