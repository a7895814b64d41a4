"""Integer formulas of a description, rewritten so that no division can end the program.

GenApi computes IntSwissKnife and IntConverter in 64-bit integers of the processor, where the smallest
number divided by −1 is a hardware exception (SIGFPE) and not an error. Whether that happens depends on
register values that nobody knows beforehand, so the formula itself has to rule it out.

The operators are those of the GenICam standard (GenApi 2.1.1, section 2.8.14). GenApi's parser accepts
more, such as operators behind their operands; a formula with a division may not use that.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

LONGEST = 4_000
"Characters of a formula with a division, before and after it is rewritten; the longest known has 800."
DEEPEST = 64
"Parentheses and ternaries inside each other."

_TOKEN = re.compile(
    r"\s*(0x[0-9A-Fa-f]+|[0-9]+|[A-Za-z_][A-Za-z0-9_.]*|\*\*|<<|>>|<=|>=|<>|&&|\|\||[-+*/%&|^~<>=?:()])\s*"
)
_FUNCTIONS = frozenset({"SGN", "NEG"})
"The functions that GenApi knows in integer formulas."
_LEVELS = (
    ("=", "<>", "<", ">", "<=", ">=", "&&", "||"),
    ("+", "-"),
    ("*", "/", "%"),
    ("**", "<<", ">>", "&", "|", "^"),
)
"""Operators as GenApi 3.5 ranks them, weakest first; this is not C's order.

Each level is taken from left to right. `?:` belongs to the weakest, so `a ? b : c = d` is `(a ? b : c) = d`.
"""
RANK = {operator: rank for rank, operators in enumerate(_LEVELS) for operator in operators}


def without_traps(formula: str, variables: Iterable[str] = ()) -> str:
    """Return a formula of the same value that cannot trap; unchanged if all divisors are literal numbers.

    A formula with a division that does not follow the grammar becomes one that GenApi refuses, which
    disables only its own feature. `variables`: the names that the node declares.
    """
    if "/" not in formula and "%" not in formula:
        return formula
    refused = f") {formula}"
    if len(formula) > LONGEST or not _FUNCTIONS.isdisjoint(variables):
        return refused
    try:
        parser = _FormulaParser(formula)
        rewritten = parser.formula()
    except ValueError:
        return refused
    return rewritten if parser.guarded else formula


class _FormulaParser:
    """Recursive-descent parser that returns the text with every operation in parentheses.

    So GenApi computes exactly what was parsed here, whatever its precedence rules. Raises ValueError.
    """

    def __init__(self, formula: str) -> None:
        self._tokens = _tokens(formula)
        self._next = 0
        self._depth = 0
        self.guarded = False
        "Whether a divisor had to be guarded."

    def formula(self) -> str:
        text = self._choice()
        if self._peek():
            raise ValueError(f"'{self._peek()}' where the formula should end")
        return text

    def _choice(self) -> str:
        self._depth += 1
        if self._depth > DEEPEST:
            raise ValueError("too deep")
        value = self._binary(0)
        while self._peek() == "?":
            self._take()
            chosen = self._binary(0)
            self._take(":")
            value = self._continued(f"({value} ? {chosen} : {self._binary(1)})", 0)
        self._depth -= 1
        return value

    def _binary(self, rank: int) -> str:
        operand = self._binary(rank + 1) if rank + 1 < len(_LEVELS) else self._operand()
        return self._continued(operand, rank)

    def _continued(self, left: str, rank: int) -> str:
        """Parse all operations of this rank that follow `left`."""
        while RANK.get(self._peek()) == rank:
            operator = self._take()
            right = self._binary(rank + 1) if rank + 1 < len(_LEVELS) else self._operand()
            left = self._operation(left, operator, right)
            if len(left) > LONGEST:
                raise ValueError("too long")
        return left

    def _operand(self) -> str:
        signs: list[str] = []
        while self._peek() in ("+", "-", "~"):
            signs.append(self._take())
        token = self._take()
        if token == "(":
            value = self._choice()
            self._take(")")
        elif token in _FUNCTIONS:
            self._take("(")
            value = f"{token}({self._choice()})"
            self._take(")")
        elif token and (token[0].isalnum() or token[0] == "_"):
            value = token
        else:
            raise ValueError(f"'{token}' where a value should be")
        for sign in reversed(signs):
            value = f"({sign}{value})"
        return value

    def _operation(self, left: str, operator: str, right: str) -> str:
        """Return one operation; divide by 1 instead of −1 and multiply the quotient by −1.

        GenApi evaluates both branches of `?:`, so a condition around the division itself would not help.
        """
        if operator not in ("/", "%") or right.isdecimal() or right.startswith("0x"):
            return f"({left} {operator} {right})"
        self.guarded = True
        divisor = f"({right} = (0 - 1) ? 1 : {right})"
        if operator == "%":
            return f"({left} % {divisor})"
        return f"(({left} / {divisor}) * ({right} = (0 - 1) ? (0 - 1) : 1))"

    def _peek(self) -> str:
        return self._tokens[self._next]

    def _take(self, expected: str = "") -> str:
        token = self._peek()
        if not token or (expected and token != expected):
            raise ValueError(f"'{token}' instead of '{expected}'")
        self._next += 1
        return token


def _tokens(formula: str) -> list[str]:
    """Return the formula's tokens, followed by an empty one."""
    tokens: list[str] = []
    position, end = 0, len(formula.rstrip())
    while position < end:
        match = _TOKEN.match(formula, position)
        if match is None:
            raise ValueError(f"'{formula[position]}' has no place in a formula")
        tokens.append(match[1])
        position = match.end()
    return [*tokens, ""]
