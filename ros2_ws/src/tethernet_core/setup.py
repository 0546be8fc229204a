from pathlib import Path

from setuptools import find_packages, setup

NAME = "tethernet_core"

setup(
    name=NAME,
    version="0.1.0",
    description="System descriptions, shapes, frames, parameters, mission rules, capture quality",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=find_packages(exclude=["test", "tests"]),
    package_data={"": ["config/*.yaml", "systems/*", "models/*", "py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        ("share/" + NAME + "/config", [str(path) for path in Path(NAME).glob("config/*.yaml")]),
        ("share/" + NAME + "/systems", [str(path) for path in Path(NAME).glob("systems/*.yaml")]),
    ],
    python_requires=">=3.11",
    install_requires=["matplotlib", "numpy", "pyyaml", "scipy", "trimesh"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
