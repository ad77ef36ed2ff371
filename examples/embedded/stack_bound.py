"""The deepest stack of a bare-metal program, from its compiler's call graph: stack_bound.py BUILD PROGRAM

GCC writes it with -fcallgraph-info=su, a .ci file beside each object file.  Fails where the stack may be too small, a
function may call itself, through others too, or a frame's size is not fixed.  What is called through a pointer is
one of the functions in the program that nobody calls by name.  Functions of the compiler's and the C library are not in
the graph: each is taken to need no more than LIBRARY_FRAME.
"""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

LIBRARY_FRAME = 256  # bytes; they are arithmetic and copies, most of them hand-written assembly
INDIRECT = "__indirect_call"
ROOT = "board_run"
ENTRIES = {"start", ROOT, "main"}  # that nobody calls by name, nor through a pointer

NODE = re.compile(r'node: \{ title: "([^"]+)" label: "[^"]*?(\d+) bytes \(([a-z,]+)\)')
EDGE = re.compile(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"')


def symbols(program: Path) -> dict[str, int]:
    """Address of every name that the linker left in the program."""
    listed = subprocess.run(["arm-none-eabi-nm", str(program)], check=True, capture_output=True, text=True).stdout
    return {name: int(address, 16) for address, _, name in map(str.split, listed.splitlines())}


class CallGraph:
    """Frames in bytes and calls by name, of the core and one program."""

    def __init__(self, build: Path, program: str) -> None:
        self.frames: dict[str, int] = {}
        self.calls: dict[str, set[str]] = {}
        for folder in ("csrc/CMakeFiles/rvdnav_core.dir", f"examples/embedded/CMakeFiles/{program}.dir"):
            for file in (build / folder).rglob("*.ci"):
                self._read(file.read_text())
        called = set().union(*self.calls.values())
        linked = symbols(build / "examples/embedded" / program)
        self.stack_size = linked["stack_top"] - linked["stack_bottom"]
        self.calls[INDIRECT] = {
            name for name in self.frames.keys() - called - ENTRIES if name.rpartition(":")[2] in linked
        }

    def _read(self, text: str) -> None:
        for name, size, kind in NODE.findall(text):
            if kind != "static":
                raise SystemExit(f"the frame of {name} has no fixed size")
            self.frames[name] = max(int(size), self.frames.get(name, 0))
        for source, target in EDGE.findall(text):
            self.calls.setdefault(source, set()).add(target)

    def deepest(self) -> tuple[int, list[str]]:
        """Bytes of the deepest stack from ROOT on, and its calls."""
        open_calls: list[str] = []

        @cache
        def below(name: str) -> tuple[int, tuple[str, ...]]:
            if name in open_calls:
                raise SystemExit("recursion: " + " > ".join([*open_calls[open_calls.index(name) :], name]))
            open_calls.append(name)
            depth, path = max((below(callee) for callee in self.calls.get(name, ())), default=(0, ()))
            open_calls.pop()
            own = 0 if name == INDIRECT else self.frames.get(name, LIBRARY_FRAME)
            return own + depth, (name, *path)

        for name in self.frames:
            below(name)  # looks for recursion where the program does not come, too
        depth, path = below(ROOT)
        return depth, [name for name in path if name != INDIRECT]


if __name__ == "__main__":
    graph = CallGraph(Path(sys.argv[1]), sys.argv[2])
    depth, path = graph.deepest()
    print(f"{depth} bytes at most of {graph.stack_size}:")
    for name in path:
        print(f"{graph.frames.get(name, LIBRARY_FRAME):7} {name}")
    if depth > graph.stack_size:
        raise SystemExit("the stack may be too small")
