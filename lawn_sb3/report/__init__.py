"""Tables, figures and the page: pure functions of what the runs left. Section by section: :mod:`.sections`."""
