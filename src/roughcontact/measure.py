"""Virtual instruments: what a measurement changes in a map."""

from roughcontact.surface.instrument import Instrument as Instrument
