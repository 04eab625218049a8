"""Labels of a result, for data sets: contacts, forces, events."""
