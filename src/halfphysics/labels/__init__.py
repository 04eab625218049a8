"""Labels of a result, for data sets: contacts, forces, events, support (docs/labels.md)."""

from __future__ import annotations

from halfphysics.labels.contact_labels import contact_labels
from halfphysics.labels.event_kinds import Drop, Events, Hold, Limits, Slip
from halfphysics.labels.events import events
from halfphysics.labels.exporters import arctic, behave, chois, omomo
from halfphysics.labels.proximity import Near
from halfphysics.labels.sampling import ObjectSurface
from halfphysics.labels.solver_contacts import SolverContacts
from halfphysics.labels.support_labels import support_labels
from halfphysics.labels.tables import ContactLabels, PersonLabels

__all__ = [
    "ContactLabels",
    "Drop",
    "Events",
    "Hold",
    "Limits",
    "Near",
    "ObjectSurface",
    "PersonLabels",
    "Slip",
    "SolverContacts",
    "arctic",
    "behave",
    "chois",
    "contact_labels",
    "events",
    "omomo",
    "support_labels",
]
