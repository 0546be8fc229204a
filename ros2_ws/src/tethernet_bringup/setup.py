from pathlib import Path

from setuptools import find_packages, setup

NAME = "tethernet_bringup"

setup(
    name=NAME,
    version="0.1.0",
    description="Starts, watches, records and analyses a mission",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=find_packages(exclude=["test", "tests"]),
    package_data={"": ["config/*", "models/*", "py.typed", "viewer/*", "*.js", "*.css", "*.json", "*.LICENSE"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        (
            "share/" + NAME + "/config",
            [*sorted(map(str, Path("config").iterdir())), *map(str, Path(NAME).glob("*/config/*.yaml"))],
        ),
    ],
    python_requires=">=3.11",
    install_requires=[
        "lz4",
        "matplotlib",
        "mcap",
        "numpy",
        "pyyaml",
        "rosbags",
        "zstandard",
        "tethernet_learning",
        "tethernet_sim",
        "tethernet_planner",
        "tethernet_control",
        "tethernet_ros",
        "tethernet_core",
    ],
    extras_require={"test": ["pytest"], "view": ["rerun-sdk"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "run_mission = tethernet_bringup.mission.command_line:main",
            "analyse_mission = tethernet_bringup.analysis.command_line:main",
            "view_mission = tethernet_bringup.view.command_line:main",
            "viewer = tethernet_bringup.view.viewer_node:main",
            "recorder = tethernet_bringup.recorder.recorder_node:main",
            "tethernet = tethernet_bringup.cli.start:start",
        ],
    },
)
