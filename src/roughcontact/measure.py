"""Virtual instruments: the effect of a measurement on a map."""

from roughcontact.surface.instrument import Instrument as Instrument
