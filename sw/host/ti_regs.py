# SPDX-License-Identifier: Apache-2.0
"""The registers of `ti_top`, written by scripts/registers.py from rtl/host/ti_regs.rdl."""

from typing import NamedTuple


class Field(NamedTuple):
    low: int
    width: int
    reset: int | None

    @property
    def mask(self) -> int:
        return (1 << self.width) - 1 << self.low

    def of(self, word: int) -> int:
        """The value of the field in a word of its register."""
        return (word & self.mask) >> self.low


class Register(NamedTuple):
    offset: int
    fields: dict[str, Field]


# fmt: off
REGISTERS = {
    "ID": Register(0x00, {
        "value": Field(0, 32, 0x31492654),
    }),
    "VERSION": Register(0x04, {
        "minor": Field(0, 16, 0x0),
        "major": Field(16, 16, 0x1),
    }),
    "CONFIG_HASH": Register(0x08, {
        "value": Field(0, 32, None),
    }),
    "FORMAT": Register(0x0c, {
        "exp_bits": Field(0, 8, None),
        "frac_bits": Field(8, 8, None),
        "rounding": Field(16, 1, None),
        "subnormals": Field(17, 1, None),
    }),
    "MACHINE": Register(0x10, {
        "cores": Field(0, 8, None),
        "streams": Field(8, 8, None),
        "triangle_test": Field(16, 2, None),
        "traversal": Field(18, 1, None),
        "any_hit": Field(20, 1, None),
        "counters": Field(21, 1, None),
        "snapshot": Field(22, 1, None),
        "stream_clock": Field(23, 1, None),
    }),
    "UNITS": Register(0x14, {
        "num_trv": Field(0, 10, None),
        "num_list": Field(10, 10, None),
        "num_ist1": Field(20, 10, None),
    }),
    "MEMORY": Register(0x18, {
        "line_bytes": Field(0, 8, None),
        "addr_bits": Field(8, 8, None),
    }),
    "CONTROL": Register(0x20, {
        "run": Field(0, 1, 0x0),
        "flush": Field(1, 1, 0x0),
        "any_hit": Field(2, 1, 0x0),
        "count": Field(3, 1, 0x1),
    }),
    "STATUS": Register(0x24, {
        "idle": Field(0, 1, None),
        "flushing": Field(1, 1, None),
    }),
    "IRQ_STATUS": Register(0x28, {
        "invalid_ray": Field(0, 1, 0x0),
        "memory_error": Field(1, 1, 0x0),
        "watchdog": Field(2, 1, 0x0),
        "drained": Field(3, 1, 0x0),
    }),
    "IRQ_ENABLE": Register(0x2c, {
        "invalid_ray": Field(0, 1, 0x0),
        "memory_error": Field(1, 1, 0x0),
        "watchdog": Field(2, 1, 0x0),
        "drained": Field(3, 1, 0x0),
    }),
    "RAYS_LO": Register(0x30, {
        "value": Field(0, 32, None),
    }),
    "RAYS_HI": Register(0x34, {
        "value": Field(0, 16, None),
    }),
    "HITS_LO": Register(0x38, {
        "value": Field(0, 32, None),
    }),
    "HITS_HI": Register(0x3c, {
        "value": Field(0, 16, None),
    }),
    "INVALID_RAYS": Register(0x40, {
        "value": Field(0, 32, None),
    }),
    "MEMORY_ERRORS": Register(0x44, {
        "value": Field(0, 32, None),
    }),
    "WATCHDOGS": Register(0x48, {
        "value": Field(0, 32, None),
    }),
    "SNAPSHOT": Register(0x50, {
        "take": Field(0, 1, 0x0),
    }),
    "COUNTER_SELECT": Register(0x54, {
        "event_number": Field(0, 8, 0x0),
        "unit": Field(8, 16, 0x0),
        "core": Field(24, 8, 0x0),
    }),
    "COUNTER_LO": Register(0x58, {
        "value": Field(0, 32, None),
    }),
    "COUNTER_HI": Register(0x5c, {
        "value": Field(0, 16, None),
    }),
    "ROOT": Register(0x80, {
        "value": Field(0, 32, 0x0),
    }),
    "NUM_LIST": Register(0x84, {
        "value": Field(0, 32, 0x0),
    }),
    "NUM_RECORDS": Register(0x88, {
        "value": Field(0, 32, 0x0),
    }),
    "NODE_BASE_LO": Register(0x90, {
        "value": Field(0, 32, 0x0),
    }),
    "NODE_BASE_HI": Register(0x94, {
        "value": Field(0, 32, 0x0),
    }),
    "LIST_BASE_LO": Register(0x98, {
        "value": Field(0, 32, 0x0),
    }),
    "LIST_BASE_HI": Register(0x9c, {
        "value": Field(0, 32, 0x0),
    }),
    "PLANE_BASE_LO": Register(0xa0, {
        "value": Field(0, 32, 0x0),
    }),
    "PLANE_BASE_HI": Register(0xa4, {
        "value": Field(0, 32, 0x0),
    }),
    "BARY_BASE_LO": Register(0xa8, {
        "value": Field(0, 32, 0x0),
    }),
    "BARY_BASE_HI": Register(0xac, {
        "value": Field(0, 32, 0x0),
    }),
    "BOX_LO_0": Register(0xb0, {
        "value": Field(0, 32, 0x0),
    }),
    "BOX_LO_1": Register(0xb4, {
        "value": Field(0, 32, 0x0),
    }),
    "BOX_LO_2": Register(0xb8, {
        "value": Field(0, 32, 0x0),
    }),
    "BOX_HI_0": Register(0xc0, {
        "value": Field(0, 32, 0x0),
    }),
    "BOX_HI_1": Register(0xc4, {
        "value": Field(0, 32, 0x0),
    }),
    "BOX_HI_2": Register(0xc8, {
        "value": Field(0, 32, 0x0),
    }),
}
