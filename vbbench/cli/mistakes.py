"""Explains in one line what is wrong with the arguments of a command, and suggests what was meant."""

import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import is_dataclass
from itertools import zip_longest
from typing import Any, Literal, get_args, get_origin, get_type_hints

from vbbench.errors import UnknownNameError, quoted

_FRAME = re.compile(r"\x1b\[[0-9;]*m|[╭╮╰╯│─]|-{3,}|(?<!\S)[|+](?!\S)")
"""Colours and the lines of a box, as terminals of Unicode and of ASCII get them."""


def check_options(command: str, function: Callable[..., Any], arguments: Sequence[str]) -> None:
    """Raise UnknownNameError for an option that a command does not have, or a word that an option does not allow.

    Parameters
    ----------
    command : its name, such as ``export csv``.
    function : the function of the command; its keyword parameters are the options.
    arguments : what follows the command's name.
    """
    options = dict(_options(function))
    for given, following in zip_longest(arguments, arguments[1:], fillvalue=""):
        name, equals, value = given.partition("=")
        option = name.replace("_", "-")
        if not option.startswith("--") or option in ("--", "--help"):
            continue
        if option not in options:
            raise UnknownNameError(f"option of '{command}'", name, [*options, "--help"])
        words = _words(options[option])
        chosen = value if equals else following
        if words and chosen and not chosen.startswith("--") and chosen not in words:
            raise UnknownNameError(f"value of {option}", chosen, words)


_VALUE_MISTAKES = (
    (
        r"Value error Error parsing (\S+): .*?invalid literal for int\(\).*?: ('.*?') ",
        "{} must be a whole number, not {}",
    ),
    (r"Value error Error parsing (\S+): .*?could not convert string to float: ('.*?') ", "{} must be a number, not {}"),
    (r"Value error Error parsing (\S+): no type matching .*? from (\[.*?\])\.", "{} cannot be {}"),
    (r"Missing argument Missing value for argument '(\S+)'", "{} needs a value"),
)
"""Tyro's messages about values, and how we say them."""


def explain(complaint: str, command: str, function: Callable[..., Any] | None) -> str:
    """Tyro's message, which it prints in a box, as one line; common mistakes are explained in our own words."""
    text = " ".join(_FRAME.sub(" ", complaint).split())
    if function is None:
        return text
    see = f"see 'vbbench {command} --help'"
    if text.startswith("Required options"):
        missing = ", ".join(name for name in _required(function) if re.search(rf"(?<!\S){name}(?!\S)", text))
        return f"'{command}' needs {missing}; {see}"
    if found := re.match(r"Unrecognized options Unrecognized options: (.*?)(?= Perhaps you meant| For full)", text):
        return f"'{command}' has no use for {quoted(found[1])}; {see}"
    for pattern, words in _VALUE_MISTAKES:
        if found := re.match(pattern, text):
            return f"{words.format(*found.groups())}; {see}"
    return text


_LIMITS = (r"(?:^|(?<=[:;] ))(\w+) (?=must (?:not )?be\b|is a number of\b)", "{} ")
"""How messages say what a value is to be: of a parameter, or of what stands in a file under the same name."""

_IN_PYTHON = (
    (r"\bset (\w+) to\b", "add {} to"),
    (r"(?<=\bwithout )(\w+)$", "{}"),
    (r"`(\w+)(?:=True)?`", "{}"),
)
"""How messages of the library name a parameter, and what replaces that on the command line."""

_ALIASES = {"height_std": "sigma_h"}
"""Parameters of the library whose options have other names."""


def in_options(message: str, function: Callable[..., Any], *, of_file: bool = False) -> str:
    """A message of the library for users of a command, with its options: ``--limit`` for ``limit``.

    What is on unless it is turned off has the option that turns it off: ``--no-detector`` for ``detector``.

    What a message ``of_file`` says that values must be is of the file's.
    """
    options = dict(_options(function))

    def named(found: re.Match[str], words: str) -> str:
        name = _ALIASES.get(found[1], found[1]).replace("_", "-")
        option = next((option for option in (f"--{name}", f"--no-{name}") if option in options), None)
        return found[0] if option is None else words.format(option)

    if "--truth" in options:
        message = re.sub(
            r"(name the folder that holds (?:it|all of them))(?: \(truth\))?$", r"\1 with --truth", message
        )
    for pattern, words in _IN_PYTHON if of_file else (*_IN_PYTHON, _LIMITS):
        message = re.sub(pattern, lambda found, words=words: named(found, words), message)  # type: ignore[misc]
    return message


def _options(function: Callable[..., Any]) -> Iterator[tuple[str, Any]]:
    """Every option with its type; fields of a dataclass are options like the others, and what is on is turned off."""
    hints = get_type_hints(function)
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.kind is not parameter.POSITIONAL_ONLY:
            kinds = get_type_hints(hints[name]) if is_dataclass(hints[name]) else {name: hints[name]}
            off = "no-" if parameter.default is True else ""
            yield from ((f"--{off}{option.replace('_', '-')}", kind) for option, kind in kinds.items())


def _words(kind: Any) -> tuple[str, ...]:
    """The words that a type allows; none if it also allows anything else."""
    members = [kind] if get_origin(kind) is Literal else [each for each in get_args(kind) if each is not type(None)]
    return get_args(members[0]) if len(members) == 1 and get_origin(members[0]) is Literal else ()


def _required(function: Callable[..., Any]) -> Iterator[str]:
    """The names of required arguments as ``--help`` shows them."""
    for name, parameter in inspect.signature(function).parameters.items():
        if parameter.default is parameter.empty:
            positional = parameter.kind is parameter.POSITIONAL_ONLY
            yield name.upper().replace("_", "-") if positional else f"--{name.replace('_', '-')}"
