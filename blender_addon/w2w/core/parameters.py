# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters declared once: help, unit, range and heading in the metadata of a record's field.

The command line's options and the panel's properties are made of these declarations, and records are read
back from JSON by them.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from functools import cache
from numbers import Integral, Real
from operator import attrgetter
from types import UnionType
from typing import (
    TYPE_CHECKING,
    Any,
    Literal,
    TypeAlias,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

T = TypeVar("T", bound="DataclassInstance")

DECLARED = "declared"

Stage: TypeAlias = Literal["signals", "ranking", "choice", ""]
"""The first stage whose results a parameter changes; "" if others say it, as the patches do, or none does."""


@dataclass(frozen=True)
class Parameter:
    """A parameter's declaration; `path` leads from the outermost record to its field.

    `web` says whether the web app may ask for it, and `panel` in which part of the panel it is one property
    with the same value, "" for none.
    """

    help: str
    name: str = ""
    title: str = ""
    unit: str = ""
    least: float | None = None
    most: float | None = None
    usual: tuple[float | None, float | None] = (None, None)
    group: str | None = ""
    stage: Stage = "signals"
    web: bool = False
    panel: str = ""
    path: tuple[str, ...] = ()
    kind: Any = None
    default: Any = None

    @property
    def kinds(self) -> tuple[Any, ...]:
        """The types of its value, NoneType among them if it may lack."""
        is_several = get_origin(self.kind) in (Union, UnionType)
        return get_args(self.kind) if is_several else (self.kind,)

    @property
    def is_list(self) -> bool:
        return get_origin(self.kind) is tuple

    @property
    def is_optional(self) -> bool:
        return type(None) in self.kinds

    def of(self, record: Any) -> Any:
        """The parameter's value."""
        return attrgetter(".".join(self.path))(record)

    def check(self, record: Any) -> None:
        """Raise ValueError, with what is allowed, for a value out of range."""
        value, whole = self.of(record), int in self.kinds
        if self.kind is bool and value not in (True, False):
            raise ValueError(f"{'.'.join(self.path)} must be True or False, not {value!r}")
        if (value is None and self.is_optional) or (self.least is None and self.most is None):
            return
        low = float("-inf") if self.least is None else self.least
        high = float("inf") if self.most is None else self.most
        if isinstance(value, Integral if whole else Real) and low <= float(value) <= high:
            return
        allowed = f"from {low:g}" + (f" to {high:g}" if self.most is not None else " on")
        noun = "a whole number " if whole else ""
        raise ValueError(f"{'.'.join(self.path)} must be {noun}{allowed}, not {value!r}")


def parameter(default: Any, help: str, name: str = "", **about: Any) -> Any:  # noqa: A002
    """A field of a record, declared for people.

    `name` is its option's and property's name if not the field's; `group` the heading of the
    option, None without an option; `title` its label in the panel; `usual` the range of a slider.
    """
    return field(default=default, metadata={DECLARED: Parameter(help, name, **about)})


def parameters_of(record: type) -> dict[str, Parameter]:
    """All parameters that a record and the records in it declare, by name."""
    return _parameters_of(record)


@cache
def _parameters_of(record: type) -> dict[str, Parameter]:
    return dict(_declared(record, ()))


def parameters_at(stage: Stage, record: type) -> dict[str, Parameter]:
    """The parameters of a record that change the results of a stage first, by name."""
    return {name: each for name, each in parameters_of(record).items() if each.stage == stage}


def with_values(record: T, values: Mapping[str, Any]) -> T:
    """A record with other values of some of its parameters, by their names."""
    own: dict[str, Any] = {}
    inner: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        *records, last = parameters_of(type(record))[name].path
        (inner.setdefault(records[0], {}) if records else own)[last] = value
    own |= {name: replace(getattr(record, name), **changes) for name, changes in inner.items()}
    return replace(record, **own)


def _declared(record: Any, path: tuple[str, ...]) -> Iterator[tuple[str, Parameter]]:
    hints = get_type_hints(record)
    for item in fields(record):
        inner = [kind for kind in (hints[item.name], *get_args(hints[item.name])) if is_dataclass(kind)]
        if DECLARED in item.metadata:
            declared, where = item.metadata[DECLARED], (*path, item.name)
            named = declared.name or item.name
            about = {"name": named, "path": where, "kind": hints[item.name], "default": item.default}
            yield named, replace(declared, **about)
        elif inner:
            yield from _declared(inner[0], (*path, item.name))


def read_record(record: type[T], given: Any, where: str = "") -> T:
    """A record from what JSON holds; what is not given takes its default, which every field must have.

    `where` is the record's path, for messages.

    Raises ValueError if a key is unknown or a value of the wrong kind; the message names the key and what is
    allowed.
    """
    names = [item.name for item in fields(record)]
    if not isinstance(given, Mapping):
        raise ValueError(f"{where or 'parameters'} must hold {', '.join(names)}, not {given!r}")
    hints, path = get_type_hints(record), f"{where}." if where else ""
    for name in given:
        if name not in names:
            raise ValueError(f"{path}{name} is unknown; there are {', '.join(names)}")
    return record(**{name: _value(hints[name], value, f"{path}{name}") for name, value in given.items()})


def _value(kind: Any, given: Any, where: str) -> Any:
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        if given is None and type(None) in parts:
            return None
        exact = [part for part in parts if part is type(given)]
        wanted = [part for part in parts if (get_origin(part) is tuple) == isinstance(given, list)]
        return _value((exact or wanted or parts)[0], given, where)
    if isinstance(kind, type) and is_dataclass(kind):
        return read_record(kind, given, where)
    if origin is tuple and isinstance(given, list | tuple):
        kinds = parts[:1] * len(given) if parts[-1] is Ellipsis else parts
        if len(kinds) == len(given):
            return tuple(_value(kinds[k], value, f"{where}[{k}]") for k, value in enumerate(given))
    is_number = kind is float and isinstance(given, Real) and not isinstance(given, bool)
    if is_number or type(given) is kind or (origin is Literal and given in parts):
        return given
    raise ValueError(f"{where} must be {_said(kind)}, not {given!r}")


def _said(kind: Any) -> str:
    """A kind of value, for messages."""
    if get_origin(kind) is Literal:
        return " or ".join(map(repr, get_args(kind)))
    if get_origin(kind) is tuple:
        parts = get_args(kind)
        return f"a list of {len(parts)}" if parts[-1] is not Ellipsis else "a list"
    names = {int: "a whole number", float: "a number", str: "a text", bool: "true or false"}
    return names.get(kind, str(kind))
