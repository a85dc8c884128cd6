"""Functions that kernels call are compiled into these, and make no machine code of their own.

Numba optimises every function that it meets, makes machine code of it and wraps it for Python, and does all this again
in each function that calls it. Of a tree of kernels only the root is called from Python: the others, and what they call
of numba's own (all of NumPy is written in functions like ours), are left as they are when translated, and optimised
with the root. A kernel that Python does call is compiled for itself then.
More than half the processor time of compiling is saved so. Collecting garbage meanwhile would take a fifth of the rest:
the millions of objects that numba makes are all in use until a kernel is finished.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from typing import Any

from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.dispatcher import Dispatcher
from numba.core.sigutils import normalize_signature
from numba.core.typed_passes import NativeLowering

from vbbench.returned_tuples import tuples_made_safely

_compiling: list[Any] = []
"""Kernels that are being compiled, each called by the one before."""


class _Unfinished(JITCodeLibrary):  # type: ignore[misc]
    """The code of an inner kernel and of all that it calls."""

    def finalize(self) -> None:
        """Gather the code, which the root's library takes over; nothing else is done with it."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._final_module.verify()
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):  # type: ignore[misc]
    """Translates a function for LLVM."""

    _name = "vbbench_lowering"

    def run_pass(self, state: Any) -> bool:
        if len(_compiling) == 1 and state.func_id.func is _compiling[0].py_func:
            return bool(super().run_pass(state))
        state.flags.no_compile = state.flags.no_cpython_wrapper = state.flags.no_cfunc_wrapper = True
        state.library = _Unfinished(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        callers_know_it_by = object()
        state.targetctx.insert_user_function(callers_know_it_by, state["cr"].fndesc, [state.library])
        state["cr"] = state["cr"]._replace(cfunc=callers_know_it_by)
        return True


_compilers: Any = Compiler
_dispatchers: Any = Dispatcher
_numbas_passes, _numbas_add = _compilers.define_pipelines, _dispatchers.add_overload


def _passes(compiler: Any) -> list[Any]:
    """Numba's lists of passes, one replaced."""
    pipelines: list[Any] = _numbas_passes(compiler)
    for passes in pipelines:
        passes.passes = [(_Lowering if one is NativeLowering else one, why) for one, why in passes.passes]
        passes.finalize()
    return pipelines


def _add_to(dispatcher: Any, compiled: Any) -> None:
    """Keep what was compiled of one of numba's own functions."""
    _add(dispatcher, partial(_numbas_add, dispatcher), compiled)


@contextmanager
def _compiling_for_a_root() -> Iterator[None]:
    """Meanwhile numba's own functions are left unfinished, too; nobody else compiles, for one thread at a time does."""
    _compilers.define_pipelines, _dispatchers.add_overload = _passes, _add_to
    try:
        with tuples_made_safely(), _garbage_left():
            yield
    finally:
        _compilers.define_pipelines, _dispatchers.add_overload = _numbas_passes, _numbas_add


@contextmanager
def _garbage_left() -> Iterator[None]:
    """Meanwhile no garbage is collected."""
    collecting = gc.isenabled()
    try:
        gc.disable()
        yield
    finally:
        if collecting:
            gc.enable()


class _Cache(FunctionCache):  # type: ignore[misc]
    """Numba's cache, which keeps what has machine code."""

    def save_overload(self, signature: Any, compiled: Any) -> None:
        """Write the code of one signature to the disk."""
        if not _is_inner(compiled):
            super().save_overload(signature, compiled)


def _is_inner(compiled: Any) -> bool:
    """Whether what numba compiled cannot be called from Python."""
    return isinstance(compiled.library, _Unfinished)


def leave_inner_kernels_unfinished(dispatcher: Any) -> None:
    """Make numba's ``dispatcher`` of a function that is cached tell root from inner."""
    compile_here, add_overload = dispatcher.compile, dispatcher.add_overload
    dispatcher._cache.__class__ = _Cache
    dispatcher.compile = _counted(dispatcher, compile_here)
    dispatcher.add_overload = lambda compiled: _add(dispatcher, add_overload, compiled)


def _counted(dispatcher: Any, compile_here: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """A dispatcher's ``compile`` that is known to be under way; only one thread compiles at a time."""

    def compile_as_root_or_inner(signature: Any) -> Any:
        inner = bool(_compiling)
        if not inner:
            arguments = tuple(normalize_signature(signature)[0])
            if arguments in dispatcher.overloads and _is_inner(dispatcher.overloads[arguments]):
                del dispatcher.overloads[arguments]
        _compiling.append(dispatcher)
        try:
            with nullcontext() if inner else _compiling_for_a_root():
                return compile_here(signature)
        finally:
            _compiling.pop()

    return compile_as_root_or_inner


def _add(dispatcher: Any, add_overload: Callable[[Any], None], compiled: Any) -> None:
    """Keep what was ``compiled``; only what has machine code is put where calls from Python look."""
    if _is_inner(compiled):
        dispatcher.overloads[tuple(compiled.signature.args)] = compiled
    else:
        add_overload(compiled)
