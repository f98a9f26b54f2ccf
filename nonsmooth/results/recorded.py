"""What a run records, kind by kind: what may be asked for, and what is said of what was not.

    simulate(..., record=("coordinates", "events"))    some kinds, or one
    simulate(..., record="motion")                     short for those of the motion alone

Of a system all kinds are recorded where nothing is said; of a scene all but events and pairs.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from nonsmooth.errors import InvalidInput, nearest, shown

MOTION = "motion"  # code: short for the kinds of the motion alone
COORDINATES, VELOCITIES, GAPS, IMPULSES = "coordinates", "velocities", "gaps", "impulses"
MODES, LEDGER, EVENTS = "modes", "ledger", "events"
BODIES, CONTACTS, PAIRS = "bodies", "contacts", "pairs"
# the kinds of a system, and the columns that a loop writes of each
COLUMNS_OF = {
    COORDINATES: ("q",), VELOCITIES: ("u",), GAPS: ("g_N",), IMPULSES: ("P",), MODES: ("mode", "slip"),
    LEDGER: ("ledger",), EVENTS: (),
}  # fmt: skip
KINDS = tuple(COLUMNS_OF)
KINDS_OF_MOTION = (COORDINATES, VELOCITIES)
KINDS_BETWEEN = (COORDINATES, VELOCITIES, MODES, EVENTS)  # what the motion within fixed steps is found with


class Kinds(NamedTuple):
    """What runs of systems, or those of scenes, record."""

    all: tuple[str, ...]
    unasked: tuple[str, ...]  # where nothing is said
    motion: tuple[str, ...]  # what "motion" is short for
    drawn: str  # what a picture of the bodies needs
    plotted: tuple[str, ...]  # of which the figure of a run needs one at least

    def chosen(self, record: Any) -> tuple[str, ...]:
        """What is recorded, in the order of ``all``.

        Raises
        ------
        InvalidInput
            For what is no kind.
        """
        if record is None:
            return self.unasked
        known, listed = (*self.all, MOTION), (record,) if isinstance(record, str) else record
        if not isinstance(listed, tuple | list) or not all(isinstance(one, str) and one in known for one in listed):
            raise InvalidInput(f"record must be some of {', '.join(map(repr, known))}; got {shown(record)}")
        wanted = {*listed, *(self.motion if MOTION in listed else ())}
        return tuple(kind for kind in self.all if kind in wanted)


KINDS_OF_SYSTEM = Kinds(KINDS, KINDS, KINDS_OF_MOTION, COORDINATES, (COORDINATES, VELOCITIES, LEDGER))
KINDS_OF_SCENE = Kinds(
    (BODIES, CONTACTS, LEDGER, EVENTS, PAIRS),
    (BODIES, CONTACTS, LEDGER),
    (BODIES,),
    BODIES,
    (BODIES,),
)


def not_recorded(name: str, kind: str) -> InvalidInput:
    """What is said of a column that was left out."""
    return InvalidInput(f'{name} was not recorded; simulate(..., record=("{kind}", ...)) keeps the {kind}')


class Recorded:
    """A field of a result that is there if its kind was recorded."""

    def __init__(self, kind: str, name: str = "") -> None:
        self.kind, self.name = kind, name

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, result: Any, owner: type) -> Any:
        if result is None:
            raise AttributeError(self.name)  # of a dataclass: it has no default
        value = vars(result)[self.name]
        if value is None:
            raise not_recorded(self.name, self.kind)
        return value

    def __set__(self, result: Any, value: Any) -> None:
        vars(result)[self.name] = value


def index_of(name: Any, names: list[str]) -> int:
    """The place of a body among all, or `InvalidInput` with the name that is nearest."""
    if name not in names:
        raise InvalidInput(f"there is no body {shown(name)}; {nearest(name, names)}")
    return names.index(name)
