"""``python -m rvdnav``: the program where its script is not on the path."""

from rvdnav.cli import main

main()
