"""YAML with the places of its parts, for errors; pure."""

from __future__ import annotations

from typing import NoReturn

import yaml

from voz.language.formats.parser import Passage
from voz.language.formats.text_lines import numbered_lines
from voz.language.sentences.location import Location, error_at


class Yaml:
    """A YAML file; its methods raise CommandsError where something else is expected."""

    def __init__(self, data: bytes, name: str) -> None:
        """Parse it; raises CommandsError."""
        self.name = name
        self._lines = [line for _, line in numbered_lines(data, name)]
        try:
            root = yaml.compose("\n".join(self._lines), Loader=yaml.SafeLoader)
        except yaml.MarkedYAMLError as error:
            self._broken(error)
        except (yaml.YAMLError, RecursionError) as error:
            raise error_at(Location(name, 1), f"invalid YAML ({error})") from None
        if root is None:
            raise error_at(Location(name, 1), "is empty; write intents and their sentences")
        self.root = root

    def _broken(self, error: yaml.MarkedYAMLError) -> NoReturn:
        mark = error.problem_mark
        line = min(mark.line, len(self._lines) - 1) if mark else 0
        place = Location(self.name, line + 1, mark.column + 1 if mark else 0, self._lines[line])
        raise error_at(place, f"invalid YAML: {error.problem or error.context}") from None

    def place(self, node: yaml.Node) -> Location:
        """Return where a part begins."""
        return self.text(node).place() if isinstance(node, yaml.ScalarNode) else self._begin(node)

    def _begin(self, node: yaml.Node) -> Location:
        mark = node.start_mark
        return Location(self.name, mark.line + 1, mark.column + 1, self._lines[mark.line])

    def mapping(self, node: yaml.Node, what: str) -> dict[str, yaml.Node]:
        """Return the parts of a mapping by name; messages call it `what`."""
        if not isinstance(node, yaml.MappingNode):
            raise error_at(self.place(node), f"expected {what}, as in: name: ...")
        return {self.text(key).text: value for key, value in node.value}

    def sequence(self, node: yaml.Node, what: str) -> list[yaml.Node]:
        """Return the parts of a sequence; messages call them `what`."""
        if not isinstance(node, yaml.SequenceNode):
            raise error_at(self.place(node), f'expected {what}, one per line after "-"')
        return list(node.value)

    def text(self, node: yaml.Node) -> Passage:
        """Return a text with its place."""
        mark = node.start_mark
        if not isinstance(node, yaml.ScalarNode):
            raise error_at(self._begin(node), "expected a text")
        quoted = 1 if node.style in ("'", '"') else 0
        text = " ".join(str(node.value).split("\n"))
        return Passage(
            self.name, mark.line + 1, mark.column + quoted, text, self._lines[mark.line] or " "
        )
