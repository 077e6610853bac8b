# SPDX-License-Identifier: Apache-2.0
"""What `ti_l1` keeps and whom it gives up: tags, pins and the tree pseudo-LRU choice."""


class Cache:
    """Lines by number.  A place is a (set, way); a pinned place is never a victim."""

    def __init__(self, sets, ways):
        self._sets, self._ways = sets, ways
        self._line = [[None] * ways for _ in range(sets)]  # None: nothing valid
        self._pinned = [[False] * ways for _ in range(sets)]
        self._tree = [[0] * max(ways - 1, 1) for _ in range(sets)]

    def set_of(self, line):
        return line % self._sets

    def way_of(self, line):
        """The way that holds `line`, or None."""
        row = self._line[self.set_of(line)]
        return row.index(line) if line in row else None

    def victim(self, line):
        """The way that `line` would get, or None while all ways of its set are pinned."""
        s = self.set_of(line)
        free = [way for way in range(self._ways) if not self._pinned[s][way]]
        empty = [way for way in free if self._line[s][way] is None]
        oldest = self._oldest(s)
        return next(iter(empty or ([oldest] if oldest in free else free)), None)

    def touch(self, line):
        """A hit on `line` is used."""
        self._use(self.set_of(line), self.way_of(line))

    def alloc(self, line):
        """Reserve and pin a place for `line`; returns the place."""
        s, way = self.set_of(line), self.victim(line)
        self._line[s][way] = None
        self._pinned[s][way] = True
        self._use(s, way)
        return s, way

    def fill(self, place, line):
        """`line` has arrived at its place; None: as an error."""
        s, way = place
        assert self._pinned[s][way]
        self._line[s][way] = line

    def unpin(self, place):
        s, way = place
        assert self._pinned[s][way]
        self._pinned[s][way] = False

    def flush(self):
        """No line is valid any more; which way was used when stays known."""
        for row in self._line:
            row[:] = [None] * self._ways

    def _oldest(self, s):
        """Walk down the tree, to the half used longer ago at each node."""
        node, way, width = 0, 0, self._ways // 2
        while width:
            side = self._tree[s][node]
            way += side * width
            node, width = 2 * node + 1 + side, width // 2
        return way

    def _use(self, s, way):
        """Turn each node above `way` away from it."""
        node, width = 0, self._ways // 2
        while width:
            side = way // width % 2
            self._tree[s][node] = 1 - side
            node, width = 2 * node + 1 + side, width // 2
