"""Plain mutants of Rust as rustfmt lays it out: where a body of a function can be changed by one token or statement."""
import pathlib, re
from dataclasses import dataclass

TOKEN = re.compile(
    r"""(?P<space>\s+|//[^\n]*|/\*.*?\*/)
    |(?P<text>b?r(?P<hashes>\#*)".*?"(?P=hashes)|b?"(?:\\.|[^"\\])*"|b?'(?:\\[^']+|[^\\'])')
    |(?P<lifetime>'\w+)
    |(?P<number>\d[\d_]*(?:\.\d[\d_]*|\.(?![.\w]))?(?:e[+-]?\d+)?(?:_?[iuf]\w+)?|0x[0-9a-fA-F_]+\w*)
    |(?P<word>\w+)
    |(?P<sign><<=|>>=|\.\.=|::|->|=>|==|!=|<=|>=|&&|\|\||[-+*/%&|^]=|\.\.|.)""",
    re.S | re.X,
)
OPENS = {"(": ")", "[": "]", "{": "}"}
KEYWORDS = {"return", "move", "in", "if", "else", "match", "while", "let", "mut", "ref", "as", "break", "unsafe", "where", "for", "dyn", "impl"}
# Loosened or tightened, and turned.
SWAPS = {
    "<": ["<=", ">="], "<=": ["<", ">"], ">": [">=", "<="], ">=": [">", "<"], "==": ["!="], "!=": ["=="],
    "+": ["-"], "-": ["+"], "*": ["/"], "/": ["*"], "%": ["+"], "+=": ["-="], "-=": ["+="], "*=": ["/="], "/=": ["*="],
    "&&": ["||"], "||": ["&&"],
}
KINDS = {**dict.fromkeys("<>=!", "comparison"), **dict.fromkeys("+-*/%", "arithmetic"), **dict.fromkeys("&|", "logic")}
NAMES = {"min": "max", "max": "min", "min_by": "max_by", "max_by": "min_by", "min_by_key": "max_by_key", "max_by_key": "min_by_key"}
LEFT_OUT = {"clamp", "abs"}


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    start: int
    end: int
    # Whitespace on the left and on the right: rustfmt has both about an operator of two operands, neither about generics.
    apart: bool


@dataclass(frozen=True)
class Mutant:
    """`old` at `start` becomes `new`, within the body from `body[0]` to `body[1]` (its braces included)."""
    file: pathlib.Path
    body: tuple
    kind: str
    start: int
    old: str
    new: str


def tokens(text):
    found, at, spaced = [], 0, False
    while at < len(text):
        match = TOKEN.match(text, at)
        if match.lastgroup == "space" or match["space"]:
            spaced = True
        else:
            kind = next(k for k in ("text", "lifetime", "number", "word", "sign") if match[k] is not None)
            after = text[match.end():match.end() + 1]
            found.append(Token(kind, match[0], match.start(), match.end(), spaced and (after.isspace() or after == "")))
            spaced = False
        at = match.end()
    return found


def close_of(found, at):
    """The place of the bracket that closes the one at `at`."""
    depth = 0
    for place in range(at, len(found)):
        if found[place].kind == "sign":
            depth += (found[place].text in "([{") - (found[place].text in ")]}")
        if depth == 0:
            return place
    return len(found) - 1


def past_item(found, at):
    """Behind the item that begins at `at`: its braces or its semicolon."""
    while at < len(found):
        if found[at].text == ";":
            return at + 1
        if found[at].text in OPENS and found[at].kind == "sign":
            closed = close_of(found, at)
            if found[at].text == "{":
                return closed + 1
            at = closed
        at += 1
    return at


def is_operand(token):
    """Whether an operand can end with it."""
    return token.text in (")", "]", "}", "?") or token.kind in ("number", "text") or (token.kind == "word" and token.text not in KEYWORDS)


def without_tests(folder, name):
    """The sources of a module, without what only tests see."""
    files = [f for f in [folder / f"{name}.rs", *sorted((folder / name).rglob("*.rs"))] if f.exists()]
    hidden = []
    for file in files:
        inner = file.parent if file.stem in ("mod", "lib") else file.parent / file.stem
        for found in re.finditer(r"#\[cfg\(test\)\]\s*(?:pub(?:\([a-z]+\))? )?mod (\w+);", file.read_text()):
            hidden += [inner / f"{found[1]}.rs", inner / found[1]]
    return [f for f in files if not any(h == f or h in f.parents for h in hidden)]


def mutants(file):
    """Every mutant of a file, in the order of the text."""
    text = file.read_text()
    found, made, at = tokens(text), [], 0
    while at < len(found):
        token, next_is = found[at], found[at + 1].text if at + 1 < len(found) else ""
        if token.text == "#" and next_is in ("[", "!"):
            closed = close_of(found, at + 1 + (next_is == "!"))
            at = past_item(found, closed + 1) if re.match(r"#\[(cfg\(test\)|test)\]", text[token.start:found[closed].end]) else closed + 1
        elif token.kind == "word" and next_is == "!" and token.text != "_":
            while found[at].text not in OPENS:
                at += 1
            at = close_of(found, at) + 1
        elif token.text in ("const", "static") and next_is != "fn":
            at = past_const(found, at)
        elif token.text == "fn" and at + 1 < len(found) and found[at + 1].kind == "word":
            begins = at + 2
            while found[begins].text not in ("{", ";"):
                begins = close_of(found, begins) + 1 if found[begins].text in ("(", "[") else begins + 1
            if found[begins].text == ";" or found[at - 1].text == "const":
                at = begins + 1
                continue
            ends = close_of(found, begins)
            body = (found[begins].start, found[ends].end)
            if [t.text for t in found[begins - 2:begins]] == ["->", "bool"]:
                made += [Mutant(file, body, "answer", body[0], text[body[0]:body[1]], f"{{ {v} }}") for v in ("true", "false")]
            made += [Mutant(file, body, *change) for change in changes(text, found, begins + 1, ends)]
            at = ends + 1
        else:
            at += 1
    return made


def past_const(found, at):
    """Behind a constant: its semicolon outside every bracket."""
    while at < len(found) and found[at].text != ";":
        at = close_of(found, at) + 1 if found[at].kind == "sign" and found[at].text in OPENS else at + 1
    return at + 1


def changes(text, found, at, end):
    """What one body can become: kind, start, old, new."""
    while at < end:
        token, before, after = found[at], found[at - 1], found[at + 1]
        if token.text == "#" and after.text == "[":
            at = close_of(found, at + 1) + 1
            continue
        if token.kind == "word" and after.text == "!" and found[at + 2].text in OPENS and found[at + 2].start == after.end:
            at = close_of(found, at + 2) + 1
            continue
        if token.text in ("const", "static") and after.kind == "word":
            at = past_const(found, at)
            continue
        if token.text == "use":
            at = past_item(found, at)
            continue
        if token.text == "::" and after.text == "<":
            depth, at = 0, at + 1
            while True:
                depth += (found[at].text == "<") - (found[at].text == ">") - 2 * (found[at].text == ">>")
                at += 1
                if depth <= 0:
                    break
            continue
        if token.kind == "sign" and token.apart and token.text in SWAPS and is_operand(before):
            yield from ((KINDS[token.text[0]], token.start, token.text, new) for new in SWAPS[token.text])
        elif token.text == "!" and not is_operand(before) and after.start == token.end:
            yield "logic", token.start, "!", ""
        elif token.kind == "word" and token.text in NAMES and (before.text in (".", "::")) and after.text in ("(", ")", ","):
            yield "extremum", token.start, token.text, NAMES[token.text]
        elif token.text == "." and after.text in LEFT_OUT and found[at + 2].text == "(":
            closed = found[close_of(found, at + 2)].end
            yield "left out", token.start, text[token.start:closed], ""
        elif token.kind == "number" and before.text not in (".", "::"):
            yield from (("constant", token.start, token.text, new) for new in other_numbers(token.text))
        elif token.text in ("return", "continue"):
            closed = at
            while closed < end and found[closed].text not in (";", "}"):
                closed = close_of(found, closed) + 1 if found[closed].text in OPENS else closed + 1
            if found[closed].text == ";":
                yield "left out", token.start, text[token.start:found[closed].end], ""
        at += 1


def other_numbers(number):
    """Ten times a number, and one more."""
    split = re.fullmatch(r"(0x[0-9a-fA-F_]+?|[\d_]+(?:\.[\d_]*)?(?:e[+-]?\d+)?)(_?[iuf]\d+|_?[iu]size)?", number)
    if not split:
        return []
    digits, suffix = split[1].replace("_", ""), split[2] or ""
    if re.fullmatch(r"0x.*|\d+", digits):
        value = int(digits, 0)
        if suffix.lstrip("_").startswith("f"):
            return [f"{float(v)}{suffix}" for v in dict.fromkeys((value * 10, value + 1))][-1 if value == 0 else 0:]
        return [f"{v}{suffix}" for v in dict.fromkeys((value * 10, value + 1)) if v != value]
    value = float(digits)
    return [f"{v!r}{suffix}" for v in dict.fromkeys((value * 10.0, value + 1.0)) if v != value]
