"""The hardware of a mission, and what follows from it."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .geometry import flat_length, shortest_ways
from .lattices import FlatNet
from .parts import Aiming, Capture, Chaser, Closing, Debris, Launch, Net, Tether, Unit, frozen


@dataclass(frozen=True, eq=False)
class Hardware:
    """The hardware of a mission: everything that a description says, built."""

    name: str
    description: str
    """What it is, in a sentence or two."""
    net: Net
    units: tuple[Unit, ...]
    """Maneuverable units, unit 1 first."""
    mouth_order: tuple[int, ...]
    """Units in their order round the mouth, from 1, counter-clockwise from unit 1."""
    closing: Closing
    launch: Launch
    debris: Debris
    chaser: Chaser
    tether: Tether
    capture: Capture
    aiming: Aiming
    parameters: Mapping[str, Mapping[str, Any]]
    """Parameters that this system is flown with unless others are given: subsystem, name, value."""
    content: Mapping[str, Any]
    """The complete description that this system was made from, files written out."""
    flat_net: FlatNet
    """The net before its threads are divided into springs, with its corners."""

    @property
    def unit_count(self) -> int:
        """M."""
        return len(self.units)

    @property
    def particle_count(self) -> int:
        """Nodes and units."""
        return self.net.node_count + self.unit_count

    @property
    def tether_strength_n(self) -> float | None:
        """Tension at which the main tether breaks [N]: as described, or that of a thread of the net; None where neither
        is known.
        """
        given = self.tether.strength_n
        return self.net.material.strength_n if given is None else given

    @functools.cached_property
    def unit_reach_m(self) -> np.ndarray:
        """Length of flat net and thread from the central node to each unit [m], shape (M,)."""
        nodes = self.net.nodes[:, :2]
        center = nodes[self.net.center_node]
        flat = [flat_length(*(nodes[unit.node] - center).tolist()) for unit in self.units]
        return frozen(np.array(flat, float) + np.array([unit.thread_length_m for unit in self.units], float))

    @functools.cached_property
    def unit_tethers(self) -> tuple[tuple[int, int, float], ...]:
        """All pairs of units (indices from 0), and the length of the shortest way through threads between them [m]."""
        net, ways = self.net, {}
        for a, unit in enumerate(self.units[:-1]):
            targets = [other.node for other in self.units[a + 1 :]]
            ways[a] = shortest_ways(net.node_count, net.threads, net.rest_lengths, unit.node, targets)
        return tuple(
            (a, b, ways[a][self.units[b].node] + self.units[a].thread_length_m + self.units[b].thread_length_m)
            for a, b in itertools.combinations(range(self.unit_count), 2)
        )

    @functools.cached_property
    def closing_ring(self) -> tuple[int, ...]:
        """Units in the order in which neighbours dock, from 1; empty where units do not dock."""
        if self.closing.kind != "docking":
            return ()
        return tuple(particle - self.net.node_count + 1 for particle in self.closing.ring)

    @functools.cached_property
    def ring_neighbours(self) -> tuple[tuple[int, int], ...]:
        """Pairs of units that dock, from 1, in their order round the mouth; empty where units do not dock."""
        ring = self.closing_ring
        return tuple(zip(ring, ring[1:] + ring[:1], strict=True))
