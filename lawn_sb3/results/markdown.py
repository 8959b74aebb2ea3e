"""Tables as Markdown, the same whatever is installed beside."""

import pandas as pd
import tabulate

tabulate.WIDE_CHARS_MODE = False  # else columns are wider or narrower where wcwidth is installed, as Jupyter does


def markdown_table(shown: pd.DataFrame) -> str:
    """Write a table of texts as Markdown.

    :param shown: every cell and heading as it is to be shown
    :return: the table, its columns aligned
    """
    return str(shown.to_markdown(index=False, disable_numparse=True))
