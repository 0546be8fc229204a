from pathlib import Path

from setuptools import find_packages, setup

NAME = "tethernet_sim"

setup(
    name=NAME,
    version="0.1.0",
    description="Simulator of net, tether, debris and chaser; batch engine; simulator node",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=find_packages(exclude=["test", "tests"]),
    package_data={"": ["config/*", "models/*", "py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        ("share/" + NAME + "/config", [str(path) for path in Path(NAME).glob("config/*.yaml")]),
    ],
    python_requires=">=3.11",
    install_requires=[
        "matplotlib",
        "numba",
        "numpy",
        "pyyaml",
        "scipy",
        "tethernet_planner",
        "tethernet_control",
        "tethernet_ros",
        "tethernet_core",
    ],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
    entry_points={
        "console_scripts": [
            "sim = tethernet_sim.ros.sim_node:main",
        ],
    },
)
