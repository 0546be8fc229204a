"""``python3 -m bootstrap PROFILE... [-- ARGUMENTS]``: set up for some uses, then run the environment's Python."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from .python_version import require_allowed


def main(argv: Sequence[str]) -> None:
    """Set up; with ``--`` go on as the environment's Python with the arguments behind it."""
    # Before the other imports: they may need a newer Python than this one.
    require_allowed(["-m", "bootstrap", *argv])
    from .launch import prepare, run_in
    from .steps import PROFILES

    given = list(argv)
    behind = given[given.index("--") + 1 :] if "--" in given else []
    parser = argparse.ArgumentParser(
        prog="python3 -m bootstrap", usage="%(prog)s [--fresh] PROFILE [PROFILE ...] [-- ARGUMENTS]"
    )
    parser.add_argument(
        "profiles", nargs="+", metavar="PROFILE", choices=sorted(PROFILES), help=f"one of {', '.join(sorted(PROFILES))}"
    )
    parser.add_argument("--fresh", action="store_true", help="make the environment anew")
    options = parser.parse_args(given[: given.index("--")] if "--" in given else given)
    python, environment = prepare(options.profiles, fresh=options.fresh)
    if behind:
        run_in([python, *behind], environment)
    print(f"The environment is ready: {python}")


if __name__ == "__main__":
    main(sys.argv[1:])
