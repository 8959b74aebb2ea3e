"""The sections of the reports, one file each.

To add a figure or a table, write one file here with one function::

    def section(results: Results) -> Section | None:
        return Section("Its heading", {"file_name": Picture(figure, caption), "other_name": table})

It reads what the runs left (:class:`lawn_sb3.results.results.Results`) and returns None where they do not give it. Then
name it in one of the lists of :mod:`lawn_sb3.report.contents`, at its place on the page; nothing else imports it, and a
file here is nothing but its section. Colours, markers and legends are in :mod:`lawn_sb3.report.style`, tables in
:mod:`lawn_sb3.report.table`; headings, units and digits of the quantities in :mod:`lawn_sb3.results.quantities`.
"""
