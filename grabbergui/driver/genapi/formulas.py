"""Integer formulas of a description: their values, and rewritten so that no division can end the program.

GenApi computes IntSwissKnife and IntConverter in 64-bit integers of the processor, where the smallest
number divided by −1 is a hardware exception (SIGFPE) and not an error. Whether that happens depends on
register values that nobody knows beforehand, so the formula itself has to rule it out.

The operators are those of the GenICam standard (GenApi 2.1.1, section 2.8.14). GenApi's parser accepts
more, such as operators behind their operands; a formula with a division may not use that.
"""

from __future__ import annotations

import operator
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Generic, TypeVar

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
RANK = {symbol: rank for rank, symbols in enumerate(_LEVELS) for symbol in symbols}

WORD_BITS = 64
"Bits of GenApi's integers."
_OPERATIONS: dict[str, Callable[[int, int], int]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt, "<=": operator.le,
    ">=": operator.ge, "&&": lambda left, right: bool(left) and bool(right),
    "||": lambda left, right: bool(left) or bool(right), "+": operator.add, "-": operator.sub,
    "*": operator.mul, "&": operator.and_, "|": operator.or_, "^": operator.xor, "<<": operator.lshift,
    ">>": operator.rshift,
}  # fmt: skip
"The operators whose values are computed here."

T = TypeVar("T")


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
        parser = _FormulaRewriter(formula)
        rewritten = parser.parse()
    except ValueError:
        return refused
    return rewritten if parser.guarded else formula


def value_of(formula: str, variables: Mapping[str, int]) -> int:
    """Return the value of a formula. Raises ValueError if it does not follow the grammar or has none."""
    if len(formula) > LONGEST:
        raise ValueError("too long")
    return _FormulaEvaluator(formula, variables).parse()


class _FormulaParser(ABC, Generic[T]):
    """Recursive-descent parser; its subclasses make something of the parts. Raises ValueError."""

    def __init__(self, formula: str) -> None:
        self._tokens = _tokens(formula)
        self._next = 0
        self._depth = 0

    def parse(self) -> T:
        result = self._choice()
        if self._peek():
            raise ValueError(f"'{self._peek()}' where the formula should end")
        return result

    @abstractmethod
    def _literal(self, token: str) -> T:
        """Return what a number or a variable stands for."""

    @abstractmethod
    def _called(self, function: str, argument: T) -> T: ...

    @abstractmethod
    def _signed(self, sign: str, operand: T) -> T: ...

    @abstractmethod
    def _chosen(self, condition: T, first: T, second: T) -> T: ...

    @abstractmethod
    def _operation(self, left: T, symbol: str, right: T) -> T: ...

    def _choice(self) -> T:
        self._depth += 1
        if self._depth > DEEPEST:
            raise ValueError("too deep")
        value = self._binary(0)
        while self._peek() == "?":
            self._take()
            chosen = self._binary(0)
            self._take(":")
            value = self._continued(self._chosen(value, chosen, self._binary(1)), 0)
        self._depth -= 1
        return value

    def _binary(self, rank: int) -> T:
        operand = self._binary(rank + 1) if rank + 1 < len(_LEVELS) else self._operand()
        return self._continued(operand, rank)

    def _continued(self, left: T, rank: int) -> T:
        """Parse all operations of this rank that follow `left`."""
        while RANK.get(self._peek()) == rank:
            symbol = self._take()
            right = self._binary(rank + 1) if rank + 1 < len(_LEVELS) else self._operand()
            left = self._operation(left, symbol, right)
        return left

    def _operand(self) -> T:
        signs: list[str] = []
        while self._peek() in ("+", "-", "~"):
            signs.append(self._take())
        token = self._take()
        if token == "(":
            value = self._choice()
            self._take(")")
        elif token in _FUNCTIONS:
            self._take("(")
            value = self._called(token, self._choice())
            self._take(")")
        elif token and (token[0].isalnum() or token[0] == "_"):
            value = self._literal(token)
        else:
            raise ValueError(f"'{token}' where a value should be")
        for sign in reversed(signs):
            value = self._signed(sign, value)
        return value

    def _peek(self) -> str:
        return self._tokens[self._next]

    def _take(self, expected: str = "") -> str:
        token = self._peek()
        if not token or (expected and token != expected):
            raise ValueError(f"'{token}' instead of '{expected}'")
        self._next += 1
        return token


class _FormulaRewriter(_FormulaParser[str]):
    """Returns the text with every operation in parentheses.

    So GenApi computes exactly what was parsed here, whatever its precedence rules.
    """

    guarded = False
    "Whether a divisor had to be guarded."

    def _literal(self, token: str) -> str:
        return token

    def _called(self, function: str, argument: str) -> str:
        return f"{function}({argument})"

    def _signed(self, sign: str, operand: str) -> str:
        return f"({sign}{operand})"

    def _chosen(self, condition: str, first: str, second: str) -> str:
        return f"({condition} ? {first} : {second})"

    def _operation(self, left: str, symbol: str, right: str) -> str:
        rewritten = self._rewritten(left, symbol, right)
        if len(rewritten) > LONGEST:
            raise ValueError("too long")
        return rewritten

    def _rewritten(self, left: str, symbol: str, right: str) -> str:
        """Return one operation; divide by 1 instead of −1 and multiply the quotient by −1.

        GenApi evaluates both branches of `?:`, so a condition around the division itself would not help.
        """
        if symbol not in ("/", "%") or right.isdecimal() or right.startswith("0x"):
            return f"({left} {symbol} {right})"
        self.guarded = True
        divisor = f"({right} = (0 - 1) ? 1 : {right})"
        if symbol == "%":
            return f"({left} % {divisor})"
        return f"(({left} / {divisor}) * ({right} = (0 - 1) ? (0 - 1) : 1))"


class _FormulaEvaluator(_FormulaParser[int]):
    """Computes the value; refuses divisions, powers and functions, which conditions do not need."""

    def __init__(self, formula: str, variables: Mapping[str, int]) -> None:
        super().__init__(formula)
        self._variables = variables

    def _literal(self, token: str) -> int:
        if token[0].isdigit():
            return int(token, 0) if token.startswith("0x") else int(token)
        if token not in self._variables:
            raise ValueError(f"no variable {token}")
        return self._variables[token]

    def _called(self, function: str, argument: int) -> int:
        raise ValueError(f"no function {function}")

    def _signed(self, sign: str, operand: int) -> int:
        return {"+": operand, "-": -operand, "~": ~operand}[sign]

    def _chosen(self, condition: int, first: int, second: int) -> int:
        return first if condition else second

    def _operation(self, left: int, symbol: str, right: int) -> int:
        if symbol in ("<<", ">>") and not 0 <= right < WORD_BITS:
            raise ValueError(f"a shift by {right}")
        if symbol not in _OPERATIONS:
            raise ValueError(f"no operator {symbol}")
        value = int(_OPERATIONS[symbol](left, right)) % (1 << WORD_BITS)
        return value - (1 << WORD_BITS) if value >> (WORD_BITS - 1) else value


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
