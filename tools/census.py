"""Count what the ratchet in tests/ratchet.toml limits: lines, files, names, arrows between folders, and prose.

python -m tools.census            print each count
python -m tools.census --where X  print the places of a count, like `long_sentences`
"""

import ast
import inspect
import io
import re
import sys
import tokenize
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from tools import REPOSITORY, command_line

PACKAGE = REPOSITORY / "ipoa_mission"
SMALL_FILE = 60  # lines
MANY_PARAMETERS = 6
LONG_SENTENCE = 25  # words
DIALECT = re.compile(r"\b(?:told|stands?|so (?:many|much)|anew|oftener|seldomer|beside|lest)\b", re.IGNORECASE)
#: A sentence that begins with a relative clause, and asks no question.
CLAUSE = re.compile(r"(?:What|Who|Whose|Where|Whether|How)\b[^?]*$")
SENTENCE = re.compile(r"(?<=[.?!])\s+(?=[A-Z`*(])|\n\s*\n|\n(?=\s*[-*|#>])")
CODE = re.compile(r"```.*?```|^\s*>>>.*?(?=\n\s*\n|\Z)|^    .*?$|`[^`]*`", re.DOTALL | re.MULTILINE)
ADVERBS = re.compile(
    "SURELY|BARELY|PERHAPS|NEVER|NEARLY|MOST|SAME|BESIDE|AGAIN|ANYWHERE|NOWHERE|OTHERS|FIRMLY|FINELY|ROUGHLY|ALIKE"
    "|SURER|SURE|FAR|NEAR|CLOSE|SLOW|FAST|HIGH|LOW|FINE|FIRM|ROUGH|HARD|SOFT|DEEP|STEEP|LARGE|LONG|SHORT|THIN"
)
ASIDE = {"lab", "reproduction", "reproduction.md"}  # of the docs


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    return tuple(ast.walk(tree(path)))


@cache
def trees() -> dict[Path, ast.Module]:
    return {path: tree(path) for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def name_of(path: Path) -> str:
    return ".".join(path.relative_to(REPOSITORY).with_suffix("").parts).removesuffix(".__init__")


def lines() -> Iterator[str]:
    for path in trees():
        yield from [name_of(path)] * len(path.read_text(encoding="utf-8").splitlines())


def small_files() -> Iterator[str]:
    """Return modules under 60 lines, without those that only describe a folder."""
    for path, tree in trees().items():
        describes = all(isinstance(node, ast.Expr) for node in tree.body)
        if not describes and len(path.read_text(encoding="utf-8").splitlines()) < SMALL_FILE:
            yield name_of(path)


@cache
def importers() -> dict[str, set[str]]:
    modules = {name_of(path) for path in trees()}
    by_module: dict[str, set[str]] = defaultdict(set)
    for path in trees():
        for node in nodes(path):
            names: set[str] = set()
            if isinstance(node, ast.Import):
                names = {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
            for name in (names & modules) - {name_of(path)}:
                by_module[name].add(name_of(path))
    return by_module


def single_importers() -> Iterator[str]:
    yield from (name for name, by in sorted(importers().items()) if len(by) == 1)


def arrows() -> Iterator[str]:
    """Yield pairs of top folders: the importing one, the imported one."""
    pairs = {(_folder(a), _folder(b)) for b, by in importers().items() for a in by}
    yield from sorted(f"{a} -> {b}" for a, b in pairs if a != b and "" not in (a, b))


def mutual_pairs() -> Iterator[str]:
    pairs = {tuple(arrow.split(" -> ")) for arrow in arrows()}
    yield from sorted(f"{a} <-> {b}" for a, b in pairs if a < b and (b, a) in pairs)


def _folder(module: str) -> str:
    parts = module.split(".")
    return parts[1] if len(parts) > 2 else ""


def constants() -> Iterator[str]:
    for path, tree in trees().items():
        for node in tree.body:
            if isinstance(node, ast.Assign | ast.AnnAssign):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                for name in (each for target in targets for each in ast.walk(target)):
                    if isinstance(name, ast.Name) and name.id.strip("_").isupper():
                        yield f"{name_of(path)}:{name.lineno} {name.id}"


def adverb_constants() -> Iterator[str]:
    yield from (place for place in constants() if ADVERBS.fullmatch(place.split()[-1].strip("_")))


def many_parameters() -> Iterator[str]:
    for path in trees():
        for node in nodes(path):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                parameters = [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]
                if len({each.arg for each in parameters} - {"self", "cls"}) >= MANY_PARAMETERS:
                    yield f"{name_of(path)}:{node.lineno} {node.name}"


def packed_assignments() -> Iterator[str]:
    """Yield assignments like `a, b = f(), g()`."""
    for path in trees():
        for node in nodes(path):
            if isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple):
                targets = [target for target in node.targets if isinstance(target, ast.Tuple)]
                if any(len(target.elts) == len(node.value.elts) for target in targets):
                    yield f"{name_of(path)}:{node.lineno}"


def walruses() -> Iterator[str]:
    for path in trees():
        for node in nodes(path):
            if isinstance(node, ast.NamedExpr):
                yield f"{name_of(path)}:{node.lineno} {node.target.id}"


@cache
def prose() -> list[tuple[str, str]]:
    return [*comments(), *messages(), *((_page(page), page.read_text(encoding="utf-8")) for page in docs())]


@cache
def comments() -> list[tuple[str, str]]:
    texts = []
    for path in trees():
        texts += [(f"{name_of(path)}:{text.lineno}", inspect.cleandoc(text.value)) for text in _docstrings(path)]
        for token in tokenize.generate_tokens(io.StringIO(path.read_text(encoding="utf-8")).readline):
            if token.type == tokenize.COMMENT:
                texts.append((f"{name_of(path)}:{token.start[0]}", token.string.lstrip("#: ")))
    return texts


@cache
def messages() -> list[tuple[str, str]]:
    """Return the strings of three words or more that are no docstrings."""
    texts = []
    for path in trees():
        docstrings = {id(constant) for constant in _docstrings(path)}
        for node in nodes(path):
            text = node.value if isinstance(node, ast.Constant) and id(node) not in docstrings else None
            if isinstance(text, str) and isinstance(node, ast.Constant) and len(text.split()) > 2:
                texts.append((f"{name_of(path)}:{node.lineno}", text))
    return texts


def _docstrings(path: Path) -> Iterator[Any]:
    """Return the constants that document a module, class, function or, below an assignment, a name."""
    for node in nodes(path):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            values = (each.value for each in node.body if isinstance(each, ast.Expr))
            yield from (each for each in values if isinstance(each, ast.Constant) and isinstance(each.value, str))


def _page(path: Path) -> str:
    return path.relative_to(REPOSITORY).as_posix()


def docs() -> list[Path]:
    pages = [page for page in (REPOSITORY / "docs").rglob("*.md") if not ASIDE & set(page.parts)]
    return sorted([*pages, *(REPOSITORY / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md"))])


@cache
def sentences() -> list[tuple[str, str]]:
    split = ((place, sentence) for place, text in prose() for sentence in SENTENCE.split(CODE.sub(" X ", text)))
    pairs = ((place, " ".join(sentence.split())) for place, sentence in split)
    return [(place, words) for place, words in pairs if words and not words.startswith("|")]


def dialect() -> Iterator[str]:
    for place, text in prose():
        yield from (f"{place} {match[0]}" for match in DIALECT.finditer(CODE.sub(" ", text)))


def clause_subjects() -> Iterator[str]:
    yield from (f"{place} {words}" for place, words in sentences() if CLAUSE.match(words))


def long_sentences() -> Iterator[str]:
    yield from (f"{place} {words}" for place, words in sentences() if len(words.split()) > LONG_SENTENCE)


def docstring_words() -> Iterator[str]:
    yield from (word for _, text in comments() for word in text.split())


def doc_words() -> Iterator[str]:
    for page in docs():
        yield from page.read_text(encoding="utf-8").split()


COUNTS: dict[str, Callable[[], Iterator[str]]] = {
    count.__name__: count
    for count in (
        lines, small_files, single_importers, arrows, mutual_pairs, constants, adverb_constants, many_parameters,
        packed_assignments, walruses, dialect, clause_subjects, long_sentences, docstring_words, doc_words,
    )
}  # fmt: skip


def main(arguments: list[str]) -> int:
    parser = command_line(__doc__)
    parser.add_argument("--where", choices=sorted(COUNTS), help="print the places of this count")
    options = parser.parse_args(arguments)
    if options.where:
        for place, times in Counter(COUNTS[options.where]()).items():
            print(place if times == 1 else f"{place} ({times})")
        return 0
    for name, count in COUNTS.items():
        print(f"{name} = {sum(1 for _ in count())}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
