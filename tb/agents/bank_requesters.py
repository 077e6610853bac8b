# SPDX-License-Identifier: Apache-2.0
"""The units in front of one bank of an L2: they ask, and all that the bank does is checked."""

from agents.requesters import EVENTS, Requesters
from models.payload import configuration, payloads


class BankRequesters(Requesters):
    """A slot is a unit and an id under which it asks."""

    def _shape(self):
        self.units, self.ids = int(self._dut.NumUnits.value), int(self._dut.UnitIds.value)
        self.banks = int(self._dut.NumBanks.value)
        return self.units * self.ids, configuration()["line_bytes"]

    def _slots(self):
        return [(unit, identity) for unit in range(self.units) for identity in range(self.ids)]

    def _inside(self, line):
        """With the bits of the bank at the top."""
        width = payloads().width("line_addr_t")
        return line // self.banks + line % self.banks * ((1 << width) // self.banks)

    def line_of(self, set_, number):
        """The number-th line of a set, of those whose number ends in the highest bank's."""
        return self.of_bank(super().line_of(set_, number))

    def of_bank(self, number):
        """The number-th line of the highest bank."""
        return number * self.banks + self.banks - 1

    def _put(self, ticket):
        unit, identity = ticket.slot
        line = ticket.addr // self.line_bytes
        self._inputs.drive("req_unit_i", unit)
        self._inputs.drive("req_data_i", payloads().pack("line_req_t", id=identity, line=line))

    def _slot(self):
        answer = payloads().unpack("line_rsp_t", int(self._dut.rsp_data_o.value))
        return int(self._dut.rsp_unit_o.value), answer["id"]

    def _read_slot(self):
        return self._slot() if self._dut.rsp_valid_o.value else None

    def _answer(self):
        answer = payloads().unpack("line_rsp_t", int(self._dut.rsp_data_o.value))
        return answer["error"] == 1, answer["data"]

    def _events(self):
        events = payloads().unpack("l2_events_t", int(self._dut.events_o.value))
        return events["accesses"], {event: events[event.removeprefix("l1_")] for event in EVENTS}

    def _says_it_waits(self):
        return None
