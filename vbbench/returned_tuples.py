"""Tuples that a kernel returns, made so that a signal that came meanwhile is an exception, and no crash.

Python handles a signal before the next line of Python code. Where that came while a kernel ran, the first such line is
one of numba's, or of a class, that makes what the kernel returns. Numba does not ask whether it raised an exception,
such as `KeyboardInterrupt`, and goes on with a null pointer, or returns a result beside the exception.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import boxing, cgutils, types

_numbas: Any = types
_KINDS = (_numbas.Tuple, _numbas.UniTuple, _numbas.NamedTuple, _numbas.NamedUniTuple)
_BOXERS: dict[Any, Any] = boxing.box.__self__.functions
"""Of each kind of value what writes the code that makes Python's object of it."""


def _made(kind: Any, value: Any, c: Any) -> Any:
    """Code that makes a tuple of native values; null where an exception was raised, which is then passed on."""
    values, made = c.pyapi.tuple_new(kind.count), cgutils.alloca_once_value(c.builder, c.pyapi.get_null_object())
    for number, its_kind in enumerate(kind):
        with c.builder.if_then(_nothing_raised(c)):
            c.pyapi.tuple_setitem(values, number, c.box(its_kind, c.builder.extract_value(value, number)))
    with c.builder.if_then(_nothing_raised(c)):
        if isinstance(kind, _numbas.BaseNamedTuple):
            its_class = c.env_manager.read_const(c.env_manager.add_const(kind.instance_class))
            c.builder.store(c.pyapi.call(its_class, values), made)
        else:
            c.pyapi.incref(values)
            c.builder.store(values, made)
    c.pyapi.decref(values)
    return c.builder.load(made)


def _nothing_raised(c: Any) -> Any:
    return cgutils.is_null(c.builder, c.pyapi.err_occurred())


@contextmanager
def tuples_made_safely() -> Iterator[None]:
    """What is compiled meanwhile makes tuples so; nobody else compiles, for one thread at a time does."""
    before = {kind: _BOXERS[kind] for kind in _KINDS}
    _BOXERS.update(dict.fromkeys(_KINDS, _made))
    try:
        yield
    finally:
        _BOXERS.update(before)
