"""Grammars in JSGF, https://www.w3.org/TR/jsgf/; pure.

What has tags in a rule is a slot of its name, and the tags are its values. Of a file with one
public rule each alternative is a command, which is called as the rule that it consists of or by
its own words; of several public rules each is one. Weights are left out: every sentence is as
likely as any other.
"""

from __future__ import annotations

import re

from voz.language.formats.parser import Parser, Token
from voz.language.sentences.expression import (
    NO_WORDS,
    Choice,
    Expression,
    Optional,
    Reference,
    Slot,
    Tag,
    children,
    choice,
    concatenation,
    parse_value,
    references,
    with_children,
)
from voz.language.sentences.templates import Advice, Template, TemplateSource
from voz.language.sentences.text_lines import Faults, Location, Passage, error_at, numbered_lines

_TAG = r"\{(?:\\.|[^{}\\])*\}"
_QUOTED = r"\"[^\"]*\""
_COMMENT = re.compile(rf"({_TAG}|{_QUOTED})|//[^\n]*|/\*.*?\*/", re.DOTALL)
_HEADER = re.compile(r"\s*(?:#JSGF[^;\n]*(;?))?\s*(?:grammar\s+([\w.-]+)[^\S\n]*(;?))?")
_VISIBLE = re.compile(r"\S")
_IMPORT = re.compile(r"\s*import\b")
_HEAD = r"(public\s+)?<([^<>\s]+)>\s*="
_JSGF_RULE = re.compile(rf"\s*{_HEAD}((?:[^;{{\"]|{_TAG}|{_QUOTED})*)(;|\Z)")
_NEXT_RULE = re.compile(rf"(?m:^)\s*(?={_HEAD})")
_WEIGHT = re.compile(r"/\s*([0-9.]+(?:[eE][-+]?[0-9]+)?)\s*/")


JSGF_ADVICE = Advice(
    rule="<NAME> = red | green;",
    list="<NAME> = red | green;",
    sentence="write rules, as in: public <command> = stop;",
    name="give all of it a tag, as in: (one | two) {number}, or tags to what differs",
)


class JsgfParser(Parser):
    """Parses the right side of a rule."""

    TOKEN = re.compile(
        r"(?P<tag>\{(?:\\.|[^{}\\])*\})|(?P<rule><[^<>]*>)|(?P<weight>/[^/\n]*/)"
        r"|(?P<quoted>\"[^\"]*\")|(?P<repeat>[*+])|(?P<mark>[()\[\]{}<>|])"
        r"|(?P<word>[^\s()\[\]{}<>|/\"*+;]+)"
    )

    def __init__(self, passage: Passage, grammar: str) -> None:
        """Split a passage; the name of the grammar may prefix those of its rules."""
        super().__init__(passage)
        self._prefix = f"{grammar}."

    def item(self, items: list[Expression]) -> None:
        """Parse one more item; a tag applies to the one before it, at the end to all before it."""
        token = self.next
        if token.kind == "weight":
            self._weight(self.take())
        elif token.kind == "repeat":
            how = "a | a a" if token.text == "+" else "[a | a a]"
            self.fail(f'"{token.text}" repeats without end; write out how often: {how}', token.at)
        elif token.kind == "tag":
            if not items:
                self.fail("no words before this tag", token.at)
            self.take()
            value = parse_value(re.sub(r"\\(.)", r"\1", token.text[1:-1]).strip())
            ends = self.next.kind == "end" or self.ends()
            before = concatenation(items[:]) if ends else items.pop()
            items[:] = [Tag(before, value)] if ends else [*items, Tag(before, value)]
        else:
            items.append(self.atom())

    def _weight(self, token: Token) -> None:
        if not _WEIGHT.fullmatch(token.text):
            self.fail(f"{token.text} is not a weight, as /0.5/; remove it", token.at)

    def other(self, token: Token) -> Expression:
        """Parse a rule's name, or words in quotes."""
        if token.kind == "rule":
            name = token.text[1:-1].strip().removeprefix(self._prefix)
            if name == "NULL":
                return NO_WORDS
            if name == "VOID":
                self.fail("<VOID> never matches; remove this alternative", token.at)
            return Reference("rule", name, self.passage.place(token.at))
        if token.kind == "quoted":
            words = [
                self.word(Token("word", match.group(), token.at + 1 + match.start(), True))
                for match in re.finditer(r"\S+", token.text[1:-1])
            ]
            return concatenation(words)
        return super().other(token)


def parse_jsgf(data: bytes, name: str) -> TemplateSource:
    """Parse a grammar, UTF-8; `name` is for messages. Raises CommandsError."""
    text = "\n".join(line for _, line in numbered_lines(data, name))
    text = _COMMENT.sub(lambda found: found[1] or re.sub(r"[^\n]", " ", found.group()), text)
    whole = Passage(name, 1, 0, text)
    header = _HEADER.match(text)
    at, grammar = (header.end(), header[2] or "") if header else (0, "")
    for ends in (1, 3):
        if header and header[ends] == "":
            raise error_at(whole.place(header.start(ends) - 1), 'write ";" at the end of this line')
    source = TemplateSource(name, lenient=True, advice=JSGF_ADVICE)
    public: list[tuple[str, Expression, Location]] = []
    faults = Faults()
    while found := _VISIBLE.search(text, at):
        at = found.start()
        if _IMPORT.match(text, at):
            raise error_at(whole.place(at), "imports are not supported; copy the rules here")
        match = _JSGF_RULE.match(text, at)
        if not match:
            raise error_at(whole.place(at), "expected a rule, as in: <color> = red | green;")
        place = whole.place(at)
        following = _NEXT_RULE.search(text, match.start(3), match.end(3))
        if following or not match[4]:
            raise error_at(place, f'the rule <{match[2]}> does not end; write ";" at its end')
        at = match.end()
        rule = match[2].removeprefix(f"{grammar}.")
        with faults:
            body = JsgfParser(_part(whole, match.start(3), match.end(3)), grammar).parse()
            if match[1]:
                public.append((rule, body, place))
            source.define("rule", rule, _slot(rule, body, place), place)
    faults.check()
    if not public:
        raise error_at(Location(name, 1), 'no rule is public; write "public" before one')
    _add_public(source, public)
    if names := [f'"{one.command}"' for one in source.templates if _is_of_many(source, one)]:
        source.warnings.append(
            f"{name}: {', '.join(names)}: one command each, whatever of its alternatives is said; "
            "tags tell them apart, as in: <way> = up {up} | down {down};"
        )
    return source


def _is_of_many(source: TemplateSource, template: Template) -> bool:
    """Whether a command has alternatives that are in no slot."""
    if template.command is None:
        return False
    choices = [one for one in _parts(source, template.expression) if isinstance(one, Choice)]
    return any(not one.synonyms and _are_untold(source, one) for one in choices)


def _are_untold(source: TemplateSource, choices: Choice) -> bool:
    """Whether two or more alternatives have no slot."""
    each = (_parts(source, one) for one in {*choices.items} - {NO_WORDS})
    return sum(not any(isinstance(part, Slot) for part in parts) for parts in each) > 1


def _parts(source: TemplateSource, item: Expression) -> list[Expression]:
    """List an expression and all in it and in the rules that it names, but not in slots."""
    parts, seen = [item], set()
    for part in parts:  # grows
        if isinstance(part, Reference):
            rule = source.definitions.get(("rule", part.name))
            if rule and part.name not in seen:
                parts.append(rule.expression)
            seen.add(part.name)
        elif not isinstance(part, Optional | Slot):
            parts += children(part)
    return parts


def _part(whole: Passage, start: int, end: int) -> Passage:
    place = whole.place(start)
    return Passage(whole.file, place.line, place.column - 1, whole.text[start:end], place.text)


def _slot(name: str, item: Expression, place: Location) -> Expression:
    """Put what has tags into slots of the rule's name; the tags are their values."""
    if not _has_tag(item):
        return item
    if isinstance(item, Tag) or (isinstance(item, Choice) and not any(map(_holds_tag, item.items))):
        return Slot(name, item, place)
    if isinstance(item, Choice):  # beside alternatives with tags the words of others are values
        return choice(
            [
                _slot(name, one, place) if _has_tag(one) else Slot(name, one, place)
                for one in item.items
            ]
        )
    return with_children(item, lambda one: _slot(name, one, place))


def _has_tag(item: Expression) -> bool:
    return isinstance(item, Tag) or _holds_tag(item)


def _holds_tag(item: Expression) -> bool:
    return not isinstance(item, Tag) and any(map(_has_tag, children(item)))


def _add_public(source: TemplateSource, public: list[tuple[str, Expression, Location]]) -> None:
    """Turn public rules into commands; they stay rules if others name them."""
    bodies = [definition.expression for definition in source.definitions.values()]
    named = {found.name for body in bodies for found in references(body)}
    for name, body, place in public:
        if name not in named:
            del source.definitions["rule", name]
        if len(public) > 1:
            source.templates.append(Template(name, _slot(name, body, place), place))
            continue
        for one in body.items if isinstance(body, Choice) else (body,):
            command = one.name if isinstance(one, Reference) else None
            if isinstance(one, Tag):
                command, one = str(one.value), one.item
            source.templates.append(Template(command, _slot(name, one, place), place))
