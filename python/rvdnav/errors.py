"""The exceptions that the package raises on purpose."""

from __future__ import annotations

_LONGEST = 400
_KEPT = (240, 140)
"""Of a longer message: how much of its beginning, which names the file, and of its end, which tells the fault."""


def one_line(text: str) -> str:
    """A text as one line for a terminal: what cannot be printed as escapes, a long one without its middle."""
    if len(text) > _LONGEST:
        text = f"{text[: _KEPT[0]]} … {text[-_KEPT[1] :]}"
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


class RvdnavError(Exception):
    """Base of all of them."""


class InputError(RvdnavError):
    """The user's data are bad.

    The message is one printable line that names the file and the fault, ``<file>: <fault>``; see `one_line`.
    """

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class CoreError(RvdnavError):
    """The C core refused a call.

    ``status`` is the negative code of the C ABI, ``str(error)`` its text.
    """

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = status
