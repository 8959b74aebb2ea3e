"""What several learners share: how what a UAV sees is put to its networks."""
