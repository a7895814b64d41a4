"""Integer formulas without divisions that trap, and with the values that GenApi would have computed."""

import random

import pytest
from genicam import genapi
from hypothesis import given
from hypothesis import strategies as st

from every_case import every_case
from grabbergui.driver.genapi import formulas
from grabbergui.driver.genapi.formulas import LONGEST, value_of, without_traps

SMALLEST = -(2**63)
HEAD = """<?xml version="1.0" encoding="utf-8"?>
<RegisterDescription xmlns="http://www.genicam.org/GenApi/Version_1_1" ModelName="F" VendorName="F"
 ToolTip="" StandardNameSpace="None" SchemaMajorVersion="1" SchemaMinorVersion="1" SchemaSubMinorVersion="0"
 MajorVersion="1" MinorVersion="0" SubMinorVersion="0" ProductGuid="1" VersionGuid="1">
<Category Name="Root"/><Port Name="Device"/>"""
OPERATORS = sorted(formulas.RANK)


def computed(formula: str, **variables: int) -> int | None:
    """Return GenApi's result of a formula; None where GenApi refuses it."""
    escaped = formula.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    constants = "".join(f'<Constant Name="{name}">{value}</Constant>' for name, value in variables.items())
    node = f'<IntSwissKnife Name="X">{constants}<Formula>{escaped}</Formula></IntSwissKnife>'
    nodes = genapi.NodeMap()
    nodes.load_xml_from_string(f"{HEAD}{node}</RegisterDescription>")
    try:
        return int(nodes.get_node("X").value)
    except genapi.GenericException:
        return None


@every_case(
    ("formula", "value"),
    [
        ("(1 << 63) / (0-1)", SMALLEST),
        ("(1 << 63) % (0-1)", 0),
        ("A / B", SMALLEST),
        ("A % B", 0),
        ("A/B/B", SMALLEST),
        ("B ? A : (A/B)", SMALLEST),
        ("7 / (A / A)", 7),
        ("7 / B * 2", -14),
        ("5 % (7 / B)", 5),
        ("NEG(A) / SGN(B)", SMALLEST),
        ("A / -1", SMALLEST),
        ("A / ~0", SMALLEST),
        ("A / B ** 3", SMALLEST),
    ],
)
def test_the_smallest_number_divided_by_minus_one_wraps_around(formula, value):
    """Unguarded, each of these ends the process with SIGFPE."""
    assert computed(without_traps(formula), A=SMALLEST, B=-1) == value


@pytest.mark.parametrize("formula", ["A + 1", "(A / 2) % 10", "A >> (BITS * 0x10)", "A % 0xFFFFFFFFFFFFFFFF"])
def test_a_formula_that_cannot_trap_stays_as_it_is(formula):
    assert without_traps(formula) == formula


@every_case(
    "formula",
    ["8 2 /", "/ 8 2", "A B /", "8 / 2 - -1 A", "8 / (2", "8 / 2)", "8 / ()", "8 // 2", "A / B(2)",
     "A / SGN 2", "A / B # 2", "A / é", "1 ? A / B", "A / B ,2", "(" * 100 + "A / B" + ")" * 100,
     " / ".join(["A"] * LONGEST), "A / " + "(A / " * 12 + "B" + ")" * 12],
)  # fmt: skip
def test_a_division_outside_the_grammar_is_refused_by_genapi(formula):
    assert computed(without_traps(formula), A=SMALLEST, B=-1) is None


def test_a_variable_with_the_name_of_a_function_is_not_called():
    assert without_traps("A / SGN(B)", ["A", "SGN"]).startswith(")")


def test_division_by_zero_stays_an_error():
    assert computed(without_traps("A / B"), A=5, B=0) is None


def some_formula(source: random.Random, depth: int) -> str:
    kind = source.choice(("value", "sign", "call", "choice", "binary", "binary")) if depth else "value"
    below = [some_formula(source, depth - 1) for _ in range(3 * (kind != "value"))]
    if kind == "value":
        return source.choice(("A", "B", "1", "2", "7", "0x10"))
    if kind == "sign":  # GenApi mistakes the operand of a sign that stands elsewhere
        return f"({source.choice('-~')}{source.choice('AB')})"
    if kind == "call":
        return f"{source.choice(('SGN', 'NEG'))}({below[0]})"
    if kind == "choice":
        return f"({below[0]} ? {below[1]} : {below[2]})"
    return f"{below[0]} {source.choice(OPERATORS)} {source.choice((below[1], f'({below[1]})'))}"


@every_case("seed", range(200))
def test_a_rewritten_formula_has_the_value_that_genapi_computes(seed):
    """GenApi's order of operators is not C's, so its own result is the only reference."""
    source = random.Random(seed)
    values = {"A": source.choice((-3, 0, 5, 9)), "B": source.choice((-7, 2, 3, 4))}
    formula = f"({some_formula(source, 2)}) / (A * A + 1) + {some_formula(source, 3)}"

    safe = without_traps(formula)

    assert safe != formula
    assert computed(safe, **values) == computed(formula, **values)


@given(st.text(alphabet="AB12 ()+-*/%&|<>=?:~^", max_size=30))
def test_whatever_is_left_does_not_trap(formula):
    value = computed(without_traps(formula), A=SMALLEST, B=-1)
    assert value is None or SMALLEST <= value < -SMALLEST  # and this process goes on


@every_case("seed", range(200))
def test_a_computed_formula_has_the_value_that_genapi_computes(seed):
    source = random.Random(seed)
    values = {"A": source.choice((-3, 0, 5, 9)), "B": source.choice((-7, 2, 3, 4))}
    formula = some_formula(source, 3)
    try:
        value = value_of(formula, values)
    except ValueError:
        assert any(part in formula for part in ("/", "%", "**", "SGN", "NEG", "<<", ">>")), formula
    else:
        assert value == computed(formula, **values), formula


@pytest.mark.parametrize("formula", ["A / 2", "2 ** A", "NEG(A)", "C", "A << 70", "A = ", "A .5", "1" * 5000])
def test_a_formula_that_is_not_computed_is_refused(formula):
    with pytest.raises(ValueError, match=r".+"):
        value_of(formula, {"A": 1})
