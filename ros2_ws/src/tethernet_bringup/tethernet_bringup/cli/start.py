"""How the process of the command ``tethernet`` begins."""


def start() -> int:
    """The console script; gives the exit status."""
    from tethernet_core.quiet_start import command_start

    command_start()  # before all other imports

    from tethernet_bringup.cli.main import load, main

    load()  # while a signal still ends the process without a word, whatever is just being imported
    return main()
