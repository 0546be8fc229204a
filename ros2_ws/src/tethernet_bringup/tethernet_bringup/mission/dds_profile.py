"""How the nodes of a mission talk on one machine: a profile for Fast DDS, ROS 2's default middleware.

A dozen processes that start together tell each other of some hundred endpoints at once. Over UDP that overflows the
sockets' receive buffers, and what is lost comes again only seconds later; so discovery among them goes through shared
memory too, in queues long enough that a process may stall for a second. UDP stays for whoever joins from elsewhere, as
``ros2 topic echo`` or the driver of a real MU; with discovery on this machine only, it is bound to the loopback
interface, which the LOCALHOST range of ROS 2 alone would not do.

What is lost in spite of that comes again with the next announcement, by default five within half a second and then one
in three seconds. Nodes that join within half a second miss each other's so often that a mission would wait for the late
one before almost every launch; so each announces itself ten times a second for as long as a mission takes to start. An
announcement costs its sender 0.3 ms of CPU time.

A participant that is silent for its lease is given up by the others, each of which looks for that with a timer of so
long a period. In Fast DDS 2.14 a process hangs for good, when such a timer fires in the moment in which another
participant takes its endpoints away (issue 6502 of Fast-DDS: the event thread waits for the discovery's lock, whose
holder waits for the event thread). With the 20 s of the default the timers of processes that were started together
fire together, and a mission that ends then leaves nodes that do not. The lease here outlasts missions; that a process
has died the mission learns otherwise, from the supervisor and by the age of what it publishes.

A mission obeys nobody but itself: what only its own nodes may publish is read in a DDS partition that no other mission
and no tool is in, so that a stranger's messages are never delivered. Its writers are in the default partition too,
where everybody may listen.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from html import escape  # that of xml.sax imports a client for HTTP
from pathlib import Path

FILE_NAME, ASIDE_FILE_NAME = "fast_dds.xml", "fast_dds_aside.xml"
"""Names of the profiles: of the nodes that fly, and of those that only look on."""
FILE_VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""Environment variables that name a profile: of Fast DDS 2, and of Fast DDS 3."""

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_MIDDLEWARES = ("", "rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp")
_SEGMENT_BYTES = 4 << 20
_QUEUE_LENGTH = 4096
_MOST_PARTICIPANTS = 32
_LEASE_S = 600
_ANNOUNCEMENTS, _ANNOUNCED_EVERY_NS = 50, 100_000_000

_PROFILE = """\
<?xml version="1.0" encoding="UTF-8" ?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <profiles>
    <transport_descriptors>{shared_memory}
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
        <userTransports>{use_shared_memory}
          <transport_id>udp</transport_id>
        </userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>
        <builtin>
          <discovery_config>
            <initialAnnouncements>
              <count>{announcements}</count><period><sec>0</sec><nanosec>{announced_every}</nanosec></period>
            </initialAnnouncements>
            <leaseDuration><sec>{lease}</sec></leaseDuration>
          </discovery_config>{peers}
        </builtin>
      </rtps>
    </participant>{partitions}
  </profiles>
</dds>
"""
_SHARED_MEMORY = """
      <transport_descriptor>
        <transport_id>shared_memory</transport_id>
        <type>SHM</type>
        <maxInitialPeersRange>{participants}</maxInitialPeersRange>
        <segment_size>{segment}</segment_size>
        <port_queue_capacity>{queue}</port_queue_capacity>
      </transport_descriptor>"""
_USE_SHARED_MEMORY = """
          <transport_id>shared_memory</transport_id>"""
_PARTITION = """
    <data_{end} profile_name="{topic}">
      <propertiesPolicy>
        <properties><property><name>partitions</name><value>{names}</value></property></properties>
      </propertiesPolicy>
    </data_{end}>"""
_DEFAULT_PARTITION = ""
_LOOPBACK_ONLY = """
        <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>"""
_LOOPBACK_PEER = """
          <initialPeersList>
            <locator><udpv4><address>127.0.0.1</address></udpv4></locator>
          </initialPeersList>"""


def profile(localhost: bool, partition: str = "", exclusive: Iterable[str] = (), shared_memory: bool = True) -> str:
    """The profile as XML.

    Args:
        localhost: whether to stay on this machine.
        partition: in which the exclusive topics are read; empty: in the default one, as everything else.
        exclusive: topics that only nodes under this profile may publish.
        shared_memory: whether to talk through it. Whoever reads from a queue in shared memory locks it for a moment,
            and who stands still in that moment holds up all that write: nobody is held up by who hears over UDP.
    """
    queues = _SHARED_MEMORY.format(participants=_MOST_PARTICIPANTS, segment=_SEGMENT_BYTES, queue=_QUEUE_LENGTH)
    return _PROFILE.format(
        participants=_MOST_PARTICIPANTS,
        shared_memory=queues if shared_memory else "",
        use_shared_memory=_USE_SHARED_MEMORY if shared_memory else "",
        lease=_LEASE_S,
        announcements=_ANNOUNCEMENTS,
        announced_every=_ANNOUNCED_EVERY_NS,
        whitelist=_LOOPBACK_ONLY if localhost else "",
        peers=_LOOPBACK_PEER if localhost else "",
        partitions="".join(_partitions(partition, topic) for topic in exclusive) if partition else "",
    )


def _partitions(partition: str, topic: str) -> str:
    """ROS 2 looks for a profile named like the topic whenever it makes a writer or a reader."""
    ends = {"writer": (_DEFAULT_PARTITION, partition), "reader": (partition,)}
    return "".join(
        _PARTITION.format(end=end, topic=escape(topic), names=escape(";".join(names))) for end, names in ends.items()
    )


def uses_profile(environment: Mapping[str, str]) -> bool:
    """Whether the nodes get a profile of ours; not where the user has chosen a middleware or a profile of his own."""
    chosen = environment.get("RMW_IMPLEMENTATION", "") not in _MIDDLEWARES
    return not chosen and not any(environment.get(name) for name in FILE_VARIABLES)


def use_profile(
    environment: Mapping[str, str],
    folder: Path,
    partition: str = "",
    exclusive: Iterable[str] = (),
    shared_memory: bool = True,
) -> dict[str, str]:
    """The environment with which the nodes use the profile; the same one where :func:`uses_profile` says no.

    Args:
        environment: of the nodes, with the discovery range.
        folder: gets the file.
        partition: as in :func:`profile`.
        exclusive: likewise.
        shared_memory: likewise.

    Raises:
        OSError: when the file cannot be written.
    """
    if not uses_profile(environment):
        return dict(environment)
    path = folder / (FILE_NAME if shared_memory else ASIDE_FILE_NAME)
    localhost = environment[_RANGE] == "LOCALHOST"
    path.write_text(profile(localhost, partition, exclusive, shared_memory), encoding="utf-8")
    changed = {**environment, **dict.fromkeys(FILE_VARIABLES, str(path))}
    if localhost:
        # LOCALHOST would put transports of its own beside those of the profile, which stay on this machine anyway.
        changed[_RANGE] = "SYSTEM_DEFAULT"
    return changed
