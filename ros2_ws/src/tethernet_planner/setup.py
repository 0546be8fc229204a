from pathlib import Path

from setuptools import find_packages, setup

NAME = "tethernet_planner"

setup(
    name=NAME,
    version="0.1.0",
    description="Aiming points, mission sequencing and capture assessment; planner and assessor nodes",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=find_packages(exclude=["test", "tests"]),
    package_data={"": ["config/*.yaml", "config/*.json", "models/*", "py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        ("share/" + NAME + "/config", [str(path) for path in Path(NAME).glob("config/*.yaml")]),
    ],
    python_requires=">=3.11",
    install_requires=["numpy", "safetensors", "scipy", "tethernet_ros", "tethernet_core"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "planner = tethernet_planner.planner_node:main",
            "assessor = tethernet_planner.assessor_node:main",
        ],
    },
)
