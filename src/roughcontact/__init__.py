"""Contact of measured rough surfaces: pressure, real contact area, saturated area and gap."""

__version__ = "0.1.0"
