"""Trainers of other projects beside ours: the same game, the same networks, the same budget (``make peers``)."""
