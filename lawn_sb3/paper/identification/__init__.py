"""Constants and readings that the paper leaves open, tried one by one against the figures it prints."""

from lawn_sb3.paper.identification.identify import Identification, identify
from lawn_sb3.paper.identification.page import as_markdown

__all__ = ["Identification", "as_markdown", "identify"]
