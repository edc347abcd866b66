"""Distribution of one map over MPI processes, one row block each."""

from roughcontact.contact.share import Slab as Slab, slab_rows as slab_rows
from roughcontact.formats.slab import read_slab as read_slab
