"""The exceptions that the package raises on purpose."""

from __future__ import annotations


class RvdnavError(Exception):
    """Base of all of them."""


class InputError(RvdnavError):
    """The user's data are bad.

    The message is one line that names the file and the fault: ``<file>: <fault>``.
    """


class CoreError(RvdnavError):
    """The C core refused a call.

    ``status`` is the negative code of the C ABI, ``str(error)`` its text.
    """

    def __init__(self, status: int, text: str) -> None:
        super().__init__(text)
        self.status = status
