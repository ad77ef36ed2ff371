"""Damage to files: kinds that have hurt readers of files before, and random mixtures of them."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator

NUMBERS = (
    *("2147483648", "-2147483649", "4294967296", "9223372036854775808", "18446744073709551616", "1" + "0" * 400),
    *("1" * 5000, "1e400", "-1e308", "1e-320", "nan", ".nan", "NaN", ".inf", "-.inf", "Infinity", "-1", "0", "0x10"),
    *("1_000", "1:30", "010", "1.", "true", "null", "", '""', "[]", "{}", "!!timestamp x", "!!bool x", "!!int x"),
    *("!!float x", "!!binary x", "!!set {a}", "!!python/object/apply:os.system [ls]", "!!opencv-matrix x", "!!str 1"),
    *("2001-01-01", "*a", "&a [*a]", "|\n  a", "? x", "- x", '"\\ud800"', '"\\U00110000"', '"\\u001b[2J"', '"\\0"'),
)
WORDS = (
    *("a" * 5000, "é" * 5000, "\x1b]0;x\x07", "\x00", "\x01", "\x7f", "\x85", "\u2028", "\u202e", "\ufeff", "\u0130"),
    *("../../../../etc/passwd", "/dev/zero", "a\nb", "[" * 3000, "{" * 3000, '{"a":' * 3000, "<a>" * 3000, "'", '"'),
    *("!!timestamp x", "!!bool x", "!!map [1]", "? [a, b]\n: c\n", "? |\n  a\n: b\n", "<<: *x", "%n%s", "&#0;", "~"),
)
_NUMBER = re.compile(r"-?\d+\.?\d*(?:[eE][-+]?\d+)?")
_WORD = re.compile(r"[A-Za-z_][\w.]*")

WHOLE: dict[str, bytes] = {
    "empty": b"",
    "newline": b"\n",
    "a word": b"x",
    "a number": b"1",
    "null": b"null",
    "list": b"[1, 2]",
    "object": b"{}",
    "tag of a text": b"!!timestamp x\n",
    "tag of a truth value": b"!!bool x\n",
    "tag of a number": b"!!int x\n",
    "tag of a mapping": b"!!map [a]\n",
    "tag of a matrix": b"!!opencv-matrix\nrows: 2147483648\ncols: 0\ndt: d\ndata: []\n",
    "tag of Python": b"!!python/object/apply:os.system [ls]\n",
    "complex key": b"? [a, b]\n: c\n",
    "block key": b"? |\n  a\n: b\n",
    "key of a number": b"1: a\n",
    "key with control characters": b'"\\e]0;x\\a": a\n',
    "nested lists": b"[" * 300_000,
    "nested objects": b'{"a":' * 100_000,
    "nested mappings": b"".join(b" " * n + b"a:\n" for n in range(1000)),
    "nested lists of blocks": b"- " * 100_000,
    "aliases of aliases": b"a0: &a0 [x, x]\n"
    + b"".join(b"a%d: &a%d [*a%d, *a%d]\n" % (n, n, n - 1, n - 1) for n in range(1, 60)),
    "merged aliases": b"a0: &a0 {x: 1}\n"
    + b"".join(b"a%d: &a%d {<<: [*a%d, *a%d]}\n" % (n, n, n - 1, n - 1) for n in range(1, 60)),
    "alias within itself": b"a: &a [*a]\n",
    "entities of entities": b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "aaaaaaaaaa">'
    + b"".join(b'<!ENTITY %c "&%c;&%c;&%c;&%c;">' % (n, n - 1, n - 1, n - 1, n - 1) for n in range(98, 120))
    + b"]><opencv_storage><a>&w;</a></opencv_storage>",
    "zeros": bytes(1_000_000),
    "binary": bytes(range(256)) * 100,
    "UTF-16": "name: x\n".encode("utf-16"),
    "not UTF-8": b"name: \xff\xfe.png\n",
    "two documents": b"a: 1\n---\nb: 2\n",
    "version": b"%YAML 9.9\n---\na: 1\n",
    "header alone": b"%YAML:1.0\n",
    "directives": b"%TAG ! tag:x,2000:\n---\n!a b\n",
    "huge PGM": b"P5 2147483647 2147483647 255\n",
    "huge plain PGM": b"P2 16384 9000 255\n1",
}
"""Contents that have nothing to do with the good file."""

LARGE: dict[str, bytes] = {
    "nested elements": b"<opencv_storage>" + b"<a>" * 100_000 + b"</a>" * 100_000 + b"</opencv_storage>",
    "long text": b"a: " + b"x" * 900_000,
    "long line": b"x" * 1_500_000,
    "many values": b"a: [" + b"1," * 500_000 + b"1]",
    "many keys": b"".join(b"k%d: 1\n" % n for n in range(90_000)),
    "many lines": b"1\n" * 450_000,
    "many rows": b"".join(b"%d,x.png\n" % (n * 10**8) for n in range(110_000)),
    "many poses": b"".join(b"%d 1 2 3 0 0 0 1\n" % n for n in range(110_000)),
    "too large": b"# \n" * 2_000_000,
}
"""Contents of about the size of what is still read."""

SAME: dict[str, Callable[[bytes], bytes]] = {
    "byte order mark": lambda data: b"\xef\xbb\xbf" + data,
    "CRLF": lambda data: data.replace(b"\n", b"\r\n"),
    "both": lambda data: b"\xef\xbb\xbf" + data.replace(b"\n", b"\r\n"),
}
"""Changes of a text file that change nothing of what it says."""


def damaged(data: bytes) -> Iterator[tuple[str, bytes]]:
    """Damage of every kind to a good file, with its name; the same for the same file."""
    for count in (1, len(data) // 3, len(data) - 2):
        yield f"cut at {count}", data[:count]
    yield "twice", data + data
    yield "lines twice", b"".join(line * 2 for line in data.splitlines(keepends=True))
    yield "a line less", b"".join(data.splitlines(keepends=True)[1:])
    yield "NUL", data[: len(data) // 2] + b"\0" + data[len(data) // 2 :]
    yield "not UTF-8", data[: len(data) // 2] + b"\xff\xfe" + data[len(data) // 2 :]
    for kind, pattern, values in (("number", _NUMBER, NUMBERS), ("word", _WORD, WORDS)):
        places = list(pattern.finditer(data.decode("latin-1")))
        for index, value in enumerate(values):
            for place in places[index % 7 :: max(7, len(places) // 2)]:
                label = f"{kind} at {place.start()} as {value[:30]!r}"
                yield label, data[: place.start()] + value.encode("utf-8", "surrogatepass") + data[place.end() :]


def mutated(data: bytes, rng: random.Random) -> bytes:
    """A random mixture of damage; the same for the same state of the generator."""
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        data = rng.choice(_MUTATIONS)(data, rng)
    return data[: 1 << 22]


def _at(data: bytes, rng: random.Random) -> int:
    return rng.randrange(len(data) + 1)


def _flip(data: bytes, rng: random.Random) -> bytes:
    at = _at(data, rng)
    return data[:at] + bytes([rng.randrange(256)]) + data[at + 1 :]


def _insert(data: bytes, rng: random.Random) -> bytes:
    at = _at(data, rng)
    value = rng.choice((*NUMBERS, *WORDS, "\n", ",", ":", " ", "- ", "\t", "#", "-"))
    return data[:at] + value.encode("utf-8", "surrogatepass") + data[at:]


def _cut(data: bytes, rng: random.Random) -> bytes:
    first, last = sorted((_at(data, rng), _at(data, rng)))
    return data[:first] + data[last:] if rng.random() < 0.7 else data[:first]


def _copy(data: bytes, rng: random.Random) -> bytes:
    first, last = sorted((_at(data, rng), _at(data, rng)))
    at = _at(data, rng)
    return data[:at] + data[first:last][:2000] * rng.choice((1, 2, 50)) + data[at:]


def _line(data: bytes, rng: random.Random) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    line = lines.pop(rng.randrange(len(lines)))
    for _ in range(rng.randrange(3)):
        lines.insert(rng.randrange(len(lines) + 1), line)
    return b"".join(lines)


def _token(data: bytes, rng: random.Random) -> bytes:
    pattern, values = rng.choice(((_NUMBER, NUMBERS), (_WORD, WORDS), (_NUMBER, WORDS), (_WORD, NUMBERS)))
    places = list(pattern.finditer(data.decode("latin-1")))
    if not places:
        return data
    place, value = rng.choice(places), rng.choice(values)
    return data[: place.start()] + value.encode("utf-8", "surrogatepass") + data[place.end() :]


def _same(data: bytes, rng: random.Random) -> bytes:
    return rng.choice(list(SAME.values()))(data)


def _whole(data: bytes, rng: random.Random) -> bytes:
    other = rng.choice(list((WHOLE | LARGE).values()))[:5000]
    return other if rng.random() < 0.2 else data + other


_MUTATIONS = (_flip, _flip, _insert, _insert, _cut, _copy, _line, _token, _token, _token, _token, _same, _whole)
