"""What is done to an honest file: to its bytes, to its numbers and words, and to its structure."""

import json
import re
from collections.abc import Callable
from random import Random
from typing import Any

Mutation = Callable[[bytes, Random], bytes]

_SPELLINGS = """
nan inf -inf +Inf infinity 1e308 -1e308 1e400 1e-320 -0 -0.0 0 1 -1 0.5 1.5 .5 5. . - + 1e5 1e 1d5 --1 +-1 00012 1,5
2e9 2000000000 1e10 1e16 1e30 2147483647 2147483648 4294967296 9007199254740993 9223372036854775807 9223372036854775808
18446744073709551615 -9223372036854775808 0x10 0b1 1_0 0_2 true null none ١٢ １ ² ½
"""
_LONG = ("9" * 5000, "0." + "3" * 5000, "1e" + "9" * 30, "-" * 3000)
NUMBERS = [*_SPELLINGS.split(), *_LONG, "", " ", "\t", '"', "'", "1\u00a02"]
"""Spellings that are no numbers, or none that a place, a count or an id can be."""

WORDS = [
    *NUMBERS,
    "\x1b[2J\x1b[31m",
    "a\nb",
    "\u202egnp.exe",
    "\x00",
    "\ud800",
    "\u2028",
    "ü" * 300,
    "x" * 20_000,
    "../../etc/passwd",
    "/dev/zero",
    "{}",
    "[]",
    "%s%n",
]
RUNS = (
    b"9",
    b"\0",
    b"\xff",
    b"[",
    b"{",
    b'{"a":',
    b"a.",
    b" ",
    b"\n",
    b",",
    b"#",
    b"-",
    b"\xc3\x28",
    b"\xf0\x9f",
    b"(",
)
NUMBER = re.compile(rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


LARGEST = 2**21
"""Bytes of the largest file that mutations make: what a large honest file takes is no fault."""


def mutate(content: bytes, random: Random, mutations: tuple[Mutation, ...]) -> bytes:
    """One to four of the ``mutations``, one after the other."""
    for _ in range(random.choice((1, 1, 1, 2, 3, 4))):
        content = random.choice(mutations)(content, random)[:LARGEST]
    return content


def flip(content: bytes, random: Random) -> bytes:
    changed = bytearray(content)
    for _ in range(random.choice((1, 1, 2, 8)) if changed else 0):
        changed[random.randrange(len(changed))] = random.randrange(256)
    return bytes(changed)


def cut(content: bytes, random: Random) -> bytes:
    begin, end = _piece(content, random)
    return content[:begin] + content[end:]


def cut_short(content: bytes, random: Random) -> bytes:
    return content[: random.randrange(len(content) + 1)]


def duplicate(content: bytes, random: Random) -> bytes:
    begin, end = _piece(content, random)
    return content[:end] + content[begin:end] * random.choice((1, 1, 2, 20)) + content[end:]


def splice(content: bytes, random: Random) -> bytes:
    """A piece goes to another place."""
    begin, end = _piece(content, random)
    place = random.randrange(len(content) + 1)
    return content[:place] + content[begin:end] + content[place:]


def run(content: bytes, random: Random) -> bytes:
    """The same bytes over and over."""
    place = random.randrange(len(content) + 1)
    return content[:place] + random.choice(RUNS) * random.choice((1, 10, 300, 5000, 50_000)) + content[place:]


def number(content: bytes, random: Random) -> bytes:
    """One number, or all that are alike, becomes another."""
    found = list(NUMBER.finditer(content))
    if not found:
        return run(content, random)
    one, new = random.choice(found), random.choice(NUMBERS).encode()
    if random.random() < 0.2:
        return content.replace(one[0], new)
    return content[: one.start()] + new + content[one.end() :]


def lines(content: bytes, random: Random) -> bytes:
    """A line is left out, doubled, moved, or ends otherwise."""
    rows = content.split(b"\n")
    place, other = random.randrange(len(rows)), random.randrange(len(rows))
    what = random.randrange(5)
    if what == 0:
        del rows[place]
    elif what == 1:
        rows.insert(other, rows[place])
    elif what == 2:
        rows[place], rows[other] = rows[other], rows[place]
    elif what == 3:
        return random.choice((b"\r\n", b"\r", b"\n\n", b"\x0b", b"\xe2\x80\xa8")).join(rows)
    else:
        rows[place] = b""
    return b"\n".join(rows)


def columns(content: bytes, random: Random) -> bytes:
    """Columns are swapped, doubled, left out or parted otherwise, in one row or in all."""
    rows = content.split(b"\n")
    chosen = range(len(rows)) if random.random() < 0.5 else [random.randrange(len(rows))]
    what, at, to = random.randrange(5), random.randrange(8), random.randrange(8)
    for index in chosen:
        cells = rows[index].replace(b",", b" ").split(b" ")
        comma = b"," if b"," in rows[index] else b" "
        at_, to_ = at % len(cells), to % len(cells)
        if what == 0:
            cells[at_], cells[to_] = cells[to_], cells[at_]
        elif what == 1:
            cells.insert(to_, cells[at_])
        elif what == 2:
            del cells[at_]
        elif what == 3:
            comma = random.choice((b";", b"\t", b" , ", b"|", b"\xc2\xa0", b""))
        else:
            cells *= random.choice((2, 3000))
        rows[index] = comma.join(cells)
    return b"\n".join(rows)


BYTES: tuple[Mutation, ...] = (flip, cut, cut_short, duplicate, splice, run)
TEXT: tuple[Mutation, ...] = (*BYTES, number, number, number, lines, lines, columns)


def json_structure(content: bytes, random: Random) -> bytes:
    """A value becomes another, is nested, doubled or left out; an object has a key twice."""
    try:
        value = json.loads(content)
    except (ValueError, RecursionError):
        return flip(content, random)
    places = list(_places(value))
    if not places:
        return run(content, random)
    parent, key = random.choice(places)
    what = random.randrange(6)
    mark = "@@@"
    if what == 0:
        del parent[key]
        return json.dumps(value).encode()
    if what == 1:
        parent[key] = random.choice((None, True, [], {}, "", "x", 0, -1, 1.5, 10**30, [[]], {"a": 1}, -(2**63)))
        return json.dumps(value).encode()
    old = json.dumps(parent[key])
    parent[key] = mark
    depth = random.choice((3, 70, 1500, 30_000))
    new = (
        random.choice(NUMBERS),
        json.dumps(random.choice(WORDS)),
        random.choice(("[" * depth + "]" * depth, '{"a":' * depth + "1" + "}" * depth)),
        f"{old}, {json.dumps(key if isinstance(key, str) else 'x')}: {old}",
    )[what - 2]
    return json.dumps(value).replace(json.dumps(mark), new, 1).encode("utf-8", "surrogatepass")


JSON: tuple[Mutation, ...] = (*BYTES, number, number, *[json_structure] * 8)


def toml_structure(content: bytes, random: Random) -> bytes:
    """A value becomes another, is nested; a key is doubled, misspelt, dotted or left out."""
    rows = content.split(b"\n")
    keyed = [place for place, row in enumerate(rows) if b" = " in row]
    if not keyed:
        return lines(content, random)
    place = random.choice(keyed)
    key, _, value = rows[place].partition(b" = ")
    depth = random.choice((3, 70, 1500, 30_000))
    wrong = (b"true", b"2020-01-01", b"''", b"[]", b"{}", b"[{}, 1]", b"[nan, inf, -1, 5]")
    new = random.choice(
        [
            key + b" = " + random.choice(NUMBERS).encode(),
            key + b" = " + json.dumps(random.choice(WORDS)).encode("utf-8", "surrogatepass"),
            key + b" = " + b"[" * depth + b"]" * depth,
            key + b" = " + b"{a=" * depth + b"1" + b"}" * depth,
            key + b" = [" + value + b"]",
            key + b" = 0x" + b"f" * random.choice((16, 5000)),
            key + b" = " + random.choice(wrong),
            key + b" = " + value + b"\n" + key + b" = " + value,
            key + b"x = " + value,
            key + b".a" * depth + b" = " + value,
            b"[" + b".".join([b"a"] * depth) + b"]\n" + key + b" = " + value,
            b"",
        ]
    )
    rows[place] = new
    return b"\n".join(rows)


TOML: tuple[Mutation, ...] = (*BYTES, number, number, number, lines, *[toml_structure] * 6)


def _piece(content: bytes, random: Random) -> tuple[int, int]:
    begin = random.randrange(len(content) + 1)
    return begin, min(len(content), begin + random.choice((1, 2, 10, 100, 1000)))


def _places(value: Any) -> Any:
    """Every (container, key) in a value of JSON."""
    if isinstance(value, dict | list):
        for key, child in value.items() if isinstance(value, dict) else enumerate(value):
            yield value, key
            yield from _places(child)
