"""Who does the work: ``job`` says what work is and how it is told about, ``local`` does it on this machine."""
