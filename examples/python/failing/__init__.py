"""The failures of failures.py, by kind."""
