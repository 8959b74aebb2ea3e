"""Flying and planning what claims and the price of anarchy rest on besides the runs, before a report."""

from lawn_sb3.paper.making.make import fly_checks

__all__ = ["fly_checks"]
