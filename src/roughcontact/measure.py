"""Instruments that measure surfaces, and what their maps say of a contact."""

from roughcontact.surface.instrument import Instrument as Instrument
