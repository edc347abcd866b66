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

from roughcontact.errors import InputError, input_error, short_repr

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")

# Larger integers are treated as floats and not as counts.
_MAX_COUNT = 2**63
_UNCONVERTIBLE = object()


class _ArgumentType(NamedTuple):
    """Type of an argument: description, converter, and whether it is a sequence."""

    description: str
    convert: Callable[[Any], Any]
    is_sequence: bool = False


def validate_arguments(function: Callable[P, R]) -> Callable[P, R]:
    """Check and convert the arguments of a function by its annotations."""
    code = function.__code__
    names = code.co_varnames[: code.co_argcount]

    @functools.wraps(function)
    def call(*positional: P.args, **named: P.kwargs) -> R:
        known = _argument_types(function)
        # Python itself raises an error for too many arguments.
        each = zip(chain(names, repeat("")), positional, strict=False)
        specified: Any = [
            _converted_argument(known.get(name, []), name, value) for name, value in each
        ]
        others: Any = {
            name: _converted_argument(known.get(name, []), name, value)
            for name, value in named.items()
        }
        return function(*specified, **others)

    return call


def validate_public_methods(kind: type[T]) -> type[T]:
    """Apply `validate_arguments` to the public methods and the constructor of a class."""
    for name, method in list(vars(kind).items()):
        if isinstance(method, types.FunctionType) and (name == "__init__" or name[0] != "_"):
            setattr(kind, name, validate_arguments(method))
    return kind


def as_pair(value: Any, name: str) -> tuple[Any, Any]:
    """Return a pair (y, x); a single value is used for both."""
    if isinstance(value, Real):
        return (value, value)
    if not isinstance(value, Iterable) or len(pair := tuple(value)) != 2:
        raise input_error(name, value, "must be a pair (y, x)")
    return pair


def set_fields(instance: Any, **values: Any) -> None:
    """Set fields of a frozen dataclass, in its constructor."""
    for name, value in values.items():
        if name not in instance.__dataclass_fields__:
            raise AttributeError(f"{type(instance).__name__} has no field {name!r}")
        object.__setattr__(instance, name, value)


@functools.cache
def _argument_types(function: Callable[..., Any]) -> dict[str, list[_ArgumentType]]:
    """Return the accepted types of each argument; empty where they are unknown."""
    scope, usual = getattr(function, "__globals__", {}), inspect.signature(function).parameters
    result = {}
    for name, annotation in function.__annotations__.items():
        result[name] = _annotation_types(ast.parse(annotation, mode="eval").body, scope)
        if name in usual and isinstance(usual[name].default, str):
            such = _TEXT._replace(
                description=f"{_TEXT.description} such as {usual[name].default!r}"
            )
            result[name] = [such if kind is _TEXT else kind for kind in result[name]]
    return result


def _converted_argument(kinds: list[_ArgumentType], name: str, value: Any) -> Any:
    """Return an argument in an accepted type, or raise `InputError`."""
    if not kinds:
        return value
    # An array without dimensions is a scalar.
    if getattr(value, "shape", None) == () and hasattr(value, "item"):
        value = value.item()
    for kind in kinds:
        if (result := kind.convert(value)) is not _UNCONVERTIBLE:
            return result
    for kind in kinds:
        if kind.is_sequence and (result := kind.convert([value])) is not _UNCONVERTIBLE:
            return result
    wanted = " or ".join(dict.fromkeys(kind.description for kind in kinds if kind.description))
    raise InputError(
        f"must be {wanted}, got {_rejected_text(kinds, value)}", argument=name, value=value
    )


def _rejected_text(kinds: list[_ArgumentType], value: Any) -> str:
    """Return the argument, or the first invalid item of a list, as text."""
    lists = [kind for kind in kinds if kind.is_sequence]
    for number, item in enumerate(value if lists and isinstance(value, list | tuple) else (), 1):
        if all(kind.convert([item]) is _UNCONVERTIBLE for kind in lists):
            return f"{short_repr(item)} as number {number}"
    return short_repr(value)


def _annotation_types(node: ast.expr, scope: dict[str, Any]) -> list[_ArgumentType]:
    """Return the types of an annotation; empty if a part of it is unknown."""
    if isinstance(node, ast.BinOp):
        parts = _annotation_types(node.left, scope), _annotation_types(node.right, scope)
        return [*parts[0], *parts[1]] if all(parts) else []
    text = ast.unparse(node)
    if text in _KINDS:
        return [_KINDS[text]]
    if isinstance(node, ast.Subscript):
        series, inner = ast.unparse(node.value), node.slice
        if series in ("Sequence", "Iterable"):
            return _convert_sequence(_annotation_types(inner, scope), lazy=series == "Iterable")
        if series == "tuple" and isinstance(inner, ast.Tuple):
            return _convert_sequence(_annotation_types(inner.elts[0], scope), len(inner.elts))
    return _resolve_classes(text, scope)


def _convert_sequence(
    items: list[_ArgumentType], length: int | None = None, lazy: bool = False
) -> list[_ArgumentType]:
    """Return the type of a list, or of a tuple of some length; ``lazy`` passes iterators."""

    def convert_items(value: Any) -> Any:
        if not isinstance(value, Iterable) or isinstance(value, str | bytes | Mapping):
            return _UNCONVERTIBLE
        if lazy and isinstance(value, Iterator):
            return value
        result = [
            next(
                (got for item in items if (got := item.convert(entry)) is not _UNCONVERTIBLE),
                _UNCONVERTIBLE,
            )
            for entry in value
        ]
        if any(item is _UNCONVERTIBLE for item in result):
            return _UNCONVERTIBLE
        if length is None:
            return result
        return tuple(result) if len(result) == length else _UNCONVERTIBLE

    each = " or ".join(item.description for item in items)
    words = f"a list, each {each}" if length is None else f"{length} values, each {each}"
    return [_ArgumentType(words, convert_items, length is None)] if items else []


def _resolve_classes(text: str, scope: dict[str, Any]) -> list[_ArgumentType]:
    """Return the types of a class name, resolved in the scope of the function."""
    first, *rest = text.partition("[")[0].split(".")
    result: Any = functools.reduce(
        lambda index, name: getattr(index, name, None), rest, scope.get(first)
    )
    result = get_origin(result) or result
    classes = get_args(scope[first]) if result is types.UnionType else (result,)
    if result is Any or not all(isinstance(item, type) for item in classes):
        return []

    def convert_instance(value: Any) -> Any:
        if isinstance(value, str) and hasattr(result, "_from_name"):
            return result._from_name(value)
        return value if isinstance(value, classes) else _UNCONVERTIBLE

    return [_ArgumentType(f"a {item.__name__}", convert_instance) for item in classes]


def _instance_converter(*classes: type) -> Callable[[Any], Any]:
    return lambda value: value if isinstance(value, classes) else _UNCONVERTIBLE


def _convert_number(value: Any) -> Any:
    if not isinstance(value, Real):
        return _UNCONVERTIBLE
    try:
        number = float(value)
    except OverflowError:
        return _UNCONVERTIBLE
    return number if isinstance(value, Integral) and abs(int(value)) >= _MAX_COUNT else value


def _convert_count(value: Any) -> Any:
    return value if isinstance(value, Integral) and abs(int(value)) < _MAX_COUNT else _UNCONVERTIBLE


def _convert_bool(value: Any) -> Any:
    return bool(value) if isinstance(value, Integral) and value in (0, 1) else _UNCONVERTIBLE


def _convert_quantity(value: Any) -> Any:
    return value if isinstance(value, str) or hasattr(value, "m_as") else _convert_number(value)


def _convert_quantities(value: Any) -> Any:
    """Return a one-dimensional array unchanged, or convert a list item by item."""
    if hasattr(value, "m_as") or getattr(getattr(value, "dtype", None), "kind", "") in tuple("fiu"):
        return value if len(getattr(value, "shape", (1,))) == 1 else _UNCONVERTIBLE
    result = _LISTED.convert(value)
    return tuple(result) if isinstance(value, tuple) and result is not _UNCONVERTIBLE else result


def _convert_array(value: Any) -> Any:
    lettered = isinstance(value, str | bytes | Mapping)
    return value if isinstance(value, Iterable) and not lettered else _UNCONVERTIBLE


_QUANTITY = _ArgumentType("a number in SI units or a text with its unit", _convert_quantity)
(_LISTED,) = _convert_sequence([_QUANTITY])
_TEXT = _ArgumentType("a text", _instance_converter(str))
_KINDS = {
    "None": _ArgumentType("", _instance_converter(type(None))),
    "bool": _ArgumentType("True or False", _convert_bool),
    "int": _ArgumentType("a whole number", _convert_count),
    "float": _ArgumentType("a number", _convert_number),
    "str": _TEXT,
    "Quantity": _QUANTITY,
    "Quantities": _ArgumentType("a list of quantities", _convert_quantities, True),
    "WithUnit": _ArgumentType(
        "a quantity of pint", lambda value: value if hasattr(value, "m_as") else _UNCONVERTIBLE
    ),
    "ArrayLike": _ArgumentType("an array of numbers", _convert_array),
}
