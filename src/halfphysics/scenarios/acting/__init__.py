"""How people move in the scenarios: gait, reach, grip, hands."""
