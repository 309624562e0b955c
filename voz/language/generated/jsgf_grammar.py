"""The JSGF grammar of a list of sentences, with common beginnings shared; pure.

https://www.w3.org/TR/jsgf/. pocketsphinx loads a long list of whole sentences slowly; as a tree,
`go ( forward | back )`, it is many times smaller. Weights make all sentences equally likely.
"""

from __future__ import annotations

from collections.abc import Iterable

GRAMMAR_NAME = "comandos_voz"


class _Node(dict[str, "_Node"]):
    """The words that can follow a beginning; `ends` says that it is a sentence."""

    ends = False


def jsgf(sentences: Iterable[str]) -> str:
    """Write a JSGF file whose public rule `<command>` accepts exactly these sentences."""
    rule = "\n    | ".join(tree_alternatives(sentences))
    return f"#JSGF V1.0;\n\ngrammar {GRAMMAR_NAME};\n\npublic <command> =\n      {rule}\n    ;\n"


def tree_alternatives(sentences: Iterable[str]) -> list[str]:
    """Write the alternatives of some sentences, with common beginnings shared."""
    return _alternatives(_tree(sentences))[0]


def _tree(sentences: Iterable[str]) -> _Node:
    root = _Node()
    for sentence in sentences:
        node = root
        for word in sentence.split():
            node = node.setdefault(word, _Node())
        node.ends = True
    return root


def _alternatives(node: _Node) -> tuple[list[str], int]:
    """Write what can follow a prefix, and count the sentences."""
    written = [(word, *_rest(child)) for word, child in node.items()]
    alone = len(written) == 1 and not node.ends
    texts = [
        (f"/{count}/ " if count > 1 and not alone else "") + word + rest
        for word, rest, count in written
    ]
    return texts, node.ends + sum(count for _, _, count in written)


def _rest(node: _Node) -> tuple[str, int]:
    texts, count = _alternatives(node)
    joined = " | ".join(texts)
    if not texts:
        return "", count
    if node.ends:
        return f" [ {joined} ]", count
    return (f" ( {joined} )" if len(texts) > 1 else f" {joined}"), count
