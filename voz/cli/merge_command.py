"""`voz merge`: joins the outputs of shards."""

from __future__ import annotations

from typing import Annotated

import typer

from voz.cli.options import OverwriteOption
from voz.cli.text_io import info


def merge(
    shards: Annotated[
        list[str], typer.Argument(metavar="SHARD...", help="The outputs of all shards.")
    ],
    out: Annotated[str, typer.Option(metavar="FILE", help="Where the whole goes.")],
    overwrite: OverwriteOption = False,
) -> None:
    """Put the outputs of `voz decode --shard` together, in the order of the input.

    The whole is the same file that one run would have made.

    Example: voz merge heard-*.jsonl --out heard.jsonl
    """
    from voz.apps.batch.locations import check_output
    from voz.apps.batch.merging import merge as merge_shards
    from voz.files import check_not_read

    check_not_read([out], shards)
    check_output(out, overwrite)
    count = merge_shards(shards, out)
    info(f"written: {out}, {count:,} recordings")
