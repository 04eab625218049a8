"""Motions of estimators and generators put right: floor, drift, sliding feet, what is inside."""
