from setuptools import setup

setup(
    name="ros2cli_wheels",
    version="0.1.0",
    description="The stock ros2 command beside ROS 2 from wheels: the variables that sourcing would set, and bag info",
    license="Apache-2.0",
    maintainer="tethernet maintainers",
    maintainer_email="maintainers@tethernet.invalid",
    packages=["ros2cli_wheels"],
    python_requires=">=3.11",
    install_requires=["ros2cli", "rosbags"],
    zip_safe=False,
    entry_points={
        "console_scripts": ["ros2 = ros2cli_wheels.start:main"],
        "ros2cli.command": ["bag = ros2cli_wheels.bag:BagCommand"],
    },
)
