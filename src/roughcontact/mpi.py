"""Distribute one map over MPI processes, a band of rows each."""

from roughcontact.contact.share import Slab as Slab, slab_rows as slab_rows
from roughcontact.formats.slab import read_slab as read_slab
