"""Long campaigns, each a command of minutes: ``make torture`` runs all. Their short forms are tests."""
