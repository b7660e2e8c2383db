"""Lists mutants of a source file: one small change each, of an operator, a bound, a condition or an early return."""

from __future__ import annotations

import ast
import itertools
import re
from collections.abc import Iterator
from dataclasses import dataclass

COMPARISONS: dict[type[ast.cmpop], tuple[str, tuple[tuple[str, str], ...]]] = {
    ast.Lt: ("<", (("<=", "boundary"), (">=", "comparison"))),
    ast.LtE: ("<=", (("<", "boundary"), (">", "comparison"))),
    ast.Gt: (">", ((">=", "boundary"), ("<=", "comparison"))),
    ast.GtE: (">=", ((">", "boundary"), ("<", "comparison"))),
    ast.Eq: ("==", (("!=", "comparison"),)),
    ast.NotEq: ("!=", (("==", "comparison"),)),
    ast.Is: ("is", (("is not", "comparison"),)),
    ast.IsNot: (r"is\s+not", (("is", "comparison"),)),
    ast.In: ("in", (("not in", "comparison"),)),
    ast.NotIn: (r"not\s+in", (("in", "comparison"),)),
}
ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"),
    ast.Sub: ("-", "+"),
    ast.Mult: ("*", "/"),
    ast.Div: ("/", "*"),
    ast.FloorDiv: ("//", "*"),
    ast.Mod: ("%", "*"),
    ast.Pow: ("**", "*"),
    ast.BitAnd: ("&", "|"),
    ast.BitOr: ("|", "&"),
}
SWAPPED = {
    **{"min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "any": "all", "all": "any"},
    **{"floor": "ceil", "ceil": "floor", "argmin": "argmax", "argmax": "argmin", "cos": "sin", "sin": "cos"},
}
"""Functions and methods by their replacements."""
TEXTS = frozenset({"detail", "text", "why", "description"})
"""Arguments that people read. A change of them changes no decision."""
TELLS = frozenset({"tell", "tell_fault", "tell_words", "ask_person"})
"""Methods whose arguments are mostly text."""
MORE, LESS = 1.25, 0.8
"""Factors by which a named bound is made larger and smaller. Ours."""


@dataclass(frozen=True)
class Mutant:
    """One change of a source file.

    Attributes:
        line: Number of its line.
        start: Offset of the replaced text (bytes).
        end: Offset of its end (bytes).
        new: The replacement.
        kind: The kind of change, in a word.
        lines: First and last line of the smallest statement around it (of its head, if it has a body).
        name: The constant or field that it defines, outside of functions.
        imports: True if it takes effect when the module is imported.
    """

    line: int
    start: int
    end: int
    new: str
    kind: str
    lines: tuple[int, int]
    name: str | None
    imports: bool

    def applied(self, source: bytes) -> bytes:
        """Return the source with this change."""
        return source[: self.start] + self.new.encode() + source[self.end :]

    def change(self, source: bytes) -> str:
        """Return the changed line, before and after, for people."""
        first = source.rfind(b"\n", 0, self.start) + 1
        last = source.find(b"\n", self.end)
        before = source[first:last].decode()
        after = (source[first : self.start] + self.new.encode() + source[self.end : last]).decode()
        return f"{_shown(before)} -> {_shown(after)}"


def _shown(code: str) -> str:
    return re.sub(r"\s+", " ", code).strip()


def mutants_of(source: bytes) -> list[Mutant]:
    """Return the mutants of a source file, in the order of their positions."""
    finder = _Finder(source)
    finder.visit(ast.parse(source))
    return sorted(set(finder.found), key=lambda mutant: (mutant.start, mutant.end, mutant.new))


class _Finder(ast.NodeVisitor):
    def __init__(self, source: bytes) -> None:
        self._source = source
        starts = [0, *(found.end() for found in re.finditer(rb"\n", source))]
        self._starts = starts
        self._statement: tuple[int, int] = (1, 1)
        self._function = False
        self._name: str | None = None
        self.found: list[Mutant] = []

    # ---- positions

    def _span(self, node: ast.expr | ast.stmt) -> tuple[int, int]:
        assert node.end_lineno is not None and node.end_col_offset is not None
        first = self._starts[node.lineno - 1] + node.col_offset
        return first, self._starts[node.end_lineno - 1] + node.end_col_offset

    def _text(self, node: ast.expr | ast.stmt) -> str:
        first, last = self._span(node)
        return self._source[first:last].decode()

    def _add(self, start: int, end: int, new: str, kind: str) -> None:
        line = self._source.count(b"\n", 0, start) + 1
        self.found.append(Mutant(line, start, end, new, kind, self._statement, self._name, not self._function))

    def _replace(self, node: ast.expr | ast.stmt, new: str, kind: str) -> None:
        first, last = self._span(node)
        lines = self._source.count(b"\n", first, last)
        # The lines after it keep their numbers.
        self._add(first, last, new if not lines else f"({new}{chr(10) * lines})", kind)

    def _between(self, left: ast.expr, right: ast.expr, pattern: str, new: str, kind: str) -> None:
        first, last = self._span(left)[1], self._span(right)[0]
        found = re.search(rb"(?<![\w<>=!*/])(?:" + pattern.encode() + rb")(?![\w<>=*/])", self._source[first:last])
        if found:
            self._add(first + found.start(), first + found.end(), new, kind)

    # ---- omitted code

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Skip text for people."""

    def visit_Raise(self, node: ast.Raise) -> None:
        """Skip an error's text."""

    def visit_Assert(self, node: ast.Assert) -> None:
        """Skip an assertion, which only informs the type checker."""

    def visit_Import(self, node: ast.Import) -> None:
        """Skip an import: it has no operator."""

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        """Skip an import: it has no operator."""

    def visit_keyword(self, node: ast.keyword) -> None:
        """Visit arguments, except those that people read."""
        if node.arg not in TEXTS:
            self.generic_visit(node)

    # ---- statements

    def visit(self, node: ast.AST) -> None:
        """Remember the smallest statement around each expression."""
        if not isinstance(node, ast.stmt):
            super().visit(node)
            return
        before = self._statement
        body = getattr(node, "body", None)
        last = body[0].lineno - 1 if body else node.end_lineno
        self._statement = (node.lineno, max(last or node.lineno, node.lineno))
        super().visit(node)
        self._statement = before

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        """Visit the body; defaults of arguments belong to the code around."""
        for default in (*node.args.defaults, *(item for item in node.args.kw_defaults if item)):
            self.visit(default)
        before, self._function = self._function, True
        name, self._name = self._name, None
        for statement in node.body:
            self.visit(statement)
        self._function, self._name = before, name

    def visit_Lambda(self, node: ast.Lambda) -> None:
        """Visit a function as well."""
        before, self._function = self._function, True
        self.visit(node.body)
        self._function = before

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        """Visit fields and methods."""
        for statement in node.body:
            self.visit(statement)

    def visit_Assign(self, node: ast.Assign) -> None:
        """Visit a constant outside of functions; otherwise its value."""
        target = node.targets[0]
        self._define(target.id if isinstance(target, ast.Name) else None, node.value)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        """Visit the same without the annotation."""
        if node.value is not None:
            self._define(node.target.id if isinstance(node.target, ast.Name) else None, node.value)

    def _define(self, name: str | None, value: ast.expr) -> None:
        if self._function:
            self.visit(value)
            return
        self._name = name
        self._bound(value)
        self._name = None

    def _bound(self, value: ast.expr) -> None:
        """Make a constant larger and smaller, or take one element out of a set."""
        if isinstance(value, ast.Tuple) and any(isinstance(elt, ast.Constant) for elt in value.elts):
            for elt in value.elts:
                self._bound(elt)
        elif isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "frozenset":
            for argument in value.args:
                self._elements(argument)
        elif isinstance(value, ast.Tuple | ast.Set):
            self._elements(value)
        elif isinstance(value, ast.Constant) and isinstance(value.value, bool):
            self._replace(value, str(not value.value), "bound")
        elif isinstance(value, ast.Constant) and isinstance(value.value, int):
            self._replace(value, str(value.value + 1), "bound")
            self._replace(value, str(value.value - 1), "bound")
        elif isinstance(value, ast.Constant | ast.BinOp | ast.UnaryOp) and not self._is_text(value):
            text = self._text(value)
            self._replace(value, f"({text}) * {MORE}", "bound")
            self._replace(value, f"({text}) * {LESS}", "bound")
        elif not isinstance(value, ast.Constant | ast.Name):
            self.generic_visit(value)

    def _elements(self, value: ast.expr) -> None:
        if isinstance(value, ast.Set | ast.Tuple) and len(value.elts) > 1:
            texts = [self._text(elt) for elt in value.elts]
            for k in range(len(texts)):
                left = ", ".join(texts[:k] + texts[k + 1 :])
                self._replace(value, f"{{{left}}}" if isinstance(value, ast.Set) else f"({left},)", "element dropped")

    @staticmethod
    def _is_text(value: ast.expr) -> bool:
        """True for text, and for a union of types."""
        if isinstance(value, ast.Constant):
            return not isinstance(value.value, float)
        inner = list(ast.walk(value))
        strings = any(isinstance(constant, ast.Constant) and isinstance(constant.value, str) for constant in inner)
        return strings or any(isinstance(item, ast.BitOr) for item in inner)

    def visit_If(self, node: ast.If) -> None:
        """Disable an early return; negate a condition."""
        if not node.orelse and isinstance(node.body[-1], ast.Return | ast.Continue | ast.Break):
            self._replace(node.test, "False", "early return")
        self._condition(node.test)
        for statement in (*node.body, *node.orelse):
            self.visit(statement)

    def visit_While(self, node: ast.While) -> None:
        """Negate a condition."""
        self._condition(node.test)
        for statement in node.body:
            self.visit(statement)

    def visit_IfExp(self, node: ast.IfExp) -> None:
        """Swap the two branches."""
        self._replace(node.test, f"not ({self._text(node.test)})", "branches swapped")
        self.generic_visit(node)

    def _condition(self, test: ast.expr) -> None:
        if not isinstance(test, ast.Compare | ast.BoolOp | ast.UnaryOp):
            self._replace(test, f"not ({self._text(test)})", "negated")
        self.visit(test)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        """Omit the statement, or replace its operator."""
        self._replace(node, "None", "left out")
        pair = ARITHMETIC.get(type(node.op))
        if pair is not None:
            self._between(node.target, node.value, re.escape(pair[0]) + "=", pair[1] + "=", "arithmetic")
        self.visit(node.value)

    def visit_Expr(self, node: ast.Expr) -> None:
        """Omit a call for its effect."""
        if not isinstance(node.value, ast.Call):
            if not isinstance(node.value, ast.Constant):
                self.generic_visit(node)
            return
        if not (isinstance(node.value.func, ast.Attribute) and node.value.func.attr in TELLS):
            self._replace(node, "None", "left out")
            self.generic_visit(node)

    def visit_Return(self, node: ast.Return) -> None:
        """Swap elements of a ranking."""
        if isinstance(node.value, ast.Tuple):
            parts = node.value.elts
            for part, other in itertools.pairwise(parts):
                first, last = self._span(part)[0], self._span(other)[1]
                between = self._source[self._span(part)[1] : self._span(other)[0]].decode()
                self._add(first, last, self._text(other) + between + self._text(part), "order")
        self.generic_visit(node)

    # ---- expressions

    def visit_Compare(self, node: ast.Compare) -> None:
        """Replace the comparison."""
        operands = [node.left, *node.comparators]
        for left, right, operator in zip(operands[:-1], operands[1:], node.ops, strict=True):
            pattern, others = COMPARISONS[type(operator)]
            for new, kind in others:
                self._between(left, right, pattern, new, kind)
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        """Replace the operator."""
        pair = ARITHMETIC.get(type(node.op))
        text = any(isinstance(item, ast.JoinedStr) or self._is_string(item) for item in (node.left, node.right))
        if pair is not None and not text and (self._function or not isinstance(node.op, ast.BitOr)):
            self._between(node.left, node.right, re.escape(pair[0]), pair[1], "arithmetic")
        self.generic_visit(node)

    @staticmethod
    def _is_string(node: ast.expr) -> bool:
        return isinstance(node, ast.Constant) and isinstance(node.value, str)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        """Replace the operator, or drop one operand."""
        pattern, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for left, right in zip(node.values[:-1], node.values[1:], strict=True):
            self._between(left, right, pattern, new, "and/or")
        for value in node.values:
            self._replace(value, "True" if isinstance(node.op, ast.And) else "False", "operand dropped")
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        """Remove the sign."""
        if not (isinstance(node.op, ast.UAdd)):
            self._replace(node, f"({self._text(node.operand)})", "sign")
        if not isinstance(node.operand, ast.Constant):
            self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> None:
        """Use the opposite function; omit `abs`."""
        name = node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")
        if name in SWAPPED:
            last = self._span(node.func)[1]
            self._add(last - len(name), last, SWAPPED[name], "function")
        elif name == "abs" and len(node.args) == 1:
            self._replace(node, f"({self._text(node.args[0])})", "abs")
        if name == "isinstance":
            self.visit(node.args[0])
        elif name not in TELLS:
            self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        """Replace the number or the truth value."""
        value = node.value
        if isinstance(value, bool):
            self._replace(node, str(not value), "constant")
        elif isinstance(value, int):
            self._replace(node, str(value + 1), "constant")
        elif isinstance(value, float):
            self._replace(node, repr(value * MORE) if value else "1.0", "constant")

    def visit_Subscript(self, node: ast.Subscript) -> None:
        """Visit indices; types in brackets are no numbers."""
        self.visit(node.value)
        self.visit(node.slice)


def reads(source: bytes) -> Iterator[tuple[str, tuple[int, int]]]:
    """Yield each name and field that a source reads, with the first and the last line of its statement."""
    for statement in ast.walk(ast.parse(source)):
        if not isinstance(statement, ast.stmt):
            continue
        body = getattr(statement, "body", None)
        last = body[0].lineno - 1 if body else statement.end_lineno
        lines = statement.lineno, max(last or 0, statement.lineno)
        for field, head in ast.iter_fields(statement):
            if field in ("body", "orelse", "finalbody", "handlers"):
                continue
            for item in head if isinstance(head, list) else [head]:
                for node in ast.walk(item) if isinstance(item, ast.AST) else ():
                    name = getattr(node, "id", None) or getattr(node, "attr", None)
                    if name is not None:
                        yield name, lines
