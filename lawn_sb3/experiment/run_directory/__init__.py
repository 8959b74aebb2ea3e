"""What a run leaves: ``files`` names every file, ``columns`` what is in it; ``csv_file`` and ``reading`` get them
back whole.

``progress`` is the training curve, and ``configuration`` tells whether a run is the finished one of a cell.
"""
