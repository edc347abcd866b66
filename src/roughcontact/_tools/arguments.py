"""Argument checks of the public functions, derived from their annotations."""

from __future__ import annotations

import ast
import functools
import inspect
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain, repeat
from numbers import Integral, Real
from typing import Any, NamedTuple, ParamSpec, TypeVar, get_args, get_origin

from roughcontact._tools import deprecated
from roughcontact.errors import InputError, input_error, shown

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

# Beyond it a whole number is no count of anything.
_LARGEST = 2**63
_NO = object()


class _Kind(NamedTuple):
    """Type of an argument: description, converter, and whether it is a sequence."""

    words: str
    taken: Callable[[Any], Any]
    several: bool = False


def checked(function: Callable[P, R]) -> Callable[P, R]:
    """Let a function refuse arguments that its annotations do not name."""
    code = function.__code__
    names = code.co_varnames[: code.co_argcount]

    @functools.wraps(function)
    def call(*positional: P.args, **named: P.kwargs) -> R:
        known = _known(function)
        # Python says itself what is too many.
        each = zip(chain(names, repeat("")), positional, strict=False)
        specified: Any = [_taken(known.get(name, []), name, value) for name, value in each]
        current = {deprecated.current_argument(function.__name__, name): value
                   for name, value in named.items()}  # fmt: skip
        others: Any = {
            name: _taken(known.get(name, []), name, value) for name, value in current.items()
        }
        return function(*specified, **others)

    return call


def checked_methods(kind: type[T]) -> type[T]:
    """Let the public methods of a class, and what makes one, be `checked`."""
    for name, method in list(vars(kind).items()):
        if isinstance(method, types.FunctionType) and (name == "__init__" or name[0] != "_"):
            setattr(kind, name, checked(method))
    return kind


def both(value: Any, name: str) -> tuple[Any, Any]:
    """Return a pair (y, x); a single value is used for both."""
    if isinstance(value, Real):
        return (value, value)
    if not isinstance(value, Iterable) or len(pair := tuple(value)) != 2:
        raise input_error(name, value, "must be a pair (y, x)")
    return pair


@functools.cache
def _known(function: Callable[..., Any]) -> dict[str, list[_Kind]]:
    """Return what each argument may be; nothing where that is unknown."""
    scope, usual = getattr(function, "__globals__", {}), inspect.signature(function).parameters
    result = {}
    for name, annotation in function.__annotations__.items():
        result[name] = _kinds(ast.parse(annotation, mode="eval").body, scope)
        if name in usual and isinstance(usual[name].default, str):
            such = _TEXT._replace(words=f"{_TEXT.words} such as {usual[name].default!r}")
            result[name] = [such if kind is _TEXT else kind for kind in result[name]]
    return result


def _taken(kinds: list[_Kind], name: str, value: Any) -> Any:
    """Return an argument as its function takes it."""
    value = deprecated.current_value(name, value)
    if not kinds:
        return value
    # An array of no dimension is a number.
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        value = value.item()
    for kind in kinds:
        if (result := kind.taken(value)) is not _NO:
            return result
    for kind in kinds:
        if kind.several and (result := kind.taken([value])) is not _NO:
            return result
    wanted = " or ".join(dict.fromkeys(kind.words for kind in kinds if kind.words))
    raise InputError(
        f"must be {wanted}, got {_rejected_text(kinds, value)}", argument=name, value=value
    )


def _rejected_text(kinds: list[_Kind], value: Any) -> str:
    """Return what was given, or the first item of a list that cannot be used."""
    lists = [kind for kind in kinds if kind.several]
    for number, item in enumerate(value if lists and isinstance(value, list | tuple) else (), 1):
        if all(kind.taken([item]) is _NO for kind in lists):
            return f"{shown(item)} as number {number}"
    return shown(value)


def _kinds(node: ast.expr, scope: dict[str, Any]) -> list[_Kind]:
    """Return what an annotation names; nothing where a part of it is unknown."""
    if isinstance(node, ast.BinOp):
        parts = _kinds(node.left, scope), _kinds(node.right, scope)
        return [*parts[0], *parts[1]] if all(parts) else []
    text = ast.unparse(node)
    if text in _KINDS:
        return [_KINDS[text]]
    if isinstance(node, ast.Subscript):
        series, inner = ast.unparse(node.value), node.slice
        if series in ("Sequence", "Iterable"):
            return _series(_kinds(inner, scope), lazy=series == "Iterable")
        if series == "tuple" and isinstance(inner, ast.Tuple):
            return _series(_kinds(inner.elts[0], scope), len(inner.elts))
    return _instance(text, scope)


def _series(items: list[_Kind], length: int | None = None, lazy: bool = False) -> list[_Kind]:
    """Return a list of items, or a tuple of so many; one that is lazy may hold one at a time."""

    def taken(value: Any) -> Any:
        if not isinstance(value, Iterable) or isinstance(value, str | bytes | Mapping):
            return _NO
        if lazy and isinstance(value, Iterator):
            return value
        result = [next((got for item in items if (got := item.taken(entry)) is not _NO), _NO)
                 for entry in value]  # fmt: skip
        if any(item is _NO for item in result):
            return _NO
        if length is None:
            return result
        return tuple(result) if len(result) == length else _NO

    each = " or ".join(item.words for item in items)
    words = f"a list, each {each}" if length is None else f"{length} values, each {each}"
    return [_Kind(words, taken, length is None)] if items else []


def _instance(text: str, scope: dict[str, Any]) -> list[_Kind]:
    """Return the classes that a name means where the function stands."""
    first, *rest = text.partition("[")[0].split(".")
    result: Any = functools.reduce(
        lambda index, name: getattr(index, name, None), rest, scope.get(first)
    )
    result = get_origin(result) or result
    classes = get_args(scope[first]) if result is types.UnionType else (result,)
    if result is Any or not all(isinstance(item, type) for item in classes):
        return []

    def taken(value: Any) -> Any:
        if isinstance(value, str) and hasattr(result, "_named"):
            return result._named(value)
        return value if isinstance(value, classes) else _NO

    return [_Kind(f"a {item.__name__}", taken) for item in classes]


def _of(*classes: type) -> Callable[[Any], Any]:
    return lambda value: value if isinstance(value, classes) else _NO


def _number(value: Any) -> Any:
    if not isinstance(value, Real):
        return _NO
    try:
        number = float(value)
    except OverflowError:
        return _NO
    return number if isinstance(value, Integral) and abs(int(value)) >= _LARGEST else value


def _count(value: Any) -> Any:
    return value if isinstance(value, Integral) and abs(int(value)) < _LARGEST else _NO


def _switch(value: Any) -> Any:
    return bool(value) if isinstance(value, Integral) and value in (0, 1) else _NO


def _quantity(value: Any) -> Any:
    return value if isinstance(value, str) or hasattr(value, "m_as") else _number(value)


def _quantities(value: Any) -> Any:
    """Return numbers of an array as they are, and those of a list one by one."""
    if hasattr(value, "m_as") or getattr(getattr(value, "dtype", None), "kind", "") in tuple("fiu"):
        return value if len(getattr(value, "shape", (1,))) == 1 else _NO
    result = _LISTED.taken(value)
    return tuple(result) if isinstance(value, tuple) and result is not _NO else result


def _array(value: Any) -> Any:
    lettered = isinstance(value, str | bytes | Mapping)
    return value if isinstance(value, Iterable) and not lettered else _NO


_ONE = _Kind("a number in SI units or a text with its unit", _quantity)
(_LISTED,) = _series([_ONE])
_TEXT = _Kind("a text", _of(str))
_KINDS = {
    "None": _Kind("", _of(type(None))),
    "bool": _Kind("True or False", _switch),
    "int": _Kind("a whole number", _count),
    "float": _Kind("a number", _number),
    "str": _TEXT,
    "Quantity": _ONE,
    "Quantities": _Kind("a list of quantities", _quantities, True),
    "WithUnit": _Kind("a quantity of pint", lambda value: value if hasattr(value, "m_as") else _NO),
    "ArrayLike": _Kind("an array of numbers", _array),
}
