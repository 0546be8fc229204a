"""The set-up: from a plain Python, cmake and g++ to an environment in which missions fly.

Standard library only. ``run_mission.py`` and ``analyse_mission.py`` call :func:`bootstrap.launch.launch`, the
Makefile calls ``python3 -m bootstrap PROFILE``. Two environments are possible:

- ``.venv`` in the repository: ROS 2 Jazzy from wheels, the messages built into it. Made step by step, each step
  recorded with a fingerprint of what it depends on (:mod:`bootstrap.steps`), so that a second start does nothing, a
  change repeats only what depends on it, and an interrupted set-up goes on or starts anew as is safe.
- a machine's own ROS 2 Jazzy with the workspace built by colcon (:mod:`bootstrap.ros`).
"""
