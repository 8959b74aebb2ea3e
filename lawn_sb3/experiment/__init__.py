"""Recipes, cells and runs: train, evaluate, reproduce."""
