"""Chunks and nodes of a store that were read last, and are held in memory."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

CACHE = 64 << 20  # bytes of chunks that one grid holds: the last ones that were used
_NONE = np.empty(0, dtype=np.int64)


@dataclass(eq=False)
class Held:
    """Chunks and nodes that were read last, as the store has them.

    Attributes
    ----------
    nodes : (ndarray of int64, ndarray of float64)
        Nodes, rising, and their values.
    every : dict
        Elevations of some rows and columns, by these.
    """

    chunks: OrderedDict[tuple[int, int], np.ndarray] = field(default_factory=OrderedDict)
    size: int = 0
    nodes: tuple[np.ndarray, np.ndarray] = (_NONE, np.empty(0))
    every: dict[bytes, np.ndarray] = field(default_factory=dict)
    lock: threading.RLock = field(default_factory=threading.RLock)

    def __reduce__(self) -> Any:
        return Held, ()

    def add_nodes(self, nodes: np.ndarray, values: np.ndarray, most: int) -> None:
        """Hold values of some nodes; those of earlier ones go if all are more than `most`."""
        with self.lock:
            known, z = self.nodes
            if len(known) + len(nodes) > most or not len(known):
                known, z = _NONE, values[:0]
            both, first = np.unique(np.concatenate([known, nodes]), return_index=True)
            self.nodes = both, np.concatenate([z, values])[first]

    def chunk(self, place: tuple[int, int], read: Callable[[], np.ndarray]) -> np.ndarray:
        """Values of a chunk, from those that were used last if it is among them."""
        with self.lock:
            if place in self.chunks:
                self.chunks.move_to_end(place)
                return self.chunks[place]
        chunk = read()
        with self.lock:
            if place not in self.chunks:
                self.chunks[place] = chunk
                self.size += chunk.nbytes
            while self.size > CACHE and len(self.chunks) > 1:
                self.size -= self.chunks.popitem(last=False)[1].nbytes
        return chunk

    def forget_chunks(self) -> None:
        """Give up the chunks that were used last."""
        with self.lock:
            self.chunks.clear()
            self.size = 0


__all__ = ["Held"]
