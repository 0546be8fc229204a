"""``ros2 bag info``: the stock one reads through rosbag2's C++ library, which no wheel has; here rosbags reads."""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path

from ros2cli.command import CommandExtension

from .bag_information import UnreadableBagError, describe

OTHERS = "`ros2 bag record` and `ros2 bag play` need ROS 2 on the machine or in a container."


class BagCommand(CommandExtension):
    """What a bag holds (info); recording and playing need a machine's own ROS 2."""

    def add_arguments(self, parser: ArgumentParser, cli_name: str) -> None:
        """Declare the verb and the bag."""
        parser.description = f"{self.__doc__}"
        parser.epilog = OTHERS
        verbs = parser.add_subparsers(metavar=f"Call `{cli_name} <verb> -h` for more detailed usage.", dest="verb")
        info = verbs.add_parser("info", help="Print what a bag holds: time, topics, types, counts")
        info.add_argument("bag", type=Path, help="the bag's folder, or its .mcap or .db3 file")
        info.add_argument("-s", "--storage", help="taken from the bag; accepted for the stock command's sake")
        self._parser = parser

    def main(self, *, parser: ArgumentParser, args: Namespace) -> int:
        """Run the verb; 0 done, 1 no bag that can be read."""
        if args.verb is None:
            self._parser.print_help()
            return 0
        try:
            text = describe(args.bag)
        except (OSError, UnreadableBagError) as error:
            print(f"{args.bag} cannot be read: {str(error).rstrip('.')}.", file=sys.stderr)
            return 1
        print(text)
        return 0
