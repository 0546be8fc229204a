"""Quality-of-service profiles by name.

All that flies is RELIABLE: a lost command costs fuel, and lock-step counts on every answer. What is published at every
control tick is kept 100 deep: when the shared memory of a busy reader overflows (measured: a recorder that stands still
for 0.1 s at 160 ticks/s), the writer must still have what it has to send again. The recorder keeps more, because in
lock-step a mission runs faster than real time.
"""

from rclpy.qos import QoSDurabilityPolicy, QoSHistoryPolicy, QoSProfile, QoSReliabilityPolicy


def _reliable(depth: int, durability: QoSDurabilityPolicy) -> QoSProfile:
    return QoSProfile(
        history=QoSHistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=QoSReliabilityPolicy.RELIABLE,
        durability=durability,
    )


CONTROL = _reliable(100, QoSDurabilityPolicy.VOLATILE)
"""Odometry, thrust, heartbeat."""

STATE = _reliable(10, QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Latched, and the newest counts: status; a late joiner gets it."""

STATE_BACKLOG = _reliable(100, QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""Latched, and every sample counts: mission state and assessment, which say some things once, odometry of debris and
chaser. In lock-step a starved reader may lag behind by seconds (measured: the assessment at the trigger lost to a
command on a machine with four times more work than cores, among ten samples of progress)."""

BULK = _reliable(100, QoSDurabilityPolicy.VOLATILE)
"""Net state and pictures of it: deep, so that a reader may lag behind by seconds."""

RECORD = _reliable(1000, QoSDurabilityPolicy.VOLATILE)
"""The recorder's side of every volatile topic."""

RECORD_LATCHED = _reliable(1000, QoSDurabilityPolicy.TRANSIENT_LOCAL)
"""The recorder's side of every latched topic."""

NEWEST = QoSProfile(
    history=QoSHistoryPolicy.KEEP_LAST,
    depth=1,
    reliability=QoSReliabilityPolicy.BEST_EFFORT,
    durability=QoSDurabilityPolicy.VOLATILE,
)
"""The side of whoever looks on now and then: every publisher's offer is good enough, and nothing is sent again."""

SERVICE = _reliable(100, QoSDurabilityPolicy.VOLATILE)
"""Requests and answers of every service: deep, because all controllers ask for their aiming points at the same moment,
and each client sees the answers to all. The usual depth of 10 keeps the newest 10 of 24 requests, and loses the rest
without a word.
"""
