from pathlib import Path

from setuptools import find_packages, setup

NAME = "tethernet_learning"

setup(
    name=NAME,
    version="0.1.0",
    description="Campaigns, data sets, training and evaluation of models: everything that is offline",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=find_packages(exclude=["test", "tests"]),
    package_data={"": ["config/*", "py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        ("share/" + NAME + "/config", [str(path) for path in Path(NAME).glob("policies/config/*.json")]),
    ],
    python_requires=">=3.11",
    install_requires=[
        "matplotlib",
        "numpy",
        "pyarrow",
        "pyyaml",
        "scipy",
        "tqdm",
        "tethernet_sim",
        "tethernet_planner",
        "tethernet_control",
        "tethernet_core",
    ],
    extras_require={
        "learning": ["cma", "gymnasium", "scikit-learn", "stable-baselines3", "torch"],
        "cluster": ["ray"],
        "test": ["pytest"],
    },
    zip_safe=False,
)
