"""What holds for every node: how it starts, refuses, stops; what it must not import or overwrite."""

import ast
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rclpy
from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter

ROOT = Path(__file__).parents[2]
CONTROLLER, PLANNER, ASSESSOR = (
    "tethernet_control.controller_node",
    "tethernet_planner.planner_node",
    "tethernet_planner.assessor_node",
)
NODES = {CONTROLLER: ("mu3_controller", ["mu:=3"]), PLANNER: ("planner", []), ASSESSOR: ("assessor", [])}


def up(probe, name):
    probe.wait_for(lambda: name in probe.node.get_node_names(), f"node {name}")


@pytest.mark.parametrize("executor", ["events", "single"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("module", NODES)
def test_ends_cleanly_on_a_signal(probe, processes, module, number, executor):
    name, parameters = NODES[module]
    process = processes.node(module, *parameters, TETHERNET_EXECUTOR=executor)
    up(probe, name)
    begin = time.monotonic()
    process.send(number)
    assert process.wait() == 0
    assert time.monotonic() - begin < 3.0
    assert "Traceback" not in process.output


@pytest.mark.parametrize(
    ("module", "parameters", "words"),
    [
        (CONTROLLER, [], "mu_controller needs the parameter mu"),
        (CONTROLLER, ["mu:=9"], "mu = 9: system zenit_8mu has no such unit; allowed: 1 to 8"),
        (CONTROLLER, ["mu:=1.5"], "not a whole number"),
        (CONTROLLER, ["mu:=3", "kp:=-1.0"], "kp = -1.0: out of range; allowed: 0 to 10000 N/m"),
        (CONTROLLER, ["mu:=3", "kp:=.nan"], "not finite"),
        (CONTROLLER, ["mu:=3", "kp:=high"], "not a number"),
        (CONTROLLER, ["mu:=3", "gain:=3.0"], "mu3_controller has no parameter 'gain'; it has: "),
        (PLANNER, ["system:=zenit_5mu"], "no system 'zenit_5mu'"),
        (PLANNER, ["policy:=best"], "no policy named 'best'; allowed: nominal"),
        (PLANNER, ["debris_position:=[1.0, 2.0]"], "2 numbers; allowed: 3 (x y z) or none"),
        (PLANNER, ["simulated:=perhaps"], "not a bool; allowed: true or false"),
        (ASSESSOR, ["system:=zenit_5mu"], "no system 'zenit_5mu'"),
        (ASSESSOR, ["predictor:=oracle"], "no predictor named 'oracle'; allowed: none"),
        (ASSESSOR, ["progress_every:=0"], "out of range; allowed: 1 to 10000"),
    ],
)
def test_bad_parameters_end_with_status_2_and_say_what_is_allowed(processes, module, parameters, words):
    process = processes.node(module, *parameters, expected=2)
    assert process.wait() == 2
    assert words in process.output
    assert len(process.output.splitlines()) == 1


@pytest.mark.parametrize(
    "arguments", [["mu:=3"], ["--ros-args", "-p"], ["--ros-args", "--params-file", "/no/such.yaml"]]
)
def test_bad_arguments_end_with_status_2(processes, arguments):
    process = processes.start("controller", "-m", CONTROLLER, *arguments, expected=2)
    assert process.wait() == 2
    assert arguments[-1] in process.output


def test_an_exception_in_a_callback_is_told_and_ends_with_status_1(processes, tmp_path):
    program = tmp_path / "faulty.py"
    program.write_text(
        "from rclpy.node import Node\n"
        "from tethernet_ros.executor import run\n"
        "class Faulty(Node):\n"
        "    def __init__(self):\n"
        "        super().__init__('faulty')\n"
        "        self.create_timer(0.05, self.fail)\n"
        "    def fail(self):\n"
        "        raise ValueError('the reason')\n"
        "raise SystemExit(run(Faulty))\n"
    )
    for executor in ("events", "single"):
        process = processes.start(f"faulty_{executor}", str(program), TETHERNET_EXECUTOR=executor)
        process.expected = {1}
        assert process.wait() == 1
        assert "stopped by ValueError: the reason" in process.output
        process.log.write_text("")  # the traceback is wanted here


def test_who_hangs_in_the_middleware_when_he_leaves_is_ended(processes, tmp_path):
    program = tmp_path / "hanging.py"
    program.write_text(
        "import ctypes\n"
        "from rclpy.node import Node\n"
        "from tethernet_ros import executor\n"
        "executor._LEAVE_S = 0.5\n"
        "class Hanging(Node):\n"
        "    def __init__(self):\n"
        "        super().__init__('hanging')\n"
        "        self.create_timer(0.05, self.fail)\n"
        "    def fail(self):\n"
        "        raise ValueError('the reason')\n"
        "    def destroy_node(self):\n"
        "        print('hangs', flush=True)\n"
        "        ctypes.PyDLL(None).pause()  # with the interpreter's lock\n"
        "raise SystemExit(executor.run(Hanging))\n"
    )
    process = processes.start("hanging", str(program), expected=-signal.SIGALRM)
    assert process.wait() == -signal.SIGALRM
    assert "stopped by ValueError: the reason" in process.output
    assert process.output.endswith("hangs\n")
    process.log.write_text("")  # the traceback is wanted here


def test_parameters_are_described_typed_and_read_only(probe, processes):
    processes.node(CONTROLLER, "mu:=3", "kp:=12")
    node = "mu3_controller"
    listed = probe.call(f"/{node}/list_parameters", ListParameters).result.names
    assert {"mu", "kp", "watchdog_periods"} <= set(listed)
    [described] = probe.call(
        f"/{node}/describe_parameters", DescribeParameters, DescribeParameters.Request(names=["kp"])
    ).descriptors
    assert described.description == "Proportional gain [N/m]"
    assert described.read_only
    assert (described.floating_point_range[0].from_value, described.floating_point_range[0].to_value) == (0.0, 1e4)
    [value] = probe.call(f"/{node}/get_parameters", GetParameters, GetParameters.Request(names=["kp"])).values
    assert value.double_value == 12.0  # given as a whole number
    [result] = probe.call(
        f"/{node}/set_parameters",
        SetParameters,
        SetParameters.Request(parameters=[Parameter("kp", value=1.0).to_parameter_msg()]),
    ).results
    assert not result.successful


@pytest.mark.parametrize("module", [CONTROLLER, PLANNER])
def test_small_nodes_stay_small(module):
    heavy = ["scipy", "numba", "matplotlib", "torch", "mujoco", "tethernet_sim"]
    code = f"import sys, {module}; print([name for name in {heavy} if name in sys.modules])"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert result.stdout.strip() == "[]"


def test_no_node_overwrites_what_rclpy_keeps_on_it(domain_id):
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain_id)
    plain = rclpy.create_node("plain", context=context)
    taken = {name for name in {*vars(plain), *dir(plain)} if not name.startswith("__")}
    plain.destroy_node()
    context.try_shutdown()
    found = []
    for path in [
        *ROOT.glob("ros2_ws/src/*/*/*_node.py"),
        *ROOT.glob("ros2_ws/src/*/*/*driver*.py"),
        *ROOT.glob("examples/*.py"),
    ]:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            stored = isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
            if stored and isinstance(node.value, ast.Name) and node.value.id == "self" and node.attr in taken:
                found.append(f"{path.name}:{node.lineno} {node.attr}")
    assert found == []
