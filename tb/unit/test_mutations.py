# SPDX-License-Identifier: Apache-2.0
"""Mutations of the RTL are those that are meant, leave alone what is settled before a build, and do
nothing in a copy until one is switched on."""

import os
import subprocess

import configure
import mutation_design
import mutation_switch
import mutation_table
import mutations
import pytest
import rtl_syntax
from agents.bench import ROOT

HEAD = """\
module child (input logic clk_i, input logic a_i, output logic b_o);
  assign b_o = a_i;
endmodule
"""


def found(
    tmp_path, body, ports="input logic clk_i, rst_ni, input logic [3:0] a, b, output logic y"
):
    """The mutations of a module with this body."""
    (tmp_path / "toy.sv").write_text(f"{HEAD}module toy ({ports});\n{body}\nendmodule\n")
    return [m for m in mutations.find(tmp_path, ["toy.sv"], []) if m.module == "toy"]


def changes(tmp_path, body, kind):
    return [(m.old, m.new) for m in found(tmp_path, body) if m.kind == kind]


OPERATORS = {
    "a + b": ["a - b"],
    "a - b": ["a + b"],
    "a & b": ["a | b"],
    "a | b": ["a & b"],
    "a ^ b": ["a & b"],
    "a && b": ["a || b"],
    "a || b": ["a && b"],
    "a == b": ["a != b"],
    "a != b": ["a == b"],
    "a < b": ["a <= b", "a >= b"],
    "a >= b": ["a > b", "a < b"],
    "a << b": ["a >> b"],
    "a >>> b": ["a >> b"],
    "!a": ["!!a"],
    "~a": ["a"],
    "-a": ["a"],
    "&a": ["|a"],
}


@pytest.mark.parametrize("old", OPERATORS)
def test_an_operator_becomes_another_of_the_same_type(tmp_path, old):
    new = [(old, word) for word in OPERATORS[old]]
    assert changes(tmp_path, f"assign y = {old};", "operator") == new


def test_an_operation_inside_another_stays_one(tmp_path):
    assert ("a && b", "(a || b)") in changes(tmp_path, "assign y = a && b && a;", "operator")
    assert ("a == b", "a != b") in changes(tmp_path, "assign y = (a == b) && a;", "operator")


NUMBERS = {
    "1'b0": "1'b1",
    "1'b1": "1'b0",
    "'0": "'1",
    "'1": "'0",
    "4'd6": "4'd7",
    "4'hf": "4'h0",
    "8'h0f": "8'h10",
    "0": "1",
    "1": "0",
    "12": "13",
}


@pytest.mark.parametrize("old", NUMBERS)
def test_a_number_becomes_the_next_one(tmp_path, old):
    assert changes(tmp_path, f"assign y = a == {old};", "constant") == [(old, NUMBERS[old])]


def test_a_condition_is_negated_or_fixed(tmp_path):
    fixed = [("a", "!(a)"), ("a", "1'b1"), ("a", "1'b0")]
    assert changes(tmp_path, "always_comb if (a) y = b; else y = a;", "condition") == fixed
    assert changes(tmp_path, "assign y = a ? b : a;", "condition") == fixed
    # That it is negated is what another operator does.
    compared = changes(tmp_path, "assign y = (a == b) ? b : a;", "condition")
    assert compared == [("(a == b)", "1'b1"), ("(a == b)", "1'b0")]


def test_an_assignment_is_zero_or_left_out(tmp_path):
    assert changes(tmp_path, "assign y = a[0];", "assignment") == [("a[0]", "'0")]
    assert changes(tmp_path, "always_ff @(posedge clk_i) y <= a[0];", "assignment") == [
        ("y <= a[0];", ";"),
        ("a[0]", "'0"),
    ]
    assert changes(tmp_path, "logic unused; assign unused = a[0];", "assignment") == []


def test_a_reset_is_another_value_or_none(tmp_path):
    body = """always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) y <= 1'b0;
      else y <= a[0];
    end"""
    changed = [("!rst_ni", "1'b0"), ("y <= 1'b0;", ";"), ("1'b0", "1'b1")]
    assert changes(tmp_path, body, "reset") == changed
    assert changes(tmp_path, body, "condition") == []


def test_a_vector_loses_its_top_bit(tmp_path):
    body = "logic [3:0] v; logic w; assign v = a; assign w = b[0]; assign y = v[0] ^ w;"
    assert changes(tmp_path, body, "width") == [("a", "(((a) << 1) >> 1)")]
    assert changes(tmp_path, "logic [3:0] v; assign v[1] = a[0];", "width") == []


def test_an_input_of_an_instance_is_zero_or_inverted(tmp_path):
    explicit = "child u_child (.clk_i, .a_i(a[0]), .b_o(y));"
    assert changes(tmp_path, explicit, "port") == [("a[0]", "'0"), ("a[0]", "~(a[0])")]
    implied = "logic a_i, b_o; child u_child (.clk_i, .a_i, .b_o);"
    assert changes(tmp_path, implied, "port") == [(".a_i", ".a_i('0)"), (".a_i", ".a_i(~a_i)")]


SETTLED = {
    "a localparam": "localparam int N = 3 + 1;",
    "a range": "logic [3+1:0] v;",
    "a type": "typedef logic [3+1:0] v_t;",
    "a condition of generate": "if (4 > 3) begin : gen_x end",
    "a loop of generate": "for (genvar i = 0; i < 4; i++) begin : gen_x end",
    "a number of copies": "logic [7:0] v; assign v = {(2 + 0) {a}};",
    "a parameter of an instance": "child #(.N(3 + 1)) u_child (.clk_i, .b_o(y));",
    "a clock": "child u_child (.clk_i(clk_i && 1'b1), .b_o(y));",
    "a part select": "logic v; assign v = y[4-1:0];",
    "the width of a part select": "logic v; assign v = y[b+:4-1];",
    "the type of a cast": "logic v; assign v = (4 + 1)'(y);",
    "a system function": "logic v; assign v = $clog2(3 + 1);",
    "a task of the elaboration": "if (a) begin : gen_x $error(\"n %d\", 3 + 1); end",
    "an assertion": "x: assert property (@(posedge clk_i) a == 3 + 1);",
    "an initial block": "initial y = a == 3 + 1;",
}  # fmt: skip


@pytest.mark.parametrize("where", SETTLED)
def test_what_is_settled_is_left_alone(tmp_path, where):
    kinds = ("operator", "constant", "port", "condition")
    assert [m for m in found(tmp_path, SETTLED[where]) if m.kind in kinds] == []


def test_heads_of_loops_and_labels_are_left_alone(tmp_path):
    loop = "always_comb begin y = '0; for (int i = 0; i < 3 + 1; i++) y = a[i] && b[i]; end"
    assert changes(tmp_path, loop, "operator") == [("a[i] && b[i]", "a[i] || b[i]")]
    case = "always_comb case (a) 4'd3: y = b[0]; default: y = a[0]; endcase"
    assert changes(tmp_path, case, "constant") == [("0", "1"), ("0", "1")]


def test_functions_are_left_alone_only_if_settled(tmp_path):
    function = "function automatic int next(int n); return n + 1; endfunction\n"
    settled = f"{function}localparam int N = next(3);"
    assert changes(tmp_path, settled, "operator") == []
    assert changes(tmp_path, f"{function}assign y = next(32'(a))[0];", "operator")
    inner = "function automatic int more(int n); return next(n); endfunction\n"
    assert changes(tmp_path, f"{function}{inner}logic [more(2):0] v;", "operator") == []


def test_what_a_macro_writes_is_left_alone(tmp_path):
    body = "`define SUM(x) (x + 1)\nassign y = `SUM(a) && b;"
    assert changes(tmp_path, body, "constant") == []


def test_what_cannot_be_read_is_said_with_its_line(tmp_path):
    with pytest.raises(rtl_syntax.SyntaxProblem, match=r"toy\.sv:5"):
        found(tmp_path, "assign y = ;")


def test_a_sample_depends_on_the_seed_alone():
    first = mutations.sample(list(range(1000)), 100, 1)
    assert first == mutations.sample(list(reversed(range(1000))), 100, 1)
    assert first[:20] == mutations.sample(list(range(1000)), 20, 1)
    assert first != mutations.sample(list(range(1000)), 100, 2)
    assert len(set(first)) == 100
    assert sorted(mutations.sample([3, 5], 100, 1)) == [3, 5]


TOY = """\
module toy #(
  parameter int unsigned Width = 4
) (
  input logic clk_i,
  input logic rst_ni,
  input logic [Width-1:0] a_i,
  input logic signed [Width-1:0] s_i,
  input logic take_i,
  output logic [Width-1:0] sum_o,
  output logic signed [Width:0] half_o,
  output logic last_o
);
  typedef struct packed {
    logic [1:0] low;
    logic odd;
  } part_t;
  part_t part;
  logic [Width-1:0] next, sum_q;
  logic last_q;
  assign part = '{low: a_i[1:0], odd: ^a_i};
  assign next = take_i && !part.odd ? sum_q + a_i : {part, 1'b1};
  assign half_o = s_i >>> 1;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sum_q  <= '1;
      last_q <= 1'b0;
    end else if (take_i) begin
      sum_q <= next;
      if (a_i == '1) last_q <= 1'b1;
      else last_q <= sum_q < 4'd3;
    end
  end
  toy_bit u_bit (.clk_i, .a_i(last_q), .b_o(last_o));
  assign sum_o = sum_q;
endmodule

module toy_bit (input logic clk_i, input logic a_i, output logic b_o);
  assign b_o = clk_i ? a_i : ~a_i;
endmodule
"""

# Both toys on the same numbers; prints in how many cycles they differ.
BENCH = """\
module bench;
  logic clk = 0, rst_n = 0, take, last, last_too;
  logic [3:0] a, sum, sum_too;
  logic signed [3:0] s;
  logic signed [4:0] half, half_too;
  int differ = 0;
  plain u_plain (
    .clk_i(clk), .rst_ni(rst_n), .a_i(a), .s_i(s), .take_i(take),
    .sum_o(sum), .half_o(half), .last_o(last)
  );
  toy u_toy (
    .clk_i(clk), .rst_ni(rst_n), .a_i(a), .s_i(s), .take_i(take),
    .sum_o(sum_too), .half_o(half_too), .last_o(last_too)
  );
  initial begin
    for (int i = 0; i < 1000; i++) begin
      {a, s, take} = 9'($urandom);
      rst_n = i > 2 && i % 100 != 0;
      #1 clk = 1;
      #1 if ({sum, half, last} !== {sum_too, half_too, last_too}) differ++;
      clk = 0;
      #1;
    end
    $display("differ %0d", differ);
    $finish;
  end
endmodule
"""


def test_a_copy_does_the_same_until_a_mutation_is_switched_on(tmp_path):
    (tmp_path / "toy.sv").write_text(TOY)
    numbered = dict(enumerate(mutations.find(tmp_path, ["toy.sv"], []), 1))
    text, spans = mutation_switch.switched(TOY, numbered.items())
    assert {span.number for span in spans} == set(numbered)
    files = {
        "package.sv": mutation_switch.PACKAGE_TEXT,
        "toy.sv": text,
        "plain.sv": TOY.replace("module toy #", "module plain #").partition("\nmodule toy_bit")[0]
        .replace("toy_bit", "plain_bit"),
        "bit.sv": "module plain_bit" + TOY.partition("\nmodule toy_bit")[2],
        "bench.sv": BENCH,
        "any.vlt": "`verilator_config\n" + mutation_switch.ANY_WARNING,
    }  # fmt: skip
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    sources = ["any.vlt", *(name for name in files if name.endswith(".sv"))]
    done = subprocess.run(
        ["verilator", "--binary", "--top-module", "bench", "-o", "bench", *sources],
        cwd=tmp_path,
        env={**os.environ, "OBJCACHE": "ccache"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr

    def differ(number):
        environment = {k: v for k, v in os.environ.items() if k != "TI_MUTANT"}
        if number is not None:
            environment["TI_MUTANT"] = str(number)
        program = [tmp_path / "obj_dir/bench"]
        said = subprocess.run(program, env=environment, capture_output=True, text=True, check=True)
        return int(said.stdout.split()[1])

    assert differ(None) == differ(0) == differ(len(numbered) + 1) == 0
    seen = {number: differ(number) for number in numbered}
    kinds = {numbered[number].kind for number in numbered if seen[number]}
    assert kinds == set(mutations.KINDS)
    # All but those that change nothing: the low bits are of two, so `1'b1` beside them is the top.
    assert sum(not cycles for cycles in seen.values()) <= len(seen) // 10


def test_an_error_is_blamed_on_the_smallest_mutation_around_it(tmp_path):
    text = "module toy (output logic y);\n  assign y = a && b;\nendmodule\n"
    (tmp_path / "toy.sv").write_text(text)
    both = dict(enumerate(mutations.find(tmp_path, ["toy.sv"], []), 1))
    assert [(m.kind, m.new) for m in both.values()] == [
        ("assignment", "'0"),
        ("operator", "a || b"),
    ]
    text, spans = mutation_switch.switched(text, both.items())
    (tmp_path / "toy.sv").write_text(text)
    line = text.splitlines()[1]

    def blamed(column):
        errors = f"%Error: {tmp_path}/toy.sv:2:{column + 1}: Wrong\n"
        return mutation_switch.blame(errors, tmp_path, {"toy.sv": spans})

    assert blamed(line.index("1'sb0")) == {1}
    assert blamed(line.index("a || b")) == {2}
    assert blamed(line.index("a && b")) == {1, 2}
    assert blamed(line.index("assign")) == {1, 2}


def test_a_module_is_tried_with_its_tests_or_those_nearest_above():
    children = {"ti_top": {"ti_x"}, "ti_x": {"ti_y"}, "ti_fifo": {"ti_y"}, "ti_y": {"ti_arbiter"}}
    assert mutation_design.nearest_tests("ti_arbiter", children) == ["test_ti_arbiter"]
    assert mutation_design.nearest_tests("ti_x", children) == ["test_ti_top"]
    assert mutation_design.nearest_tests("ti_y", children) == ["test_ti_fifo"]
    assert mutation_design.nearest_tests("ti_z", children) == []


def test_what_nobody_could_see_does_not_count():
    hows = ["lint", "unit", "unit", "lock-step", "above", "survives", "equivalent", "equivalent"]
    table = mutation_table.rows([("a", how) for how in hows] + [("b", "survives")])
    assert table == [
        ("a", 8, 1, 2, 1, 1, 1, 2, "83.3 %"),
        ("b", 1, 0, 0, 0, 0, 1, 0, "0.0 %"),
        ("all", 9, 1, 2, 1, 1, 2, 2, "71.4 %"),
    ]


def test_explanations_need_all_their_words(tmp_path):
    file = tmp_path / "survivors.yaml"
    entry = "- {file: a.sv, at: x = y, old: y, new: z, why: w"
    file.write_text(f"{entry}, equivalent: true}}\n")
    (key,) = mutation_table.load(file)
    assert key == ("a.sv", "x = y", "y", "z")
    for bad in (f"{entry}}}\n", 2 * f"{entry}, equivalent: true}}\n"):
        file.write_text(bad)
        with pytest.raises(mutation_table.ExplanationError):
            mutation_table.load(file)


def test_each_explanation_is_of_a_mutation_of_the_rtl(tmp_path):
    """One that fits none is of a place that has changed since."""
    configure.configure("tiny", [], tmp_path)
    files, folders = rtl_syntax.design(ROOT)
    keys = {m.key() for m in mutations.find(ROOT, files, [*folders, tmp_path])}
    for key, explanation in mutation_table.load().items():
        assert key in keys, key
        assert len(explanation.why.split()) > 3, key


def test_the_rtl_has_more_than_a_thousand_mutations(tmp_path):
    configure.configure("tiny", [], tmp_path)
    files, folders = rtl_syntax.design(ROOT)
    of = mutations.find(ROOT, files, [*folders, tmp_path])
    assert len(of) > 1000
    assert {m.kind for m in of} == set(mutations.KINDS)
    for mutation in of:
        text = (ROOT / mutation.file).read_text()
        assert mutation.apply(text) != text
        assert text[mutation.start : mutation.end] == mutation.old
