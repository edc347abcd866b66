"""What a joint does, of solved contacts: its law, what it conducts, what leaks; and by formulas."""
