"""Constants and readings that the paper leaves open, tried one by one against the figures it prints."""

from lawn_sb3.paper.identification.identify import Identification, as_markdown, identify

__all__ = ["Identification", "as_markdown", "identify"]
