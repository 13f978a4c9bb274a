import re
import textwrap

WIDTH = 120  # columns
_KEPT = ("|", "#", "!")  # not filled: tables, headings, pictures
_GLUED = "\N{NO-BREAK SPACE}"


def filled(text: str) -> str:
    r"""Fill paragraphs and list items to `WIDTH`.

    >>> print(filled("* one\n  and\n* two"), end="")
    * one and
    * two
    """
    return "\n\n".join(_filled(block) for block in re.split(r"\n\n+", text.strip("\n"))) + "\n"


def _filled(block: str) -> str:
    if block.startswith(_KEPT):
        return block
    if block.startswith("* "):
        items = re.split(r"(?m)^\* ", block)[1:]
        return "\n".join(f"* {_paragraph(item, '  ')}" for item in items)
    return _paragraph(block, "")


def _paragraph(words: str, indent: str) -> str:
    # a sign of a list or heading must not begin a line
    glued = re.sub(r" (?=([-+*=#>]|\d+[.)]) )", _GLUED, " ".join(words.split(" ")).replace("\n", " "))
    lines = textwrap.wrap(re.sub(" +", " ", glued), WIDTH - len(indent), break_long_words=False, break_on_hyphens=False)
    return f"\n{indent}".join(lines).replace(_GLUED, " ")
