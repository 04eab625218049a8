"""Conditions on variants, such as ``objects.mass < 5 and input != 'clips/fall.npz'``.

A small part of Python, read by its own parser and checked node by node: numbers, text in quotes,
names with dots, comparisons (also chained), and, or, not, + - * / %, min, max, abs, and ``in`` with
a list of constants. All else is refused: attributes, other calls, powers; arithmetic is for numbers
only. A name with other characters is written in backticks: `object.tea-pot.mass`.
"""

from __future__ import annotations

import ast
import keyword
import re
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NoReturn

from halfphysics.base.suggestions import did_you_mean
from halfphysics.base.validation import shown
from halfphysics.errors import InputError

_LONGEST = 1000
_DEEPEST = 40
#: The first placeholder letter; each name gets a letter, from a script with enough letters.
_LETTER = 0x4E00

_FUNCTIONS = {"min": min, "max": max, "abs": abs}
_WORDS = (*keyword.kwlist, *_FUNCTIONS)
_TOKEN = re.compile(
    r"""(?P<text>'(?:[^'\\]|\\.)*'|"(?:[^"\\]|\\.)*")
      | (?P<number>\d[\w.]*|\.\d[\w.]*)
      | `(?P<quoted>[^`]+)`
      | (?P<name>[^\W\d]\w*(?:\.\w+)*)""",
    re.VERBOSE,
)

_ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Mod)
_COMPARISONS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq, ast.In, ast.NotIn)

#: Syntax that Python's parser accepts and a condition may not contain.
_REFUSED: Mapping[type[ast.AST], str] = {
    ast.Pow: "a power (**)",
    ast.Attribute: "an attribute of a value",
    ast.IfExp: "if ... else",
    ast.Lambda: "a lambda",
    ast.Subscript: "a value in brackets",
    ast.JoinedStr: "text with values in it",
    ast.Is: "is (expected ==)",
    ast.IsNot: "is not (expected !=)",
    ast.FloorDiv: "// (expected /)",
    ast.NamedExpr: "an assignment",
    ast.ListComp: "a loop",
    ast.GeneratorExp: "a loop",
    ast.Dict: "a mapping",
    ast.Starred: "a star",
}
_ALLOWED = (
    "numbers, text in quotes, names, comparisons, and, or, not, + - * / %, min, max, abs, and in "
    "with a list written out"
)


class Expression:
    """A condition, compiled once.

    Attributes:
        text: The source text.
        names: The names in the text, in order.
    """

    def __init__(self, text: str, known: Iterable[str]) -> None:
        """
        Args:
            text: The condition.
            known: All names that the condition may use.

        Raises:
            InputError: The text is invalid or has an unknown name; the message gives the column.
        """
        self.text = text
        if not isinstance(text, str) or not text.strip():
            raise InputError(f"found {shown(text)}, expected a condition, such as objects.mass < 5")
        if len(text) > _LONGEST:
            raise InputError(
                f"found a condition of {len(text)} characters, expected at most {_LONGEST}; "
                "several in a list must all hold"
            )
        plain, found = _placeholders(text)
        tree = _parsed(text, plain)
        check = _Check(text, plain, found)
        check.condition(tree.body, 0)
        known = tuple(known)
        for name, column in found.columns.items():
            if name not in known:
                hint = did_you_mean(name, known, otherwise=".")
                raise _error(text, column, f"unknown name {name}{hint} Known: {', '.join(known)}")
        self.names = tuple(found.columns)
        self._numbers = tuple(name for name in self.names if name in check.numbers)
        self._call = _compiled(tree, len(self.names))

    def __call__(self, values: Mapping[str, Any]) -> bool:
        """Whether the condition holds for these values of its names.

        Raises:
            InputError: A name has no value, or its value does not fit the operation.
        """
        try:
            arguments = [values[name] for name in self.names]
        except KeyError as error:
            raise InputError(f"{self.text}: {error.args[0]} has no value here") from None
        for name in self._numbers:
            if not isinstance(values[name], int | float):
                raise InputError(
                    f"{self.text}: {name} is {shown(values[name])}, expected a number to compute "
                    "with"
                )
        try:
            return bool(self._call(*arguments))
        except (TypeError, ArithmeticError) as error:
            here = ", ".join(f"{n} = {shown(values[n])}" for n in self.names)
            raise InputError(f"{self.text}: {error}, with {here or 'no names'}") from None

    def __reduce__(self) -> tuple[Any, ...]:
        return Expression, (self.text, self.names)


class _Names:
    """Names of a condition: the first column of each, and its placeholder in Python."""

    def __init__(self) -> None:
        self.columns: dict[str, int] = {}

    def placeholder(self, name: str, column: int) -> str:
        self.columns.setdefault(name, column)
        return chr(_LETTER + list(self.columns).index(name))

    def named(self, placeholder: str) -> str:
        return list(self.columns)[ord(placeholder) - _LETTER]


def _placeholders(text: str) -> tuple[str, _Names]:
    """The condition with every name replaced by a Python identifier, and the names.

    A replacement has the length of the name, so columns do not change.
    """
    found = _Names()

    def replaced(match: re.Match[str]) -> str:
        name = match["name"] or match["quoted"]
        if name is None or (match["name"] and name in _WORDS):
            return match[0]
        return found.placeholder(name.strip(), match.start() + 1).ljust(len(match[0]))

    return _TOKEN.sub(replaced, re.sub(r"\s", " ", text)), found


def _parsed(text: str, plain: str) -> ast.Expression:
    indent = len(plain) - len(plain.lstrip())
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of odd escapes in texts, numbers beside words
            return ast.parse(plain.lstrip(), mode="eval")
    except SyntaxError as error:
        end = len(plain.rstrip()) + 1
        column = error.offset + indent if error.offset else end  # none: more was expected
        said = (error.msg or "").partition(". Perhaps")[0]
        raise _error(text, min(column, end), f"cannot be read ({said})") from None
    except (RecursionError, MemoryError, ValueError) as error:
        raise InputError(f"{shown(text)}: cannot be read ({error})") from None


class _Check:
    """Walk through a condition: refuse forbidden syntax, note which names are numbers."""

    def __init__(self, text: str, plain: str, found: _Names) -> None:
        self.text, self.found = text, found
        self.plain = plain.lstrip().encode()
        self.indent = len(plain) - len(plain.lstrip())
        self.numbers: set[str] = set()

    def condition(self, node: ast.expr, depth: int) -> None:
        """Check a node that may have any type."""
        self._deep(node, depth)
        if isinstance(node, ast.BoolOp):
            for value in node.values:
                self.condition(value, depth + 1)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            self.condition(node.operand, depth + 1)
        elif isinstance(node, ast.Compare):
            self._comparison(node, depth)
        elif isinstance(node, ast.Constant):
            if not isinstance(node.value, int | float | str | None):
                self._refuse(node, f"the constant {shown(node.value)}")
        elif not isinstance(node, ast.Name):
            self.number(node, depth)

    def number(self, node: ast.expr, depth: int) -> None:
        """Check a node that must be a number."""
        self._deep(node, depth)
        if isinstance(node, ast.BinOp):
            if not isinstance(node.op, _ARITHMETIC):
                self._refuse(node, _REFUSED.get(type(node.op), "this operator"))
            self.number(node.left, depth + 1)
            self.number(node.right, depth + 1)
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.UAdd | ast.USub):
            self.number(node.operand, depth + 1)
        elif isinstance(node, ast.Call):
            self._call(node, depth)
        elif isinstance(node, ast.Name):
            if node.id in _FUNCTIONS:
                self._refuse(node, f"{node.id} without its parentheses")
            self.numbers.add(self.found.named(node.id))
        elif isinstance(node, ast.BoolOp):
            for value in node.values:
                self.number(value, depth + 1)
        elif isinstance(node, ast.Constant):
            if not isinstance(node.value, int | float):
                self._refuse(node, f"{shown(node.value)} where a number is needed")
        elif isinstance(node, ast.Compare) or (
            isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
        ):
            self.condition(node, depth)  # counts as 1 or 0
        elif isinstance(node, ast.List | ast.Tuple | ast.Set):
            self._refuse(node, "a list (only after in)")
        else:
            self._refuse(node, _REFUSED.get(type(node), "this"))

    def _comparison(self, node: ast.Compare, depth: int) -> None:
        self.condition(node.left, depth + 1)
        for operator, right in zip(node.ops, node.comparators, strict=True):
            if not isinstance(operator, _COMPARISONS):
                self._refuse(node, _REFUSED.get(type(operator), "this operator"))
            if not isinstance(operator, ast.In | ast.NotIn):
                self.condition(right, depth + 1)
                continue
            if not isinstance(right, ast.List | ast.Tuple) or len(node.ops) > 1:
                self._refuse(right, "in without a list after it, such as in [1, 2]")
            for item in right.elts:
                self.condition(item, depth + 1)

    def _call(self, node: ast.Call, depth: int) -> None:
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in _FUNCTIONS or node.keywords:
            self._refuse(node, "a call (only min, max and abs)")
        if (name == "abs") != (len(node.args) == 1) or not node.args:
            expected = "one number" if name == "abs" else "two numbers or more"
            self._refuse(node, f"{name} of {len(node.args)} (expected {expected})")
        for argument in node.args:
            self.number(argument, depth + 1)

    def _deep(self, node: ast.expr, depth: int) -> None:
        if depth > _DEEPEST:
            self._refuse(node, f"nesting of more than {_DEEPEST} levels")
        if isinstance(node, ast.Name) and node.id in _FUNCTIONS:
            self._refuse(node, f"{node.id} without its parentheses")

    def _refuse(self, node: ast.expr, what: str) -> NoReturn:
        column = len(self.plain[: node.col_offset].decode()) + self.indent + 1
        raise _error(self.text, column, f"found {what}; allowed are {_ALLOWED}")


def _compiled(tree: ast.Expression, count: int) -> Callable[..., Any]:
    """The condition as a function of the values of its names, in order."""
    arguments = ast.arguments(
        posonlyargs=[],
        args=[ast.arg(arg=chr(_LETTER + k)) for k in range(count)],
        kwonlyargs=[],
        kw_defaults=[],
        defaults=[],
    )
    function = ast.Expression(ast.Lambda(args=arguments, body=tree.body))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of comparisons such as 1 == 'a', which are only false
        code = compile(ast.fix_missing_locations(function), "<condition>", "eval")
    made: Callable[..., Any] = eval(code, {"__builtins__": {}, **_FUNCTIONS})
    return made


def _error(text: str, column: int, problem: str) -> InputError:
    return InputError(f"{shown(text)}, column {column}: {problem}")
