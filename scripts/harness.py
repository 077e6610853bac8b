# SPDX-License-Identifier: Apache-2.0
"""A module between registers: what is measured of a unit that is placed and routed alone.

A serial input fills a shift register that drives every input of the unit; every output is captured
in a register, and a tree of registers, an exclusive-or of four in each step, leads them to one
output.  So a unit with a thousand ports needs four pins, all of its paths have a register at both
ends, and the paths of the harness itself are one look-up table long.
"""

TOP = "ti_harness"
INSTANCE = "u_unit"
CLOCKS, RESETS = ("clk_i",), ("rst_ni",)


def harness(unit: str, ports: dict[str, dict]) -> tuple[str, dict[str, str]]:
    """Verilog of the harness, and the port that each of its registers is beside.

    Ports are as Yosys writes them in JSON.
    """
    inputs = [n for n, p in ports.items() if p["direction"] == "input"]
    outputs = [n for n, p in ports.items() if p["direction"] == "output"]
    driven = [n for n in inputs if n not in CLOCKS + RESETS]
    width = {n: len(ports[n]["bits"]) for n in ports}
    connections = [f".{n}(clk_i)" for n in inputs if n in CLOCKS]
    connections += [f".{n}(reset_q[1])" for n in inputs if n in RESETS]
    places = {}
    at = 0
    for name in driven:
        places |= {f"in_q[{at + i}]": f"input {name}" for i in range(width[name])}
        connections.append(f".\\{name} (in_q[{at + width[name] - 1}:{at}])")
        at += width[name]
    count_in, at = max(at, 1), 0
    for name in outputs:
        places |= {f"tree0_q[{at + i}]": f"output {name}" for i in range(width[name])}
        connections.append(f".\\{name} (harness_output[{at + width[name] - 1}:{at}])")
        at += width[name]
    count_out = max(at, 1)
    lines = [
        f"module {TOP}(input clk_i, input rst_ni, input serial_i, output serial_o);",
        "  reg [1:0] reset_q;",
        "  always @(posedge clk_i) reset_q <= {reset_q[0], rst_ni};",
        f"  reg [{count_in}:0] in_q;",
        f"  always @(posedge clk_i) in_q <= {{in_q[{count_in - 1}:0], serial_i}};",
        f"  wire [{count_out - 1}:0] harness_output;",
        f"  {unit} {INSTANCE} ({', '.join(connections)});",
        f"  reg [{count_out - 1}:0] tree0_q;",
        "  always @(posedge clk_i) tree0_q <= harness_output;",
    ]
    level = 0
    while count_out > 1:
        fewer = (count_out + 3) // 4
        lines.append(f"  reg [{fewer - 1}:0] tree{level + 1}_q;")
        for i in range(fewer):
            four = f"tree{level}_q[{min(4 * i + 3, count_out - 1)}:{4 * i}]"
            lines.append(f"  always @(posedge clk_i) tree{level + 1}_q[{i}] <= ^{four};")
        count_out, level = fewer, level + 1
    lines += [f"  assign serial_o = tree{level}_q[0];", "endmodule"]
    if count_in == 1:
        places["in_q"] = places.get("in_q[0]", "input")
    return "\n".join(lines) + "\n", places
