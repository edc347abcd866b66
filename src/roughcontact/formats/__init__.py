"""File formats: reading of maps, writing of maps, contacts and volumes."""
