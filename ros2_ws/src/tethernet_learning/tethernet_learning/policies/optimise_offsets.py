"""Optimise one set of offsets with CMA-ES (``python -m tethernet_learning.policies.optimise_offsets``)."""

from __future__ import annotations

if __name__ == "__main__":
    from tethernet_core.quiet_start import command_start

    command_start()

import argparse
import dataclasses
import sys
from collections.abc import Sequence

from tethernet_core.command import command
from tethernet_learning import run_folder
from tethernet_learning.policies import run_options
from tethernet_learning.policies.offset_search import SearchSettings, search
from tethernet_learning.policies.train_policy import POLICY
from tethernet_learning.run_progress import Progress
from tethernet_planner.inference import model_file


@command
def main(argv: Sequence[str] | None = None) -> int:
    """Search. Returns 0; 2 for bad usage or a folder with another run."""
    parser = argparse.ArgumentParser(
        prog="python -m tethernet_learning.policies.optimise_offsets",
        description="Optimise one set of aiming offsets for all debris positions with CMA-ES: a baseline without "
        "learning, as a policy file. Killed and started again with the same words it goes on.",
    )
    run_options.add(parser, SearchSettings)
    options = run_options.parse(parser, argv)
    try:
        names = [field.name for field in dataclasses.fields(SearchSettings)]
        settings = SearchSettings(**{name: getattr(options, name) for name in names})
        source, reward, facts = run_options.prepare(settings, options.surrogate)
        run_folder.claim(options.output, {"command": "optimise_offsets", **facts})
        flown = settings.generations * settings.scenarios * settings.candidates
        progress = Progress(f"episodes with {settings.mus} MUs", flown)
        about = {"method": "cma-es", **facts, "commit": model_file.commit()}
        policy = search(options.output, settings, source, reward, progress.tell, about)
    except ValueError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    policy.save(options.output / POLICY)
    print(options.output / POLICY)
    print("offsets [m], MU 1 first: " + ", ".join(f"({x:.1f}, {y:.1f})" for x, y in policy.offsets((1.0, 0.0, -50.0))))
    return 0


if __name__ == "__main__":
    sys.exit(main())
