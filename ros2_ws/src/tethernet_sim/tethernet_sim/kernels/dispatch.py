"""Functions of compiled code whose kernel is chosen by the type of their first argument, a named tuple, when a step is
compiled.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from numba.core import types
from numba.extending import overload


def serve(function: Callable[..., Any], choose: Callable[[type], Callable[..., Any] | None], options: Any) -> None:
    """Let compiled code that calls a function be served by what is chosen.

    Args:
        function: what is called; it gives names and order of the arguments, and is never run itself.
        choose: from the class of the first argument to a plain function of the same arguments, None: of this class
            there is none, and compiling ends with numba's TypingError.
        options: how that one is compiled, see kernels.options.
    """

    def implementation(*arguments):
        kind: Any = arguments[0]
        if not isinstance(kind, types.BaseNamedTuple):
            return None
        return choose(kind.instance_class)  # type: ignore[attr-defined]  # numba's annotations leave it out

    # numba compares the signatures.
    overload(function, jit_options=options)(passing_on(function, implementation))


def passing_on(function: Callable[..., Any], kernel: Callable[..., Any]) -> Callable[..., Any]:
    """A plain function of the arguments of ``function`` that hands them to a kernel."""
    return _of_the_arguments(function, f"kernel({_names(function)})", {"kernel": kernel})


def constant(function: Callable[..., Any], result: str) -> Callable[..., Any]:
    """A plain function of the arguments of ``function`` that returns the value of an expression of them."""
    return _of_the_arguments(function, result, {})


def _of_the_arguments(function: Callable[..., Any], expression: str, known: dict[str, Any]) -> Callable[..., Any]:
    result: Callable[..., Any] = eval(f"lambda {_names(function)}: {expression}", known)
    return result


def _names(function: Callable[..., Any]) -> str:
    return ", ".join(inspect.signature(function).parameters)


def serve_by_module(function: Callable[..., Any], modules: dict[type, Any], options: Any) -> None:
    """Let a function be served by the kernel of the same name in the module of the first argument's class."""

    def choose(kind: type) -> Callable[..., Any] | None:
        module = modules.get(kind)
        return None if module is None else passing_on(function, getattr(module, function.__name__))

    serve(function, choose, options)
