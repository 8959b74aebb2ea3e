"""Tables, figures and the page: pure functions of what the runs left. How to add one: :mod:`lawn_sb3.report.sections`."""
