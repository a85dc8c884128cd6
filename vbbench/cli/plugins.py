"""Commands that installed packages add: entry points of the group ``vbbench.commands``.

Each names a dict name → function; entry point ``tool`` with a function ``run`` gives ``vbbench tool run``, and with one
of the empty name ``vbbench tool``.
"""

import warnings
from collections.abc import Callable, Container, Mapping
from typing import Any

from vbbench.errors import VbbenchWarning


def plugin_commands(taken: Container[str]) -> dict[str, Callable[..., Any]]:
    """Every such command by name; a plugin that is broken, or whose name is ``taken``, causes a warning."""
    from vbbench.registry import load_all

    found: dict[str, Callable[..., Any]] = {}
    for group, commands in load_all("command").items():
        if group in taken or not isinstance(commands, Mapping):
            reason = "its name is a command of vbbench" if group in taken else "it is not a dict of functions"
            warnings.warn(f"commands '{group}' are skipped: {reason}", VbbenchWarning, stacklevel=2)
            continue
        found |= {f"{group} {name}".strip(): function for name, function in commands.items()}
    return found
