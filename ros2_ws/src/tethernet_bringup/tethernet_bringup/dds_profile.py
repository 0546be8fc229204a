"""How the nodes of a mission talk on one machine: a profile for Fast DDS, ROS 2's default middleware.

A dozen processes that start together tell each other of some hundred endpoints at once. Over UDP that overflows the
sockets' receive buffers, and what is lost comes again only seconds later; so discovery among them goes through shared
memory too, in queues long enough that a process may stall for a second. UDP stays for whoever joins from elsewhere, as
``ros2 topic echo`` or the driver of a real MU; with discovery on this machine only, it is bound to the loopback
interface, which the LOCALHOST range of ROS 2 alone would not do.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

FILE_NAME = "fast_dds.xml"
FILE_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""Environment variables that name a profile: of Fast DDS 2, and of Fast DDS 3."""

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_MIDDLEWARES = ("", "rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp")
_SEGMENT_BYTES = 4 << 20
_QUEUE_LENGTH = 4096
_MOST_PARTICIPANTS = 32

_PROFILE = """\
<?xml version="1.0" encoding="UTF-8" ?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <profiles>
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>shared_memory</transport_id>
        <type>SHM</type>
        <maxInitialPeersRange>{participants}</maxInitialPeersRange>
        <segment_size>{segment}</segment_size>
        <port_queue_capacity>{queue}</port_queue_capacity>
      </transport_descriptor>
      <transport_descriptor>
        <transport_id>udp</transport_id>
        <type>UDPv4</type>
        <maxInitialPeersRange>{participants}</maxInitialPeersRange>{whitelist}
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="tethernet" is_default_profile="true">
      <rtps>
        <propertiesPolicy>
          <properties>
            <property><name>fastdds.shm.enforce_metatraffic</name><value>unicast</value></property>
          </properties>
        </propertiesPolicy>
        <userTransports>
          <transport_id>shared_memory</transport_id>
          <transport_id>udp</transport_id>
        </userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>{peers}
      </rtps>
    </participant>
  </profiles>
</dds>
"""
_LOOPBACK_ONLY = """
        <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>"""
_LOOPBACK_PEER = """
        <builtin>
          <initialPeersList>
            <locator><udpv4><address>127.0.0.1</address></udpv4></locator>
          </initialPeersList>
        </builtin>"""


def profile(localhost: bool) -> str:
    """The profile as XML.

    Args:
        localhost: whether to stay on this machine.
    """
    return _PROFILE.format(
        participants=_MOST_PARTICIPANTS,
        segment=_SEGMENT_BYTES,
        queue=_QUEUE_LENGTH,
        whitelist=_LOOPBACK_ONLY if localhost else "",
        peers=_LOOPBACK_PEER if localhost else "",
    )


def use_profile(environment: Mapping[str, str], folder: Path) -> dict[str, str]:
    """The environment with which the nodes use the profile; the same one where that is not ours to decide.

    That is where the user has chosen another middleware or a profile of his own.

    Args:
        environment: of the nodes, with the discovery range.
        folder: gets the file.

    Raises:
        OSError: when the file cannot be written.
    """
    chosen = environment.get("RMW_IMPLEMENTATION", "") not in _MIDDLEWARES
    if chosen or any(environment.get(name) for name in FILE_VARIABLES):
        return dict(environment)
    path = folder / FILE_NAME
    localhost = environment[_RANGE] == "LOCALHOST"
    path.write_text(profile(localhost), encoding="utf-8")
    changed = {**environment, **dict.fromkeys(FILE_VARIABLES, str(path))}
    if localhost:
        # LOCALHOST would put transports of its own beside those of the profile, which stay on this machine anyway.
        changed[_RANGE] = "SYSTEM_DEFAULT"
    return changed
