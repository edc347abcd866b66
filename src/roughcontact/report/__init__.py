"""Results in words: tables, assumptions, reports."""
