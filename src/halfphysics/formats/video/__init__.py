"""What estimators of people in video write, one module per program."""
