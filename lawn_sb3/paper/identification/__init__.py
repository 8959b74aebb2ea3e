"""Constants and readings that the paper leaves open, tried one by one against the figures it prints."""

from lawn_sb3.paper.identification.identify import identify
from lawn_sb3.paper.identification.page import as_markdown
from lawn_sb3.paper.identification.result import Identification

__all__ = ["Identification", "as_markdown", "identify"]
