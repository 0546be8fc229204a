from setuptools import find_packages, setup

NAME = "tethernet_ros"

setup(
    name=NAME,
    version="0.1.0",
    description="What all nodes share: checked subscriptions, quality of service, executor, parameters",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=find_packages(exclude=["test", "tests"]),
    package_data={"": ["config/*.yaml", "systems/*", "models/*", "py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
    ],
    python_requires=">=3.11",
    install_requires=["numpy", "tethernet_core"],
    extras_require={"test": ["pytest"]},
    zip_safe=False,
)
