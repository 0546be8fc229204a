"""One mission in a DDS domain: two would hear each other's odometry before either could know.

The claim is a Unix socket with an abstract name: it belongs to the network namespace, as the domain's ports on this
machine do, needs no file, and goes with its process however that ends. Missions on other machines, or started node by
node, hold none; those are looked for in the graph.
"""

from __future__ import annotations

import errno
import socket
import struct

_NAME = "\0tethernet-mission-in-domain-{}"
_CREDENTIALS = struct.Struct("3i")  # pid, uid, gid


class DomainTakenError(Exception):
    """Another mission on this machine is in the domain."""

    def __init__(self, pid: int | None):
        """Args:
        pid: of the command that flies it; None where that cannot be seen.
        """
        super().__init__("another mission flies there" + (f", started by process {pid}" if pid else ""))


class DomainClaim:
    """Holds a DDS domain for this process, from :meth:`take` to :meth:`release`."""

    def __init__(self, domain_id: int):
        self._name = _NAME.format(domain_id)
        self._socket: socket.socket | None = None

    def take(self) -> None:
        """Claim the domain.

        Raises:
            DomainTakenError: when another process has.
            OSError: when the machine allows no sockets.
        """
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(self._name)
            claim.listen(1)  # whoever finds it taken asks whose it is
        except OSError as error:
            claim.close()
            if error.errno == errno.EADDRINUSE:
                raise DomainTakenError(self._holder()) from None
            raise
        self._socket = claim

    def release(self) -> None:
        """Give the domain back, if it was claimed."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _holder(self) -> int | None:
        with socket.socket(socket.AF_UNIX) as asking:
            asking.setblocking(False)
            try:
                asking.connect(self._name)
                credentials = asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
            except OSError:  # it has gone meanwhile, or somebody else asks just now
                return None
        return _CREDENTIALS.unpack(credentials)[0] or None
