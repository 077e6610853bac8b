# SPDX-License-Identifier: Apache-2.0
"""The slots in front of a `ti_ra`: they ask, and everything that the unit does is checked."""

from collections import Counter, deque
from dataclasses import dataclass, field

from agents.bench import cycle
from agents.handles import Handles, Inputs
from agents.memory import line_data
from cocotb.triggers import ReadOnly, RisingEdge
from models.cache import Cache
from models.payload import configuration, payloads

EVENTS = {"l1_hits": "hit", "l1_merged": "merged", "l1_misses": "miss"}


@dataclass(eq=False)
class Ticket:
    """One request and, as they become known, the cycles of its life."""

    addr: int
    slot: int = None  # None until it is offered: any free one
    taken: int = None
    kind: str = None  # a value of EVENTS
    decided: int = None
    read: int = None  # the answer has left the row or the look-up
    shown: int = None  # it stands at the port
    done: int = None  # and has been taken
    error: bool = None
    row: "Row" = None


@dataclass(eq=False)
class Row:
    """Requests that gather for a line on its way."""

    line: int
    place: tuple
    waiting: set = field(default_factory=set)
    answered: int = None
    error: bool = False


class Requesters:
    """Asks what `ask` is given, at most one request in flight a slot.

    `gap()` says whether to stay idle instead of offering the next request, `ready()` is the ready
    bit of the answers.  Which requests must hit, merge or miss follows from the model of the cache
    and from the answers that the memory gave; whether the unit is idle, or waits for a line, from
    what is in flight.  The methods under "the ports of the unit" are all that knows its ports.
    """

    def __init__(self, dut, memory, rng):
        self._dut, self._inputs = Handles(dut), Inputs(dut)
        self._memory, self._rng = memory, rng
        self.rows, self.line_bytes = int(dut.Rows.value), configuration()["line_bytes"]
        self.num_slots, self.elem_bytes = self._shape()
        self.ways = int(dut.Ways.value)
        self.sets = int(dut.CacheBytes.value) // (self.ways * self.line_bytes)
        self.gap = lambda: False
        self.ready = lambda: True
        self.counts = Counter()
        self._cache = Cache(self.sets, self.ways)
        self._wishes = deque()
        self._free = set(self._slots())
        self._offer = None
        self._undecided = deque()
        self._in_flight = {}  # slot -> ticket, from taken to done
        self._rows = []
        self._shown = None
        self._takes = False  # whether an answer is taken in this cycle
        fill_bytes = max(self.elem_bytes, min(configuration()["fill_bytes"], self.line_bytes))
        self.words = self.line_bytes // fill_bytes  # of a line, each stored in a cycle
        self._stood = 0  # cycles for which an answer of the memory has stood at the port

    def addr(self, line, elem=0, byte=0):
        return line * self.line_bytes + elem * self.elem_bytes + byte

    def line_of(self, set_, number):
        """The number-th line of a set."""
        return number * self.sets + set_

    def any_addr(self, line):
        return self.addr(line) + self._rng.randrange(self.line_bytes)

    def ask(self, addrs):
        """Queue a request for each address; returns their tickets."""
        tickets = [Ticket(addr) for addr in addrs]
        self._wishes.extend(tickets)
        return tickets

    async def bring(self, *lines):
        """Have `lines` in the cache."""
        for line in lines:
            await self.done(self.ask([self.addr(line)]))

    async def until(self, condition, patience=5000):
        """Go on until `condition()` holds; fails when nothing moves for `patience` cycles."""
        idle, before = 0, None
        while not condition():
            await RisingEdge(self._dut.clk_i)
            moves = self.counts["taken"] + self.counts["done"]
            idle = 0 if moves != before else idle + 1
            before = moves
            assert idle < patience, f"stuck: {len(self._in_flight)} in flight, {self.counts}"

    async def done(self, tickets, patience=5000):
        for ticket in tickets:
            await self.until(lambda ticket=ticket: ticket.done is not None, patience)

    async def decided(self, tickets, patience=5000):
        for ticket in tickets:
            await self.until(lambda ticket=ticket: ticket.kind is not None, patience)

    async def flush(self):
        """Have the unit, which is idle, forget all lines."""
        assert not self._in_flight and not self._wishes
        self._dut.flush_i.value = 1
        await RisingEdge(self._dut.clk_i)
        self._dut.flush_i.value = 0
        self._cache.flush()

    def waits(self):
        """Whether the unit holds a request that it cannot decide on."""
        return bool(self._undecided)

    def in_flight(self):
        """How many requests have been taken and not answered."""
        return len(self._in_flight)

    def finish(self):
        """Check the sums when everything is over."""
        assert not self._in_flight and not self._rows and not self._wishes
        assert self.counts["access"] == sum(self.counts[kind] for kind in EVENTS.values())
        assert self.counts["access"] == self.counts["taken"] == self.counts["done"]
        assert self.counts["miss"] == len(self._memory.asked)

    async def run(self):
        """Play the slots for ever."""
        while True:
            self._drive()
            await ReadOnly()
            self._see_state()
            self._see_read()
            self._see_response()
            self._see_event()
            self._see_lines()
            self._see_request()
            await RisingEdge(self._dut.clk_i)

    def _drive(self):
        if self._offer is None and self._wishes and self._free and not self.gap():
            self._offer = self._wishes.popleft()
            self._offer.slot = self._rng.choice(sorted(self._free))
            self._put(self._offer)
        self._inputs.drive("req_valid_i", int(self._offer is not None))
        self._takes = bool(self.ready())
        self._inputs.drive("rsp_ready_i", int(self._takes))

    def _see_state(self):
        """What the registers say of the cycles before this one."""
        idle = bool(self._dut.idle_o.value)
        assert idle == (not self._in_flight), f"{len(self._in_flight)} in flight"
        waits = self._says_it_waits()
        on_their_way = any(row.answered is None for row in self._rows)
        assert waits in (None, on_their_way), f"lines on their way: {on_their_way}"
        self._see_port()

    def _see_port(self):
        """An answer is taken in as many cycles as it has words, whatever else happens."""
        if self._dut.line_rsp_valid_i.value:
            self._stood += 1
            last = self._stood == self.words
            taken = bool(self._dut.line_rsp_ready_o.value)
            assert taken == last, f"word {self._stood} of an answer"
            self._stood %= self.words

    def _see_request(self):
        if self._offer is not None and self._dut.req_ready_o.value:
            ticket, self._offer = self._offer, None
            ticket.taken = cycle()
            self.counts["taken"] += 1
            self._free.remove(ticket.slot)
            self._in_flight[ticket.slot] = ticket
            self._undecided.append(ticket)

    def _see_event(self):
        access, events = self._events()
        seen = [kind for event, kind in EVENTS.items() if events[event]]
        if not access:
            assert not seen, f"{seen} without an access"
            return
        assert len(seen) == 1 and self._undecided, f"access with {seen}"
        self.counts.update(["access", *seen])
        ticket = self._undecided.popleft()
        ticket.kind, ticket.decided = seen[0], cycle()
        line = ticket.addr // self.line_bytes
        row = next((r for r in self._rows if r.line == line and r.answered is None), None)
        there = self._cache.way_of(self._inside(line)) is not None
        want = "merged" if row else "hit" if there else "miss"
        assert ticket.kind == want, f"line {line:#x}: {ticket.kind}, must be {want}"
        if ticket.kind == "hit":
            self._cache.touch(self._inside(line))
            return
        if ticket.kind == "miss":
            inside = self._inside(line)
            assert len(self._rows) < self.rows and self._cache.victim(inside) is not None
            row = Row(line, self._cache.alloc(inside))
            self._rows.append(row)
        row.waiting.add(ticket)
        ticket.row = row

    def _see_lines(self):
        if self._memory.answered and self._memory.answered[-1][0] == cycle():
            _, line, error = self._memory.answered[-1]
            row = next(r for r in self._rows if r.line == line and r.answered is None)
            row.answered, row.error = cycle(), error
            self._cache.fill(row.place, None if error else self._inside(line))

    def _see_read(self):
        slot = self._read_slot()
        ticket = self._in_flight.get(slot)
        if ticket is not None and ticket.read is None:
            ticket.read = cycle()
            self._first_read(ticket)

    def _see_response(self):
        if not self._dut.rsp_valid_o.value:
            assert self._shown is None, "an answer went away before it was taken"
            return
        slot = self._slot()
        assert slot in self._in_flight, f"an answer for slot {slot}, which has asked nothing"
        ticket = self._in_flight[slot]
        assert self._shown in (None, ticket), "an answer changed before it was taken"
        if self._shown is None:
            self._shown, ticket.shown = ticket, cycle()
        self._check(ticket)
        if self._takes:
            ticket.done, self._shown = cycle(), None
            self.counts["done"] += 1
            del self._in_flight[slot]
            self._free.add(slot)

    def _first_read(self, ticket):
        row = ticket.row
        if row is None:
            assert ticket.kind == "hit" and ticket.read == ticket.decided + 1
            return
        assert row.answered is not None, "an answer before its line"
        row.waiting.remove(ticket)
        if not row.waiting:
            self._rows.remove(row)
            self._cache.unpin(row.place)

    def _check(self, ticket):
        error, got = self._answer()
        ticket.error = error
        assert ticket.error == (ticket.row is not None and ticket.row.error), f"{ticket.addr:#x}"
        if not ticket.error:
            data = line_data(ticket.addr // self.line_bytes, self.line_bytes)
            elem = ticket.addr % self.line_bytes // self.elem_bytes
            want = data >> 8 * self.elem_bytes * elem & ((1 << 8 * self.elem_bytes) - 1)
            assert got == want, f"{ticket.addr:#x} ({ticket.kind}): {got:#x}, must be {want:#x}"

    # --- The ports of the unit ---

    def _shape(self):
        """Number of slots and bytes of an answer."""
        return int(self._dut.NumSlots.value), int(self._dut.ElemBytes.value)

    def _slots(self):
        return range(self.num_slots)

    def _inside(self, line):
        """The number of a line in the cache of the unit."""
        return line

    def _put(self, ticket):
        self._inputs.drive("req_slot_i", ticket.slot)
        self._inputs.drive("req_addr_i", ticket.addr)

    def _slot(self):
        return int(self._dut.rsp_slot_o.value)

    def _read_slot(self):
        """Whose answer has been read from the line store; behind it there may be a queue."""
        return int(self._dut.s2_slot_q.value) if self._dut.s2_valid_q.value else None

    def _answer(self):
        """Error and bytes of the answer at the port; the bytes may be anything with an error."""
        return bool(self._dut.rsp_error_o.value), int(self._dut.rsp_elem_o.value)

    def _events(self):
        """Whether a request is decided in this cycle, and the events of that."""
        events = payloads().unpack("cache_events_t", int(self._dut.events_o.value))
        return events["l1_accesses"], events

    def _says_it_waits(self):
        """Whether the unit says that it waits for a line; None: it does not say."""
        return bool(self._dut.waits_o.value)


class Retriers(Requesters):
    """The same in front of a unit whose rays look again: each look-up is one of the ray in step 1.

    `looks` counts the look-ups that went round again because of a line on its way, `refused` those
    that found neither a row nor a place.
    """

    def __init__(self, dut, memory, rng):
        super().__init__(dut, memory, rng)
        self.looks = self.refused = 0

    def _see_request(self):
        super()._see_request()
        self._undecided.clear()

    def _see_event(self):
        events = payloads().unpack("cache_events_t", int(self._dut.events_o.value))
        seen = [kind for event, kind in EVENTS.items() if events[event]]
        if not events["l1_accesses"]:
            assert not seen, f"{seen} without an access"
            return
        assert len(seen) == 1, f"access with {seen}"
        self.counts.update(["access", *seen])
        decided = self._dut.s1  # its slot stands first
        slot = int(decided.value) >> (len(decided) - (self.num_slots - 1).bit_length())
        ticket = self._in_flight[slot]
        ticket.kind, ticket.decided = seen[0], cycle()
        line = ticket.addr // self.line_bytes
        if ticket.row and ticket.row.answered is not None:
            assert ticket.kind == "hit", f"{ticket.kind} of a ray that has asked for its line"
            return
        full = len(self._rows) >= self.rows or self._cache.victim(line) is None
        if any(r.line == line and r.answered is None for r in self._rows):
            want, self.looks = "merged", self.looks + 1
        elif self._cache.way_of(line) is not None:
            want = "hit"
            self._cache.touch(line)
        elif full:
            want, self.refused = "merged", self.refused + 1
        else:
            want = "miss"
            ticket.row = Row(line, self._cache.alloc(line), {ticket})
            self._rows.append(ticket.row)
        assert ticket.kind == want, f"line {line:#x}: {ticket.kind}, must be {want}"

    def _first_read(self, ticket):
        assert ticket.kind == "hit" and ticket.read == ticket.decided + 1
        super()._first_read(ticket)

    def finish(self):
        """Check the sums when everything is over."""
        assert not self._in_flight and not self._rows and not self._wishes
        assert self.counts["access"] == sum(self.counts[kind] for kind in EVENTS.values())
        assert self.counts["hit"] == self.counts["taken"] == self.counts["done"]
        assert self.counts["merged"] == self.looks + self.refused
        assert self.counts["miss"] == len(self._memory.asked)
