"""Text and HTML output: tables, assumptions, reports."""
