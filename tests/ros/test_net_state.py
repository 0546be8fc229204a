"""A net's state is read from the bytes as the middleware would have read it, and nothing else passes for one."""

import math
import struct

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message

from tests.ros.sound import net_state
from tethernet_core.bounds import FARTHEST_M, FASTEST_M_S
from tethernet_core.system import load_system
from tethernet_msgs.msg import NetState
from tethernet_ros import checks
from tethernet_ros.conversions import coordinates
from tethernet_ros.net_state import blank_net_state
from tethernet_ros.well_formed import MessageError

STAMP_NS = 17_650_000_000
ARRAYS = ("knot_positions", "knot_velocities", "mu_positions", "mu_velocities")
SYSTEMS = ("zenit_8mu", "zenit_4mu", "hexagonal_6mu")


def full(system, seed=0) -> NetState:
    """Every number another one."""
    generator = np.random.default_rng(seed)
    message = net_state(system, STAMP_NS)
    for name in ARRAYS:
        count = len(getattr(message, name))
        setattr(message, name, generator.normal(0.0, 20.0, count).astype(np.float32).tolist())
    for point in (message.center_of_mass, message.center_of_mass_all):
        point.x, point.y, point.z = generator.normal(0.0, 20.0, 3).tolist()
    message.tether_length, message.tether_tension, message.load_share, message.max_load_share = 1.0, 2.0, 3.0, 4.0
    message.contact_force, message.max_contact_force = 5.0, 6.0
    message.locked = (generator.random(len(message.locked)) < 0.5).tolist()
    return message


def big_endian(data: bytes) -> bytes:
    """The same message as a machine of the other kind writes it: after the texts every field has one size."""
    system = load_system("zenit_8mu")
    sizes = [4, 4, 4]  # stamp, length of frame_id
    counts = [3 * system.net.node_count] * 2 + [3 * system.unit_count] * 2
    out, at = bytearray(data), 4

    def swap(size: int, count: int = 1) -> None:
        nonlocal at
        at += (4 - at) % size
        for begin in range(at, at + size * count, size):
            out[begin : begin + size] = out[begin : begin + size][::-1]
        at += size * count

    for size in sizes:
        swap(size)
    at += len("launch") + 1
    swap(8, 3)
    swap(1)
    swap(8, 3)
    swap(2, 2)
    for count in counts:
        swap(4)
        swap(4, count)
    swap(4)
    swap(1, system.closing.max_locked_pairs)
    swap(8, 2)
    for _ in range(2):
        swap(1)
        swap(8, 2)
    assert at == len(data)
    out[:2] = b"\x00\x00"
    return bytes(out)


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize("name", SYSTEMS)
def test_what_is_read_is_what_the_message_says(name, known):
    system = load_system(name)
    message = full(system)
    message.center_of_mass_all_valid = message.load_share_valid = message.contact_force_valid = known
    found = checks.net_state(system).read(bytes(serialize_message(message)))
    assert found.stamp_ns == STAMP_NS
    assert found.center == coordinates(message.center_of_mass)
    assert found.center_all == (coordinates(message.center_of_mass_all) if known else None)
    for array in ARRAYS:
        expected = np.array(getattr(message, array), np.float32).reshape(-1, 3)
        assert np.array_equal(getattr(found, array), expected), array
    assert found.locked == list(message.locked)
    if known:
        assert (found.max_load_share, found.max_contact_force) == (4.0, 6.0)
    else:
        assert math.isnan(found.max_load_share)
        assert math.isnan(found.max_contact_force)


def test_the_other_byte_order_says_the_same():
    system = load_system("zenit_8mu")
    data = bytes(serialize_message(full(system)))
    other = big_endian(data)
    assert deserialize_message(other, NetState) == deserialize_message(data, NetState)
    found, expected = (checks.net_state(system).read(given) for given in (other, data))
    assert (found.stamp_ns, found.center, found.locked) == (expected.stamp_ns, expected.center, expected.locked)
    for array in ARRAYS:
        assert np.array_equal(getattr(found, array), getattr(expected, array)), array


@pytest.mark.parametrize("name", ARRAYS)
def test_every_number_of_an_array_has_its_limit(name):
    system = load_system("zenit_8mu")
    limit = FASTEST_M_S if name.endswith("velocities") else FARTHEST_M
    check, message = checks.net_state(system), full(system)
    numbers = list(getattr(message, name))
    for index in (0, 1, len(numbers) - 1):
        for value in (limit, -limit):
            setattr(message, name, [*numbers[:index], value, *numbers[index + 1 :]])
            assert getattr(check.read(bytes(serialize_message(message))), name).ravel()[index] == value
        for value in (1.0001 * limit, -1.0001 * limit, 3e38, math.inf, -math.inf, math.nan):
            setattr(message, name, [*numbers[:index], value, *numbers[index + 1 :]])
            with pytest.raises(MessageError, match=f"{name} reaches .*; allowed: finite, within"):
                check.read(bytes(serialize_message(message)))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"rows": 3}, "3 rows and"),
        ({"columns": 3}, "and 3 columns"),
        ({"locked": [True]}, "the number of locked is 1; allowed:"),
        ({"knot_positions": [0.0] * 3}, "knot_positions has 3 numbers; allowed: "),
        ({"mu_velocities": []}, "mu_velocities has 0 numbers; allowed: 24"),
        ({"tether_length": math.nan}, "tether"),
    ],
)
def test_another_net_is_refused(change, said):
    system = load_system("zenit_8mu")
    message = full(system)
    for name, value in change.items():
        setattr(message, name, value)
    with pytest.raises(MessageError, match=said):
        checks.net_state(system).read(bytes(serialize_message(message)))


def test_another_frame_or_stamp_and_cut_bytes_are_refused():
    system = load_system("zenit_8mu")
    check, message = checks.net_state(system), full(system)
    data = bytes(serialize_message(message))
    for length in (0, 3, 4, 20, len(data) // 2, len(data) - 8):
        with pytest.raises(MessageError, match="that are no NetState"):
            check.read(data[:length])
    with pytest.raises(MessageError, match="allowed: from 0 s on, less than 1e9 ns"):
        check.read(data[:4] + struct.pack("<iI", 1, 1_000_000_000) + data[12:])
    message.header.frame_id = "moon"
    with pytest.raises(MessageError, match="in frame 'moon'; allowed: 'launch'"):
        check.read(bytes(serialize_message(message)))


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_blank_message_fits_its_system_and_no_other(name):
    data = bytes(serialize_message(blank_net_state(load_system(name))))
    for other in SYSTEMS:
        check = checks.net_state(load_system(other))
        if other == name:
            assert check.read(data).stamp_ns == 0
        else:
            with pytest.raises(MessageError, match="allowed"):
                check.read(data)
