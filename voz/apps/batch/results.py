"""An output of `voz decode` as a table of pandas."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING

import msgspec

from voz.apps.batch.formats import NUMBER_COLUMNS, open_records
from voz.apps.batch.outcomes import COLUMNS
from voz.extras import require
from voz.records import check_path

if TYPE_CHECKING:
    import pandas as pd


def read_results(output: str | PathLike[str]) -> pd.DataFrame:
    """Read an output of `voz decode --out` into a DataFrame, the same one whatever its format.

    Args:
        output: a file that ends with .jsonl, .csv or .parquet, or an address of one.

    Returns:
        A row for each utterance, silent or unreadable recording; the columns of a manifest are
        beside the others. `attrs["header"]` is what the output was made by.

    Raises:
        ConfigError: it is not an output, or pandas is not installed.
    """
    require("pandas", "pandas")
    import pandas as pd

    name = check_path(output, "output")
    with open_records(name) as (header, records):
        columns = [*COLUMNS, *header.details, *header.columns]
        table = pd.DataFrame.from_records(list(records), columns=columns)
    table = table.astype({**dict.fromkeys(NUMBER_COLUMNS, "float64"), "accepted": "boolean"})
    table.attrs["header"] = msgspec.to_builtins(header)
    return table
